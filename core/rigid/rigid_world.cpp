// Rigid bodies by Bullet (double precision), the only file that includes it. The body frame of Bullet has principal axes of
// inertia; states and callers know only the mesh's axes with the origin at the centre of mass.
//
// Bullet's contact cache, pair order and tree are hidden state. restore() therefore always builds a new world in the same
// order and puts the saved contact points back: a run that restores at a step continues bit for bit like one that loads the
// same state from a file.
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <btBulletDynamicsCommon.h>
#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/rotation.h"
#include "core/rigid/contact_bytes.h"
#include "core/rigid/rigid_body.h"
#include "core/rigid/shape_geometry.h"

namespace loomstone {

namespace {

// With 50 iterations cubes of 1 cm stay at rest at steps of 1 ms; with 10 stacks creep.
constexpr int solver_iterations = 50;

btVector3 to_bullet(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btMatrix3x3 to_bullet(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
Mat3 from_bullet(const btMatrix3x3& m) {
  Mat3 r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = m[i][j];
  return r;
}

using Shapes = std::vector<std::unique_ptr<btCollisionShape>>;

// Convex hull. Bullet adds the margin of a hull outside, so its points are those of a shrunken core.
std::unique_ptr<btConvexHullShape> hull_shape(const std::vector<Vec3>& points, const std::string& where) {
  btConvexHullComputer hull;
  hull.compute(points.front().data(), sizeof(Vec3), static_cast<int>(points.size()), 0.0, 0.0);
  std::vector<Vec3> vertices;  // the given ones: the hull's own are rounded to 1e-4 of its size
  for (int i = 0; i < hull.vertices.size(); ++i) vertices.push_back(points[hull.original_vertex_index[i]]);
  std::vector<std::vector<int>> faces(hull.faces.size());
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* const start = &hull.edges[hull.faces[f]];
    const btConvexHullComputer::Edge* edge = start;
    do {
      faces[f].push_back(edge->getSourceVertex());
      edge = edge->getNextEdgeOfFace();
    } while (edge != start);
  }
  const bool polyhedron = hull.vertices.size() <= most_polyhedron_vertices;
  const ConvexCore core = convex_core(vertices, faces, polyhedron ? polyhedron_margin : round_margin, where);
  auto shape = std::make_unique<btConvexHullShape>();
  shape->setMargin(core.margin);
  for (const Vec3& point : core.points) shape->addPoint(to_bullet(point), false);
  shape->recalcLocalAabb();
  if (polyhedron) shape->initializePolyhedralFeatures();
  return shape;
}

// Adds the body's shape, and those it consists of, to `shapes`; the one of the whole body comes last.
void add_shapes(const RigidBody& body, const MassProperties& mass, const Mat3& principal, const std::string& where,
                Shapes& shapes) {
  check_shape(body, where);
  const TriangleMesh& mesh = *body.mesh;
  if (body.shape == "sphere") {
    shapes.push_back(std::make_unique<btSphereShape>(sphere_radius(mesh, mass, body.density, where)));
  } else if (body.shape == "box") {
    const Vec3 low = mesh.vertices().colwise().minCoeff().transpose(), high = mesh.vertices().colwise().maxCoeff().transpose();
    const Vec3 half = 0.5 * (high - low);
    auto box = std::make_unique<btBoxShape>(to_bullet(half));
    box->setMargin(0.05 * half.minCoeff());  // lies inside the box
    box->initializePolyhedralFeatures();
    const Vec3 offset = principal.transpose() * (0.5 * (low + high) - mass.centre);
    shapes.push_back(std::move(box));
    if (offset.norm() < 1e-9 * half.norm() && principal.isIdentity(0.0)) return;
    auto placed = std::make_unique<btCompoundShape>();
    placed->addChildShape(btTransform(to_bullet(Mat3(principal.transpose())), to_bullet(offset)), shapes.back().get());
    shapes.push_back(std::move(placed));
  } else if (body.shape == "convex") {
    shapes.push_back(hull_shape(body_points(mesh, mass.centre, principal), where + ".mesh"));
  } else {  // parts
    auto compound = std::make_unique<btCompoundShape>();
    for (std::size_t k = 0; k < body.parts.size(); ++k) {
      const std::vector<Vec3> points = body_points(*body.parts[k], mass.centre, principal);
      shapes.push_back(hull_shape(points, where + ".parts[" + std::to_string(k) + "]"));
      compound->addChildShape(btTransform::getIdentity(), shapes.back().get());
    }
    shapes.push_back(std::move(compound));
  }
}

// A box grows by the distance within which its own shape makes contacts, which goes with its size, not by Bullet's 2 cm. In
// the tree boxes of bodies are just those: Bullet would let them grow by 5 cm as soon as they move, within which a small body has
// hundreds of neighbours.
//
// Obstacles stand at their pose at the start of the step with the velocity that leads to its end, like the bodies; their
// velocities are given, not differenced by Bullet (whose arc cosine turns rounding into 1e-8 / step of spin).
class World : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void updateAabbs() override {
    for (int i = 0; i < m_collisionObjects.size(); ++i) {
      btCollisionObject& object = *m_collisionObjects[i];
      const btCollisionShape& shape = *object.getCollisionShape();
      const btScalar margin = std::min(shape.getContactBreakingThreshold(gContactBreakingThreshold), gContactBreakingThreshold);
      const btVector3 wider(margin, margin, margin);
      btVector3 low, high, end_low, end_high;
      shape.getAabb(object.getWorldTransform(), low, high);
      shape.getAabb(object.getInterpolationWorldTransform(), end_low, end_high);  // of an obstacle the same
      low.setMin(end_low), high.setMax(end_high);
      auto& broadphase = static_cast<btDbvtBroadphase&>(*getBroadphase());
      if (object.isStaticOrKinematicObject())
        broadphase.setAabb(object.getBroadphaseHandle(), low - wider, high + wider, getDispatcher());
      else
        broadphase.setAabbForceUpdate(object.getBroadphaseHandle(), low - wider, high + wider, getDispatcher());
    }
  }

 protected:
  void saveKinematicState(btScalar) override {}
};

// Separating axes for hull against hull only: against the triangles of an obstacle Bullet would make a polyhedron of every
// triangle in every step (fifteen times the time).
void meet(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
  const auto shape = [](const btBroadphaseProxy* proxy) {
    return static_cast<const btCollisionObject*>(proxy->m_clientObject)->getCollisionShape();
  };
  btDispatcherInfo chosen = info;
  const auto flat = [](const btCollisionShape* s) { return s->isConcave() || s->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE; };
  chosen.m_enableSatConvex = !flat(shape(pair.m_pProxy0)) && !flat(shape(pair.m_pProxy1));
  btCollisionDispatcher::defaultNearCallback(pair, dispatcher, chosen);
}

// Everything that restore() throws away. Members are destroyed in reverse order: world before what it refers to.
struct Engine {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  std::vector<std::unique_ptr<btRigidBody>> bodies;  // dynamic ones, then obstacles, then facets of those that deform
  World world{&dispatcher, &broadphase, &solver, &configuration};

