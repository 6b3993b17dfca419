#include "core/rigid/squeezed_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/rigid/step_motion.h"

namespace loomstone {

namespace {

// Stiffness of a contact point divided by the width of the body [Pa]. Our choice: the four contact
// points on a side of a cube then have the stiffness of a cube of 200 MPa (soft plastics).
constexpr btScalar modulus = 1e8;
// Overlap that counts as rounding, as a fraction of the width of the body.
constexpr btScalar rounding = 1e-4;
// Largest overlap that counts as squeezed, as a fraction of the width of the body. Our choice:
// bodies that overlap more have partly passed a surface.
constexpr btScalar deepest_squeeze = 0.2;
// Smallest cosine of the angle between normals of contacts of one group, and largest cosine of the
// angle between the normals of opposite groups. Our choice: the two surfaces that squeeze a body
// may be inclined to each other by 14 degrees.
constexpr btScalar parallel = 0.99, opposite = -0.97;
constexpr btScalar infinite = std::numeric_limits<btScalar>::infinity();

// A contact seen from one of its two bodies. The normal points to this body.
struct ContactSide {
  int body;  // index of the solver's body
  int row;
  btVector3 normal, point;
  int group = -1;
};

// Contacts of a body with nearly equal normals.
struct ContactGroup {
  int body;
  btVector3 normal;                    // of the first contact
  btScalar friction = infinite;        // smallest friction coefficient [1]
  btScalar depth = -infinite;          // of the deepest held contact [m]
  btVector3 centre = {0.0, 0.0, 0.0};  // centre of pressure if each contact were a spring [m]
  btScalar weight = 0.0;               // sum of the weights of the contacts in `centre` [m]
  std::vector<int> opposites = {};     // groups on the opposite side of the body
};

// The contacts of a solver. Depths are overlaps, negative for gaps [m]. A contact is held if each
// of its bodies has a held contact on the opposite side, the two depths have a positive sum, and a
// chain of held contacts leads to an obstacle. Obstacles hold every contact.
class ContactNetwork {
 public:
  explicit ContactNetwork(const ContactRows& contacts) : contacts_(contacts) {
    for (int i = 0; i < contacts.rows.size(); ++i) {
      depths_.push_back(-point_of(i).getDistance());
      add_side(contacts.rows[i].m_solverBodyIdA, i, contacts.rows[i].m_contactNormal1);
      add_side(contacts.rows[i].m_solverBodyIdB, i, contacts.rows[i].m_contactNormal2);
    }
    std::ranges::stable_sort(sides_, {}, &ContactSide::body);
    held_.assign(depths_.size(), true);
    if (std::ranges::none_of(depths_, [](btScalar depth) { return depth > 0.0; })) {
      sides_.clear();
      return;
    }
    make_groups();
    while (release()) continue;
    release_unreached();
  }

  const std::vector<ContactSide>& sides() const { return sides_; }
  bool held(int row) const { return held_[row]; }
  btScalar depth(int row) const { return depths_[row]; }
  // Returns the opposite group with the deepest held contact; null if there is none.
  const ContactGroup* deepest_opposite(const ContactSide& side) const {
    const ContactGroup* found = nullptr;
    for (const int g : groups_[side.group].opposites)
      if (groups_[g].depth > (found ? found->depth : -infinite)) found = &groups_[g];
    return found;
  }
  // Returns the distance between the centres of the group of `side` and the opposite group `other`,
  // along the normal of `side` [m].
  btScalar width(const ContactSide& side, const ContactGroup& other) const {
    return std::abs(side.normal.dot(groups_[side.group].centre - other.centre));
  }

 private:
  const btManifoldPoint& point_of(int row) const {
    return *static_cast<const btManifoldPoint*>(contacts_.rows[row].m_originalContactPoint);
  }
  void add_side(int body, int row, const btVector3& normal) {
    const btRigidBody* const original = contacts_.bodies[body].m_originalBody;
    if (original && !original->isStaticOrKinematicObject())
      sides_.push_back({body, row, normal, point_of(row).getPositionWorldOnB()});
  }

