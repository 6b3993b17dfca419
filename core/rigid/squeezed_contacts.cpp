#include "core/rigid/squeezed_contacts.h"

#include <algorithm>

#include "core/rigid/step_motion.h"

namespace loomstone {

namespace {

// Elastic modulus of bodies [Pa]. Our choice: that of hard rubber and soft plastics.
constexpr btScalar modulus = 1e8;
// Overlap that counts as rounding, as a fraction of the smallest side of the body's bounding box.
constexpr btScalar rounding = 1e-4;
// Largest cosine of the angle between the normals of opposite contacts.
constexpr btScalar opposite = -0.9;

// Contact of a body with an obstacle. The normal points to the body.
struct ObstacleContact {
  int body;  // index in ContactRows::bodies
  int row;
  btVector3 normal;
  btScalar depth;  // overlap, negative for a gap [m]
};

const btRigidBody* dynamic_body(const ContactRows& contacts, int index) {
  const btRigidBody* body = contacts.bodies[index].m_originalBody;
  return body && !body->isStaticOrKinematicObject() ? body : nullptr;
}

// Returns the contacts between bodies and obstacles, sorted by body.
std::vector<ObstacleContact> obstacle_contacts(const ContactRows& contacts) {
  std::vector<ObstacleContact> found;
  for (int i = 0; i < contacts.rows.size(); ++i) {
    const btSolverConstraint& row = contacts.rows[i];
    const btScalar depth =
        -static_cast<const btManifoldPoint*>(row.m_originalContactPoint)->getDistance();
    const bool first = dynamic_body(contacts, row.m_solverBodyIdA),
               second = dynamic_body(contacts, row.m_solverBodyIdB);
    if (first != second)
      found.push_back({first ? row.m_solverBodyIdA : row.m_solverBodyIdB, i,
                       first ? row.m_contactNormal1 : row.m_contactNormal2, depth});
  }
  std::ranges::stable_sort(found, {}, &ObstacleContact::body);
  return found;
}

}  // namespace

std::vector<btScalar> relieve_squeezed(const ContactRows& contacts, btScalar step) {
  std::vector<btScalar> impulses(contacts.rows.size(), 0.0);
  const std::vector<ObstacleContact> all = obstacle_contacts(contacts);
  for (const ObstacleContact& contact : all) {
    btScalar other = -BT_LARGE_FLOAT;  // depth of the deepest opposite contact [m]
    for (const ObstacleContact& each :
         std::ranges::equal_range(all, contact.body, {}, &ObstacleContact::body))
      if (each.normal.dot(contact.normal) < opposite) other = std::max(other, each.depth);
    const btScalar mean = 0.5 * (contact.depth + other);
    if (mean <= 0.0) continue;
    const btScalar size =
        2.0 * inner_radius(*dynamic_body(contacts, contact.body)->getCollisionShape());
    impulses[contact.row] = modulus * size * std::max(mean - rounding * size, btScalar(0)) * step;
    if (contact.depth > 0.0)
      contacts.rows[contact.row].m_rhsPenetration *=
          std::max(contact.depth - mean, btScalar(0)) / contact.depth;
  }
  return impulses;
}

}  // namespace loomstone
