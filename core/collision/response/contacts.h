// Contacts of one configuration, their shares and stiffness, and the force law.
#pragma once

#include <vector>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/broad_phase/shared_search.h"
#include "core/collision/model/contact.h"
#include "core/collision/response/found_contacts.h"
#include "core/collision/response/smooth_normals.h"

namespace loomstone {

// Size of the data that a rank sends to the others for each contact that it has found [bytes].
inline constexpr std::size_t bytes_of_found_contact = 80;

// Contacts that a rank keeps, and totals of the contacts of all ranks.
struct ContactSet {
  std::vector<Contact> contacts;  // sorted by (kind, a, b)
  ContactTotals all;
};

// Inputs of a search for contacts, except positions.
struct ContactSearch {
  const CollisionModel& model;
  const std::vector<SurfacePair>& pairs;
  SmoothNormals& normals;
  ContactSelection* selection = nullptr;  // null: every rank keeps all contacts
};

// Collective. Finds the contacts at x. Each rank tests the feature pairs in its lists and those
// that it finds for unlisted surface pairs (see neighbour_lists.h). It then receives the contacts
// of all ranks. Stores in `lists` the distances that it computes for listed pairs. update() or
// begin_update() of `lists` must have been called with x.
ContactSet find_contacts(const Team& team, const ContactSearch& search, const Points& x,
                         NeighbourLists& lists);
// Collective. Returns the same contacts as the function above, but uses no lists. Instead, the
// ranks divide the traversal of the trees of `shared` among themselves.
ContactSet find_contacts(const Team& team, const ContactSearch& search, const Points& x,
                         SharedSearch& shared);
// Returns the contacts of all ranks. Not collective: the calling rank searches all surface pairs
// and uses no lists. `broad_phase` must search the tasks of all ranks (default TaskShare).
ContactSet find_contacts_alone(const Team& team, const ContactSearch& search, const Points& x,
                               BroadPhase& broad_phase);

// Returns the share [1] of each contact, in [0, 1]. Shares prevent double counting. If the closest
// point of a vertex on a face lies on an edge or corner that also belongs to a nearer face in
// contact with this vertex, the contact has the share 0. If two faces are equally near, the one
// with the smaller id counts as nearer. The remaining contacts of a vertex with faces of one
// surface divide their force among themselves. One of them with normal n and force F has the share
// 1 / (1 + S), where S is the sum of max(0, n.n')^2 min(1, F'/F) over the others, with normals n'
// and forces F' (all forces at the same stiffness).
// Shares of edge contacts fade to 0 where a closest point approaches an end of its edge or the
// edges become parallel, because vertex contacts take over there. Shares are constant within a
// part of a step. Energies and derivatives are those of the force law, scaled by the shares.
// `x0` contains the positions at which the contacts were found.
std::vector<double> contact_shares(const std::vector<Contact>& contacts,
                                   const CollisionModel& model, const Points& x0);

// Returns the stiffness of each contact in the normal direction [N/m]. Let k be the contact
// stiffness of the model and xi the thickness. A force presses each of the two features towards the
// other; let F be the larger of these two forces. At half the thickness, the force law with the
// stiffness k gives 3/8 k xi. If F is at most this force, the stiffness is k. If F is larger, the
// stiffness is 16/3 F / xi - k, but at most 1e4 k. Below this bound, the force law thus gives at
// least F at half the thickness. `forces` (cloth vertices x 3) [N] act on the cloth. A feature that
// is not free cloth counts as not pressed. If `forces` has 0 rows, the stiffness is k everywhere.
std::vector<double> contact_stiffness(const std::vector<Contact>& contacts,
                                      const CollisionModel& model, const Vector& inverse_mass,
                                      const Points& forces);

// Force law of a contact with share 1 (method.md, Contact terms). Let k be the argument `stiffness`
// of contact_force(). The force begins quadratically where the distance d falls below the thickness
// xi. Between 3/4 xi and xi/2, it is linear with the stiffness k. Below xi/2, it is
// k (xi/2)^2 / d - k xi/8. A distance below 1e-6 xi is replaced by 1e-6 xi. Force and stiffness are
// continuous.
struct ContactForce {
  double force;      // [N]
  double stiffness;  // -d force / d distance [N/m]
  double energy;     // [J]
};
ContactForce contact_force(double distance, double thickness, double stiffness);

}  // namespace loomstone