  explicit Engine(const Vec3& gravity) {
    configuration.setConvexConvexMultipointIterations(4, 4);
    configuration.setPlaneConvexMultipointIterations(4, 4);
    btContactSolverInfo& info = world.getSolverInfo();
    info.m_numIterations = solver_iterations;
    info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_warmstartingFactor = 1.0;  // at 0.85 a stack of five cubes keeps swaying at 4 mm/s, at 1 it stands
    dispatcher.setNearCallback(meet);
    broadphase.m_cupdates = 100;  // [%] pairs that have parted are forgotten at once
    info.m_splitImpulsePenetrationThreshold = 0.0;  // pushing out of a penetration gives no velocity
    world.setGravity(to_bullet(gravity));
  }
  ~Engine() {
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }

  btRigidBody& add_obstacle(btCollisionShape& shape, double friction) {
    btRigidBody& body = add(0.0, Vec3::Zero(), shape, friction, 1.0);
    body.setCollisionFlags((body.getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) |
                           btCollisionObject::CF_KINEMATIC_OBJECT);
    return body;
  }

  btRigidBody& add(double mass, const Vec3& inertia, btCollisionShape& shape, double friction, double restitution) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, to_bullet(inertia));
    info.m_friction = std::sqrt(friction);  // Bullet multiplies: sqrt(mu_a mu_b)
    info.m_restitution = restitution;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies.back();
    body.setUserIndex(static_cast<int>(bodies.size()) - 1);
    body.setActivationState(DISABLE_DEACTIVATION);
    return body;
  }
};