  void make_groups() {
    std::size_t first = 0;  // group of the current body
    for (ContactSide& side : sides_) {
      if (first < groups_.size() && groups_[first].body != side.body) first = groups_.size();
      std::size_t g = first;
      while (g < groups_.size() && groups_[g].normal.dot(side.normal) < parallel) ++g;
      if (g == groups_.size()) groups_.push_back({side.body, side.normal});
      groups_[g].friction = std::min(groups_[g].friction, point_of(side.row).m_combinedFriction);
      groups_[g].depth = std::max(groups_[g].depth, depths_[side.row]);
      side.group = static_cast<int>(g);
    }
    for (const ContactSide& side : sides_) {
      ContactGroup& group = groups_[side.group];
      const btRigidBody& body = *contacts_.bodies[side.body].m_originalBody;
      const btScalar room = rounding * 2.0 * inner_radius(*body.getCollisionShape());
      const btScalar weight =
          std::max(depths_[side.row] - std::min(group.depth, btScalar(0)) + room, btScalar(0));
      group.centre += weight * side.point, group.weight += weight;
    }
    for (ContactGroup& group : groups_) group.centre /= group.weight;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t h = g + 1; h < groups_.size() && groups_[h].body == groups_[g].body; ++h)
        if (are_opposite(groups_[g], groups_[h])) {
          groups_[g].opposites.push_back(static_cast<int>(h));
          groups_[h].opposites.push_back(static_cast<int>(g));
        }
  }
  // Two groups squeeze a body if their normals are opposite and the line between their centres lies
  // in both cones of friction. Otherwise, they turn the body or push it out. The tolerance of the
  // cones is that of parallel normals.
  static bool are_opposite(const ContactGroup& a, const ContactGroup& b) {
    const btVector3 line = b.centre - a.centre;
    const btScalar slope = std::min(a.friction, b.friction) + std::sqrt(1.0 - parallel * parallel);
    const auto in_cone = [&](btScalar along) {
      return along > 0.0 && line.length2() <= (1.0 + slope * slope) * along * along;
    };
    return a.normal.dot(b.normal) < opposite && in_cone(a.normal.dot(line)) &&
           in_cone(-b.normal.dot(line));
  }

  // Releases contacts that one of their bodies does not hold: sets their held_ to false. Returns
  // whether there were any.
  bool release() {
    for (ContactGroup& group : groups_) group.depth = -infinite;
    for (const ContactSide& side : sides_)
      if (held_[side.row])
        groups_[side.group].depth = std::max(groups_[side.group].depth, depths_[side.row]);
    bool any = false;
    for (const ContactSide& side : sides_) {
      if (!held_[side.row]) continue;
      const ContactGroup* const other = deepest_opposite(side);
      if (!other || depths_[side.row] + other->depth <= 0.0) held_[side.row] = false, any = true;
    }
    return any;
  }
  // Releases contacts that no chain of held contacts joins to an obstacle, such as contacts between
  // bodies in a ring.
  void release_unreached() {
    std::vector<int> n_sides(depths_.size(), 0);
    for (const ContactSide& side : sides_) ++n_sides[side.row];
    std::vector<bool> reached(depths_.size()), reached_group(groups_.size());
    for (std::size_t i = 0; i < reached.size(); ++i) reached[i] = held_[i] && n_sides[i] == 1;
    for (bool any = true; any;) {
      any = false;
      for (const ContactSide& side : sides_)
        if (reached[side.row])
          for (const int g : groups_[side.group].opposites) reached_group[g] = true;
      for (const ContactSide& side : sides_)
        if (held_[side.row] && !reached[side.row] && reached_group[side.group])
          reached[side.row] = true, any = true;
    }
    held_ = reached;
  }

  const ContactRows& contacts_;
  std::vector<btScalar> depths_;      // (rows)
  std::vector<ContactSide> sides_;    // sorted by body; empty: no contact overlaps
  std::vector<ContactGroup> groups_;  // sorted by body
  std::vector<bool> held_;            // (rows)
};

}  // namespace

std::vector<btScalar> relieve_squeezed(const ContactRows& contacts, btScalar step) {
  const int n = contacts.rows.size();
  const ContactNetwork network(contacts);
  // For each contact: the mean of its depth and that of the deepest opposite contact, the larger of
  // these two depths, and the width of the body. If the contact has two bodies: the smaller mean,
  // the larger depth and the smaller width. Infinite width: the contact is not held.
  std::vector<btScalar> means(n, infinite), deepest(n, 0.0), widths(n, infinite);
  for (const ContactSide& side : network.sides()) {
    if (!network.held(side.row)) continue;
    const ContactGroup& other = *network.deepest_opposite(side);
    const btScalar depth = network.depth(side.row), mean = 0.5 * (depth + other.depth);
    means[side.row] = std::min(means[side.row], mean);
    deepest[side.row] = std::max({deepest[side.row], depth, other.depth});
    widths[side.row] = std::min(widths[side.row], network.width(side, other));
  }
  std::vector<btScalar> impulses(n, 0.0);
  for (int i = 0; i < n; ++i) {
    if (widths[i] == infinite) continue;
    const btScalar squeeze = means[i] - rounding * widths[i];
    if (squeeze <= 0.0 || deepest[i] > deepest_squeeze * widths[i]) continue;
    impulses[i] = modulus * widths[i] * squeeze * step;
    if (const btScalar depth = network.depth(i); depth > 0.0)
      contacts.rows[i].m_rhsPenetration *= std::max(depth - means[i], btScalar(0)) / depth;
  }
  return impulses;
}

}  // namespace loomstone
