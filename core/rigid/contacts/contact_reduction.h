// Reduces the contacts in one plane to the few that the contact solver receives. Independent of
// Bullet.
#pragma once

#include <vector>

#include "core/rigid/contacts/hull_contacts.h"

namespace loomstone {

// Reduces the contacts in one plane to at most four that support the hull as all of them would. The
// contacts have gaps of at most `near` [m]. Gaps that differ by less than `margin` [m] count as
// equal. `before` contains the contacts of the previous step, whose `point` lies on the hull
// instead of the triangle.
void reduce_contacts(std::vector<HullContact>& contacts, double near, double margin,
                     const std::vector<HullContact>& before);

}  // namespace loomstone