void place(btRigidBody& body, const btTransform& pose) {
  body.setWorldTransform(pose);
  body.setInterpolationWorldTransform(pose);
  body.updateInertiaTensor();
}

void set_velocity(btRigidBody& body, const Vec3& velocity, const Vec3& angular_velocity) {
  body.setLinearVelocity(to_bullet(velocity));
  body.setAngularVelocity(to_bullet(angular_velocity));
  body.setInterpolationLinearVelocity(to_bullet(velocity));
  body.setInterpolationAngularVelocity(to_bullet(angular_velocity));
}

btTransform bullet_pose(const RigidPose& pose) {
  return btTransform(to_bullet(rotation_matrix(pose.orientation)), to_bullet(pose.position));
}

// Triangles as Bullet reads them; owns the arrays.
struct ObstacleMesh {
  Points vertices;
  Triangles triangles;
  btTriangleIndexVertexArray arrays;
  std::unique_ptr<btBvhTriangleMeshShape> shape;

  explicit ObstacleMesh(const TriangleMesh& mesh) : vertices(mesh.vertices()), triangles(mesh.triangles()) {
    btIndexedMesh indexed;
    indexed.m_numTriangles = static_cast<int>(triangles.rows());
    indexed.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(triangles.data());
    indexed.m_triangleIndexStride = 3 * sizeof(Index);
    indexed.m_numVertices = static_cast<int>(vertices.rows());
    indexed.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices.data());
    indexed.m_vertexStride = 3 * sizeof(double);
    indexed.m_vertexType = PHY_DOUBLE;
    arrays.addIndexedMesh(indexed, PHY_INTEGER);
    shape = std::make_unique<btBvhTriangleMeshShape>(&arrays, true);
  }
};

// A triangle of an obstacle that deforms: a body of its own, so that what rests on it feels how fast it moves just there.
struct Facet {
  std::array<Index, 3> corners;  // rows of all vertices that deform
  double friction;
  std::unique_ptr<btTriangleShape> shape = std::make_unique<btTriangleShape>();

  Mat3 at(const Points& x) const { return (Mat3() << x.row(corners[0]), x.row(corners[1]), x.row(corners[2])).finished(); }
  // Its axes turn with it, so that contact points carried over stay where they were on it.
  void put(btRigidBody& body, const Points& x) const {
    const FacetFrame frame = facet_frame(at(x));
    shape->setMargin(0.0);
    for (int k = 0; k < 3; ++k) shape->m_vertices1[k] = to_bullet(Vec3(frame.corners.row(k).transpose()));
    place(body, btTransform(to_bullet(frame.axes), to_bullet(frame.centre)));
  }
};

}  // namespace

struct RigidWorld::Data {
  std::vector<RigidBody> bodies;
  std::vector<RigidObstacle> obstacles;
  Vec3 gravity;
  bool gyroscopic = true;
  std::vector<MassProperties> masses;
  std::vector<Mat3> principal;                 // columns: Bullet's body axes in mesh axes
  std::vector<Vec3> moments;                   // about them [kg m^2]
  std::vector<Shapes> shapes;                  // of each body, that of the whole last
  std::vector<double> inner_radii;             // half the smallest side of the box about each body [m]
  std::vector<std::size_t> stiff;              // the obstacles that keep their shape
  std::vector<std::unique_ptr<ObstacleMesh>> obstacle_meshes;  // theirs
  std::vector<Facet> facets;                   // of the others
  ObstaclePlaces start_places, places;         // of obstacles, in the description and now
  std::unique_ptr<Engine> engine;
  RigidState known;                            // what the engine holds, without manifolds

