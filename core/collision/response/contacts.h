// Contacts of one configuration, the share of the force that each carries, and the force law.
#pragma once

#include <vector>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/model/contact.h"

namespace loomstone {

// Contacts closer than their thickness at x, sorted by (kind, a, b). Updates the distances in the
// lists.
std::vector<Contact> find_contacts(const Team& team, const CollisionModel& model,
                                   const std::vector<SurfacePair>& pairs, const Points& x,
                                   NeighbourLists& lists);

// Share [1] of each contact in [0, 1], which counts each touch once and keeps forces continuous in
// x. A vertex above the common edge of two faces has a contact with each; they share the force
// according to the similarity of their normals and forces. Shares of edges fade to 0 where the
// closest point approaches an end or the edges become parallel: vertex contacts take over. Shares
// are constant within a step: energies and derivatives are those of springs scaled by them.
std::vector<double> contact_shares(const std::vector<Contact>& contacts,
                                   const CollisionModel& model, const Points& x0);

// Two-stage law of a full contact: force k (xi - d) down to half the thickness, k (xi/2)^2 / d
// below (method.md, contact terms).
struct ContactForce {
  double force;      // [N]
  double stiffness;  // -d force / d distance [N/m]
  double energy;     // [J]
};
ContactForce contact_force(double distance, double thickness, double stiffness);

}  // namespace loomstone
