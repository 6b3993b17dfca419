#include "core/rigid/squeezed_contacts.h"

#include <algorithm>
#include <limits>

#include "core/rigid/step_motion.h"

namespace loomstone {

namespace {

// Elastic modulus of bodies [Pa]. Our choice: that of hard rubber and soft plastics.
constexpr btScalar modulus = 1e8;
// Overlap that counts as rounding, as a fraction of the body's smallest side.
constexpr btScalar rounding = 1e-4;
// Largest overlap that counts as squeezed, in the same unit. Our choice: bodies that overlap more
// have partly passed a surface.
constexpr btScalar deepest_squeeze = 0.2;
// Largest cosine of the angle between the normals of opposite contacts.
constexpr btScalar opposite = -0.9;
constexpr btScalar infinite = std::numeric_limits<btScalar>::infinity();

// A contact seen from one of its two bodies. The normal points to this body.
struct ContactSide {
  int body;  // index of the solver's body
  int row;
  btVector3 normal;
};

// The contacts of a solver. Depths are overlaps, negative for gaps [m].
class ContactNetwork {
 public:
  explicit ContactNetwork(const ContactRows& contacts) : contacts_(contacts) {
    for (int i = 0; i < contacts.rows.size(); ++i) {
      const btSolverConstraint& row = contacts.rows[i];
      depths_.push_back(
          -static_cast<const btManifoldPoint*>(row.m_originalContactPoint)->getDistance());
      if (dynamic_body(row.m_solverBodyIdA))
        sides_.push_back({row.m_solverBodyIdA, i, row.m_contactNormal1});
      if (dynamic_body(row.m_solverBodyIdB))
        sides_.push_back({row.m_solverBodyIdB, i, row.m_contactNormal2});
    }
    std::ranges::stable_sort(sides_, {}, &ContactSide::body);
    find_opposites();
    held_.assign(depths_.size(), true);
    while (release()) continue;
  }

  int n_sides() const { return static_cast<int>(sides_.size()); }
  const ContactSide& side(int s) const { return sides_[s]; }
  btScalar depth(int row) const { return depths_[row]; }
  // Returns the depth of the deepest contact on the opposite side of the body among those that
  // chains of contacts join to obstacles; -infinity if there is none.
  btScalar opposite_depth(int s) const {
    btScalar deepest = -infinite;
    for (int k = opposite_start_[s]; k < opposite_start_[s + 1]; ++k)
      if (held_[opposites_[k]]) deepest = std::max(deepest, depths_[opposites_[k]]);
    return deepest;
  }
  // Returns the smallest side of the body's bounding box [m].
  btScalar size(int s) const {
    return 2.0 * inner_radius(*dynamic_body(sides_[s].body)->getCollisionShape());
  }

 private:
  const btRigidBody* dynamic_body(int index) const {
    const btRigidBody* body = contacts_.bodies[index].m_originalBody;
    return body && !body->isStaticOrKinematicObject() ? body : nullptr;
  }
  void find_opposites() {
    for (const ContactSide& side : sides_) {
      opposite_start_.push_back(static_cast<int>(opposites_.size()));
      for (const ContactSide& other :
           std::ranges::equal_range(sides_, side.body, {}, &ContactSide::body))
        if (other.normal.dot(side.normal) < opposite) opposites_.push_back(other.row);
    }
    opposite_start_.push_back(static_cast<int>(opposites_.size()));
  }
  // Marks a contact as not held if one of its bodies has no held contact on the opposite side.
  // Returns whether it has marked any.
  bool release() {
    bool any = false;
    for (int s = 0; s < n_sides(); ++s)
      if (held_[sides_[s].row] && opposite_depth(s) == -infinite)
        held_[sides_[s].row] = false, any = true;
    return any;
  }

  const ContactRows& contacts_;
  std::vector<btScalar> depths_;     // (rows)
  std::vector<ContactSide> sides_;   // sorted by body
  std::vector<int> opposite_start_;  // (sides + 1) first entry of each side in opposites_
  std::vector<int> opposites_;       // rows of the opposite contacts of each side
  // (rows) Whether chains of contacts join both sides of a contact to obstacles.
  std::vector<bool> held_;
};

}  // namespace

std::vector<btScalar> relieve_squeezed(const ContactRows& contacts, btScalar step) {
  const int n = contacts.rows.size();
  const ContactNetwork network(contacts);
  // For each contact: the mean of its depth and that of the deepest opposite contact, and the size
  // of the body. If a contact has two bodies, the smaller of their values.
  std::vector<btScalar> means(n, infinite), sizes(n, infinite);
  for (int s = 0; s < network.n_sides(); ++s) {
    const int row = network.side(s).row;
    means[row] = std::min(means[row], 0.5 * (network.depth(row) + network.opposite_depth(s)));
    sizes[row] = std::min(sizes[row], network.size(s));
  }
  std::vector<btScalar> impulses(n, 0.0);
  for (int i = 0; i < n; ++i) {
    if (means[i] <= 0.0 || means[i] > deepest_squeeze * sizes[i]) continue;
    impulses[i] = modulus * sizes[i] * std::max(means[i] - rounding * sizes[i], btScalar(0)) * step;
    if (const btScalar depth = network.depth(i); depth > 0.0)
      contacts.rows[i].m_rhsPenetration *= std::max(depth - means[i], btScalar(0)) / depth;
  }
  return impulses;
}

}  // namespace loomstone