  void add_body(const RigidBody& body, const std::string& where);
  void add_obstacle(const RigidObstacle& obstacle, const std::string& where);
  void put_obstacles();
  void set_body(std::size_t i, const RigidState& state);
  void follow(const RigidState& state);
  void know(const RigidState& state) {
    known = {state.positions, state.orientations, state.velocities, state.angular_velocities, {}};
  }
  void read(RigidState& state) const;
  std::vector<unsigned char> manifold_bytes() const;
  const btPersistentManifold& manifold(int m) const { return *engine->dispatcher.btCollisionDispatcher::getManifoldByIndexInternal(m); }
  void read_manifolds(ByteReader& bytes);
};

void RigidWorld::Data::add_body(const RigidBody& body, const std::string& where) {
  check_fields(body, where);
  check_orientation(body.orientation, where);
  if (!body.mesh) throw InvalidInput(where + ".mesh must be a closed mesh, got none");
  try {
    masses.push_back(loomstone::mass_properties(*body.mesh, body.density));
  } catch (const InvalidInput& error) {
    throw InvalidInput(where + "." + error.what());
  }
  const MassProperties& mass = masses.back();
  principal.push_back(principal_axes(mass.inertia));
  moments.push_back((principal.back().transpose() * mass.inertia * principal.back()).diagonal());
  shapes.emplace_back();
  add_shapes(body, mass, principal.back(), where, shapes.back());
  btVector3 low, high;
  shapes.back().back()->getAabb(btTransform::getIdentity(), low, high);
  inner_radii.push_back(0.5 * from_bullet(high - low).minCoeff());
  bodies.push_back(body);
}

void RigidWorld::Data::add_obstacle(const RigidObstacle& obstacle, const std::string& where) {
  if (!obstacle.mesh) throw InvalidInput(where + ".mesh must be a mesh, got none");
  check_orientation(obstacle.orientation, where);
  start_places.poses.push_back({obstacle.position, obstacle.orientation});
  if (obstacle.vertices.rows() == 0) {
    stiff.push_back(obstacles.size());
    obstacle_meshes.push_back(std::make_unique<ObstacleMesh>(*obstacle.mesh));
  } else {
    const Index first = static_cast<Index>(start_places.deformed.rows());
    start_places.deformed.conservativeResize(first + obstacle.vertices.rows(), 3);
    start_places.deformed.bottomRows(obstacle.vertices.rows()) = obstacle.vertices;
    for (const auto& corner : obstacle.mesh->triangles().rowwise())
      facets.push_back({{corner[0] + first, corner[1] + first, corner[2] + first}, obstacle.friction});
  }
  obstacles.push_back(obstacle);
}

void RigidWorld::Data::put_obstacles() {
  std::size_t body = bodies.size();
  for (const std::size_t i : stiff) place(*engine->bodies[body++], bullet_pose(places.poses[i]));
  for (const Facet& facet : facets) facet.put(*engine->bodies[body++], places.deformed);
}

void RigidWorld::Data::set_body(std::size_t i, const RigidState& state) {
  const Vec4 orientation = state.orientations.row(i).transpose();
  const Vec3 position = state.positions.row(i).transpose();
  place(*engine->bodies[i], btTransform(to_bullet(Mat3(rotation_matrix(orientation) * principal[i])), to_bullet(position)));
  set_velocity(*engine->bodies[i], state.velocities.row(i).transpose(), state.angular_velocities.row(i).transpose());
}

// Takes over bodies that someone else has moved since the last step.
void RigidWorld::Data::follow(const RigidState& state) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (state.positions.row(i) != known.positions.row(i) || state.orientations.row(i) != known.orientations.row(i) ||
        state.velocities.row(i) != known.velocities.row(i) ||
        state.angular_velocities.row(i) != known.angular_velocities.row(i))
      set_body(i, state);
  }
}

