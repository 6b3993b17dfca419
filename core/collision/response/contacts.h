// Contacts of one configuration and what share of a full contact each carries.
#pragma once

#include <vector>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// Contacts closer than their thickness at x, sorted by (kind, a, b); fills the distances of the
// lists.
std::vector<Contact> find_contacts(const Team& team, const CollisionModel& model,
                                   const std::vector<SurfacePair>& pairs, const Points& x,
                                   NearLists& lists);

// Share [1] of each contact in (0, 1], so that one touch is counted once and forces stay continuous
// in x. A vertex above a common edge of two faces has a contact with each: they share (in
// proportion to how alike normals and forces are). Edges fade out where the closest point nears an
// end or the edges become parallel: there contacts of vertices take over. Constant within a step:
// energies and their derivatives are those of springs scaled by it.
std::vector<double> contact_shares(const std::vector<Contact>& contacts,
                                   const CollisionModel& model, const Points& x0);

// Two-stage contact energy per unit share: k (xi - d) down to half the thickness, k (xi/2)^2 / d
// below. [N, N/m, J]
struct ContactForce {
  double force, stiffness, energy;
};
ContactForce contact_force(double distance, double thickness, double stiffness);

}  // namespace loomstone