void RigidWorld::Data::read(RigidState& state) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const btRigidBody& body = *engine->bodies[i];
    const btTransform& pose = body.getWorldTransform();
    const Vec4 orientation = quaternion_from_matrix(from_bullet(pose.getBasis()) * principal[i].transpose());
    state.positions.row(i) = from_bullet(pose.getOrigin()).transpose();
    state.orientations.row(i) = nearer_sign(orientation, state.orientations.row(i).transpose()).transpose();
    state.velocities.row(i) = from_bullet(body.getLinearVelocity()).transpose();
    state.angular_velocities.row(i) = from_bullet(body.getAngularVelocity()).transpose();
  }
}

std::vector<unsigned char> RigidWorld::Data::manifold_bytes() const {
  ByteWriter bytes;
  write_places(bytes, places);
  const int n = engine->dispatcher.getNumManifolds();
  bytes.write<std::int32_t>(n);
  for (int m = 0; m < n; ++m) write_manifold<btManifoldPoint>(bytes, manifold(m));
  return bytes.take();
}

// A saved manifold goes to the first unused one of its pair; one whose pair no longer overlaps has nothing to hold.
void RigidWorld::Data::read_manifolds(ByteReader& bytes) {
  btCollisionDispatcher& dispatcher = engine->dispatcher;
  std::map<std::pair<int, int>, std::deque<btPersistentManifold*>> unused;
  for (int k = 0; k < dispatcher.getNumManifolds(); ++k) {
    btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(k);
    unused[{manifold->getBody0()->getUserIndex(), manifold->getBody1()->getUserIndex()}].push_back(manifold);
  }
  const int n_manifolds = bytes.read<std::int32_t>();
  for (int m = 0; m < n_manifolds; ++m) {
    const int first = bytes.read<std::int32_t>(), second = bytes.read<std::int32_t>(), n_points = bytes.read<std::int32_t>();
    bytes.require(0 <= n_points && n_points <= MANIFOLD_CACHE_SIZE);
    btPersistentManifold* target = nullptr;
    if (auto& left = unused[{first, second}]; !left.empty()) target = left.front(), left.pop_front();
    for (int k = 0; k < n_points; ++k) {
      btManifoldPoint point;
      for_each_field_of(point, [&](auto& value) { value = bytes.read<std::decay_t<decltype(value)>>(); });
      if (target) target->addManifoldPoint(point);
    }
  }
  bytes.require(bytes.at_end());
}

RigidWorld::RigidWorld(const std::vector<RigidBody>& bodies, const std::vector<RigidObstacle>& obstacles,
                       const Vec3& gravity, bool gyroscopic)
    : data_(std::make_unique<Data>()) {
  data_->gravity = gravity;
  data_->gyroscopic = gyroscopic;
  for (std::size_t i = 0; i < bodies.size(); ++i) data_->add_body(bodies[i], "bodies[" + std::to_string(i) + "]");
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    data_->add_obstacle(obstacles[i], "obstacles[" + std::to_string(i) + "]");
  restore(initial_state());
}

RigidWorld::~RigidWorld() = default;

const std::vector<MassProperties>& RigidWorld::mass_properties() const { return data_->masses; }

RigidState RigidWorld::initial_state() const { return start_state(data_->bodies, data_->masses); }

void RigidWorld::restore(const RigidState& state) {
  Data& data = *data_;
  const auto n = static_cast<Index>(data.bodies.size());
  check_rows(state, n);
  data.engine = std::make_unique<Engine>(data.gravity);
  Engine& engine = *data.engine;
  ByteReader bytes(state.manifolds);
  data.places = data.start_places;
  if (!state.manifolds.empty()) read_places(bytes, data.places);

  for (Index i = 0; i < n; ++i) {
    const RigidBody& body = data.bodies[i];
    btCollisionShape& shape = *data.shapes[i].back();
    btRigidBody& moving = engine.add(data.masses[i].mass, data.moments[i], shape, body.friction, body.restitution);
    if (!data.gyroscopic) moving.setFlags(moving.getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
    // A body that moves by more than half its thickness in a step is swept, so that it does not pass through a floor.
    moving.setCcdMotionThreshold(0.5 * data.inner_radii[i]);
    moving.setCcdSweptSphereRadius(0.5 * data.inner_radii[i]);
    data.set_body(i, state);
  }
  for (std::size_t k = 0; k < data.stiff.size(); ++k)
    engine.add_obstacle(*data.obstacle_meshes[k]->shape, data.obstacles[data.stiff[k]].friction);
  for (const Facet& facet : data.facets) engine.add_obstacle(*facet.shape, facet.friction);
  data.put_obstacles();
  for (auto& body : engine.bodies) engine.world.addRigidBody(body.get());
  engine.world.clearForces();
  engine.world.performDiscreteCollisionDetection();
  for (int m = 0; m < engine.dispatcher.getNumManifolds(); ++m)
    engine.dispatcher.clearManifold(engine.dispatcher.getManifoldByIndexInternal(m));
  if (!state.manifolds.empty()) data.read_manifolds(bytes);
  data.know(state);
}

void RigidWorld::advance(double step, const Points& impulses, const Points& angular_impulses,
                         const ObstaclePlaces& obstacles, RigidState& state,
                         std::vector<std::uint8_t>* touched) {
  Data& data = *data_;
  Engine& engine = *data.engine;
  const std::size_t n = data.bodies.size();
  check_impulses(impulses, angular_impulses, state, static_cast<Index>(n));
  const ObstaclePlaces& now = data.places;
  check_places(obstacles, now);
  data.follow(state);
  for (std::size_t i = 0; i < n; ++i) {
    engine.bodies[i]->applyCentralImpulse(to_bullet(Vec3(impulses.row(i).transpose())));
    engine.bodies[i]->applyTorqueImpulse(to_bullet(Vec3(angular_impulses.row(i).transpose())));
  }
  std::size_t obstacle = n;
  for (const std::size_t i : data.stiff) {
    const RigidPose &from = now.poses[i], &to = obstacles.poses[i];
    set_velocity(*engine.bodies[obstacle++], (to.position - from.position) / step,
                 angular_velocity_between(from.orientation, to.orientation, step));
  }
  for (const Facet& facet : data.facets) {
    const FacetMotion motion = facet_motion(facet.at(now.deformed), facet.at(obstacles.deformed), step);
    set_velocity(*engine.bodies[obstacle++], motion.velocity, motion.angular_velocity);
  }
  std::vector<std::array<btVector3, 3>> free;  // velocities and place that nothing has changed
  for (std::size_t i = 0; i < n && touched; ++i) {
    const btVector3 velocity = engine.bodies[i]->getLinearVelocity() + to_bullet(data.gravity) * step;
    free.push_back({velocity, engine.bodies[i]->getAngularVelocity(),
                    engine.bodies[i]->getWorldTransform().getOrigin() + velocity * step});
  }
  engine.world.stepSimulation(step, 0);
  if (touched) touched->clear();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const btRigidBody& body = *engine.bodies[i];
    touched->push_back(body.getLinearVelocity() != free[i][0] || body.getAngularVelocity() != free[i][1] ||
                       body.getWorldTransform().getOrigin() != free[i][2]);
  }
  data.places = obstacles;
  data.put_obstacles();
  data.read(state);
  check_motion(state, step);
  data.know(state);
}

std::vector<std::uint8_t> RigidWorld::touching() const {
  std::vector<std::uint8_t> result(data_->bodies.size(), 0);
  for (int m = 0; m < data_->engine->dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& contact = data_->manifold(m);
    if (contact.getNumContacts() == 0) continue;
    for (const int body : {contact.getBody0()->getUserIndex(), contact.getBody1()->getUserIndex()})
      if (static_cast<std::size_t>(body) < result.size()) result[body] = 1;
  }
  return result;
}

std::vector<std::uint8_t> RigidWorld::supported() const {
  std::vector<std::array<int, 2>> pressed;
  for (int m = 0; m < data_->engine->dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = data_->manifold(m);
    double impulse = 0.0;
    for (int k = 0; k < manifold.getNumContacts(); ++k) impulse += manifold.getContactPoint(k).getAppliedImpulse();
    if (impulse > 0.0) pressed.push_back({manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()});
  }
  return bodies_on_obstacles(static_cast<int>(data_->bodies.size()), pressed);
}

void RigidWorld::save(RigidState& state) const { state.manifolds = data_->manifold_bytes(); }

}  // namespace loomstone
