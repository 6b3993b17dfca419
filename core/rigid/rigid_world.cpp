// Rigid bodies by Bullet. Its body frame has principal axes of inertia; states and callers know
// only the mesh's axes with the origin at the centre of mass.
//
// Bullet's contact cache, pair order and tree are hidden state. restore() therefore always builds a
// new world in the same order and puts the saved contact points back: a run that restores at a step
// continues bit for bit like one that loads the same state from a file.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/rotation.h"
#include "core/rigid/bullet_shapes.h"
#include "core/rigid/contact_bytes.h"
#include "core/rigid/hull_algorithm.h"
#include "core/rigid/rigid_body.h"
#include "core/rigid/shape_geometry.h"
#include "core/rigid/sphere_algorithm.h"

namespace loomstone {

namespace {

// A box grows by the distance within which its own shape makes contacts, which goes with its size,
// not by Bullet's 2 cm. In the tree boxes of bodies are a few such distances wider, and stay as
// they are until a body has left its own; Bullet would let them grow by 5 cm as soon as they move,
// within which a small body has hundreds of neighbours.
//
// Obstacles stand at their pose at the start of the step with the velocity that leads to its end,
// like the bodies; their velocities are given, not differenced by Bullet (whose arc cosine turns
// rounding into 1e-8 / step of spin).
class World : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void updateAabbs() override {
    constexpr btScalar room =
        4.0;  // more boxes meet where it is larger, more of them move where it is smaller
    auto& broadphase = static_cast<btDbvtBroadphase&>(*getBroadphase());
    for (int i = 0; i < m_collisionObjects.size(); ++i) {
      btCollisionObject& object = *m_collisionObjects[i];
      btBroadphaseProxy& proxy = *object.getBroadphaseHandle();
      const btCollisionShape& shape = *object.getCollisionShape();
      if (i == static_cast<int>(margins_.size()))
        margins_.push_back(std::min(shape.getContactBreakingThreshold(gContactBreakingThreshold),
                                    gContactBreakingThreshold));
      const btVector3 wider(margins_[i], margins_[i], margins_[i]);
      btVector3 low, high, end_low, end_high;
      shape.getAabb(object.getWorldTransform(), low, high);
      shape.getAabb(object.getInterpolationWorldTransform(), end_low,
                    end_high);  // of an obstacle the same
      low.setMin(end_low), high.setMax(end_high);
      low -= wider, high += wider;
      if (object.isStaticOrKinematicObject()) {
        broadphase.setAabb(&proxy, low, high, getDispatcher());
        continue;
      }
      const auto below = [](const btVector3& a, const btVector3& b) {
        return a.x() <= b.x() && a.y() <= b.y() && a.z() <= b.z();
      };
      const btVector3 loose = wider * (3.0 * room);
      const bool inside = below(proxy.m_aabbMin, low) && below(high, proxy.m_aabbMax);
      if (inside && below(low - loose, proxy.m_aabbMin) && below(proxy.m_aabbMax, high + loose))
        continue;
      broadphase.setAabbForceUpdate(&proxy, low - room * wider, high + room * wider,
                                    getDispatcher());
    }
  }

 protected:
  void saveKinematicState(btScalar) override {}

 private:
  std::vector<btScalar> margins_;  // of the objects, none of which is ever taken away
};

btDefaultCollisionConstructionInfo room_for_meetings() {
  btDefaultCollisionConstructionInfo info;
  info.m_customCollisionAlgorithmMaxElementSize =
      std::max(SphereMeetings::size(), HullMeetings::size());
  return info;
}

// Everything that restore() throws away. Members are destroyed in reverse order: world before what
// it refers to.
struct Engine {
  btDefaultCollisionConfiguration configuration{room_for_meetings()};
  SphereMeetings spheres;
  HullMeetings hulls;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  std::vector<std::unique_ptr<btRigidBody>>
      bodies;  // dynamic ones, then obstacles, then facets of those that deform
  World world{&dispatcher, &broadphase, &solver, &configuration};

  Engine(const Vec3& gravity, int iterations) {
    configuration.setConvexConvexMultipointIterations(4, 4);
    configuration.setPlaneConvexMultipointIterations(4, 4);
    btContactSolverInfo& info = world.getSolverInfo();
    info.m_numIterations = iterations;
    info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_warmstartingFactor =
        1.0;  // at 0.85 a stack of five cubes keeps swaying at 4 mm/s, at 1 it stands
    spheres.enter(dispatcher);
    hulls.enter(dispatcher, configuration);
    world.getDispatchInfo().m_enableSatConvex = true;  // for hulls of few vertices among themselves
    broadphase.m_cupdates = 100;  // [%] pairs that have parted are forgotten at once
    world.getDispatchInfo().m_allowedCcdPenetration = 0.0;  // not 4 cm
    info.m_splitImpulsePenetrationThreshold =
        0.0;  // pushing out of a penetration gives no velocity
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

  btRigidBody& add(double mass, const Vec3& inertia, btCollisionShape& shape, double friction,
                   double restitution) {
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

// A triangle of an obstacle that deforms: a body of its own, so that what rests on it feels how
// fast it moves just there.
struct Facet {
  FacetSurroundings around;
  double friction;
  std::unique_ptr<btTriangleShape> shape = std::make_unique<btTriangleShape>();

  Mat3 at(const Points& x) const {
    return (Mat3() << x.row(around.corners[0]), x.row(around.corners[1]), x.row(around.corners[2]))
        .finished();
  }
  // Its axes turn with it, so that contact points carried over stay where they were on it.
  void put(btRigidBody& body, const Points& x) const {
    const FacetFrame frame = facet_frame(at(x));
    shape->setMargin(0.0);
    for (int k = 0; k < 3; ++k)
      shape->m_vertices1[k] = to_bullet(Vec3(frame.corners.row(k).transpose()));
    place(body, btTransform(to_bullet(frame.axes), to_bullet(frame.centre)));
  }
};

}  // namespace

struct RigidWorld::Data {
  std::vector<RigidBody> bodies;
  std::vector<RigidObstacle> obstacles;
  Vec3 gravity;
  bool gyroscopic = true;
  int iterations = RigidWorld::default_iterations;
  std::vector<MassProperties> masses;
  std::vector<Mat3> principal;      // columns: Bullet's body axes in mesh axes
  std::vector<Vec3> moments;        // about them [kg m^2]
  std::vector<Shapes> shapes;       // of each body
  std::vector<double> inner_radii;  // half the smallest side of the box about each body [m]
  std::vector<std::size_t> stiff;   // the obstacles that keep their shape
  std::vector<std::unique_ptr<ObstacleMesh>> obstacle_meshes;  // theirs
  std::vector<Facet> facets;                                   // of the others
  ObstaclePlaces start_places, places;  // of obstacles, in the description and now
  std::unique_ptr<Engine> engine;
  RigidState known;  // what the engine holds, without manifolds

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
  const btPersistentManifold& manifold(int m) const {
    return *engine->dispatcher.btCollisionDispatcher::getManifoldByIndexInternal(m);
  }
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
  shapes.push_back(make_shapes(body, mass, principal.back(), where));
  btVector3 low, high;
  shapes.back().whole().getAabb(btTransform::getIdentity(), low, high);
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
    std::vector<std::vector<std::array<Index, 3>>> at(
        obstacle.vertices.rows());  // the triangles at each vertex
    for (const auto& t : obstacle.mesh->triangles().rowwise())
      for (const Index corner : t) at[corner].push_back({t[0] + first, t[1] + first, t[2] + first});
    for (const auto& t : obstacle.mesh->triangles().rowwise()) {
      facets.push_back(
          {{&places.deformed, {t[0] + first, t[1] + first, t[2] + first}, {}}, obstacle.friction});
      auto& [vertices, corners, others] = facets.back().around;
      for (const Index corner : t)
        for (const auto& other : at[corner])
          if (other != corners && std::find(others.begin(), others.end(), other) == others.end())
            others.push_back(other);
    }
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
  place(*engine->bodies[i],
        btTransform(to_bullet(Mat3(rotation_matrix(orientation) * principal[i])),
                    to_bullet(position)));
  set_velocity(*engine->bodies[i], state.velocities.row(i).transpose(),
               state.angular_velocities.row(i).transpose());
}

// Takes over bodies that someone else has moved since the last step.
void RigidWorld::Data::follow(const RigidState& state) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (state.positions.row(i) != known.positions.row(i) ||
        state.orientations.row(i) != known.orientations.row(i) ||
        state.velocities.row(i) != known.velocities.row(i) ||
        state.angular_velocities.row(i) != known.angular_velocities.row(i))
      set_body(i, state);
  }
}

void RigidWorld::Data::read(RigidState& state) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const btRigidBody& body = *engine->bodies[i];
    const btTransform& pose = body.getWorldTransform();
    const Vec4 orientation =
        quaternion_from_matrix(from_bullet(pose.getBasis()) * principal[i].transpose());
    state.positions.row(i) = from_bullet(pose.getOrigin()).transpose();
    state.orientations.row(i) =
        nearer_sign(orientation, state.orientations.row(i).transpose()).transpose();
    state.velocities.row(i) = from_bullet(body.getLinearVelocity()).transpose();
    state.angular_velocities.row(i) = from_bullet(body.getAngularVelocity()).transpose();
  }
}

std::vector<unsigned char> RigidWorld::Data::manifold_bytes() const {
  const int n = engine->dispatcher.getNumManifolds();
  ByteWriter bytes(512 * static_cast<std::size_t>(n));  // more come with more contacts
  write_places(bytes, places);
  bytes.write<std::int32_t>(n);
  for (int m = 0; m < n; ++m) write_manifold(bytes, manifold(m));
  return bytes.take();
}

RigidWorld::RigidWorld(const std::vector<RigidBody>& bodies,
                       const std::vector<RigidObstacle>& obstacles, const Vec3& gravity,
                       bool gyroscopic, int iterations)
    : data_(std::make_unique<Data>()) {
  data_->gravity = gravity;
  data_->gyroscopic = gyroscopic;
  data_->iterations = iterations;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    data_->add_body(bodies[i], "bodies[" + std::to_string(i) + "]");
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
  data.engine = std::make_unique<Engine>(data.gravity, data.iterations);
  Engine& engine = *data.engine;
  ByteReader bytes(state.manifolds);
  data.places = data.start_places;
  if (!state.manifolds.empty()) read_places(bytes, data.places);

  for (Index i = 0; i < n; ++i) {
    const RigidBody& body = data.bodies[i];
    btCollisionShape& shape = data.shapes[i].whole();
    btRigidBody& moving =
        engine.add(data.masses[i].mass, data.moments[i], shape, body.friction, body.restitution);
    if (!data.gyroscopic)
      moving.setFlags(moving.getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
    // A body that moves by more than half its thickness in a step is swept, so that it does not
    // pass through a floor.
    moving.setCcdMotionThreshold(0.5 * data.inner_radii[i]);
    moving.setCcdSweptSphereRadius(0.5 * data.inner_radii[i]);
    data.set_body(i, state);
  }
  for (std::size_t k = 0; k < data.stiff.size(); ++k)
    engine.add_obstacle(*data.obstacle_meshes[k]->shape, data.obstacles[data.stiff[k]].friction);
  for (Facet& facet : data.facets) {
    facet.shape->setUserPointer(&facet.around);
    engine.add_obstacle(*facet.shape, facet.friction);
  }
  data.put_obstacles();
  for (auto& body : engine.bodies) engine.world.addRigidBody(body.get());
  engine.world.clearForces();
  engine.world.performDiscreteCollisionDetection();
  for (int m = 0; m < engine.dispatcher.getNumManifolds(); ++m)
    engine.dispatcher.clearManifold(engine.dispatcher.getManifoldByIndexInternal(m));
  if (!state.manifolds.empty()) read_manifolds(bytes, engine.dispatcher);
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
    const FacetMotion motion =
        facet_motion(facet.at(now.deformed), facet.at(obstacles.deformed), step);
    set_velocity(*engine.bodies[obstacle++], motion.velocity, motion.angular_velocity);
  }
  std::vector<std::array<btVector3, 3>> free;  // velocities and place that nothing has changed
  for (std::size_t i = 0; i < n && touched; ++i) {
    const btVector3 velocity =
        engine.bodies[i]->getLinearVelocity() + to_bullet(data.gravity) * step;
    free.push_back({velocity, engine.bodies[i]->getAngularVelocity(),
                    engine.bodies[i]->getWorldTransform().getOrigin() + velocity * step});
  }
  engine.world.stepSimulation(step, 0);
  if (touched) touched->clear();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const btRigidBody& body = *engine.bodies[i];
    touched->push_back(body.getLinearVelocity() != free[i][0] ||
                       body.getAngularVelocity() != free[i][1] ||
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
    bool near = false;  // others are ahead
    for (int k = 0; k < contact.getNumContacts(); ++k)
      near |= contact.getContactPoint(k).getDistance() <= contact.getContactBreakingThreshold();
    if (!near) continue;
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
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      impulse += manifold.getContactPoint(k).getAppliedImpulse();
    if (impulse > 0.0)
      pressed.push_back({manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()});
  }
  return bodies_on_obstacles(static_cast<int>(data_->bodies.size()), pressed);
}

void RigidWorld::save(RigidState& state) const { state.manifolds = data_->manifold_bytes(); }

}  // namespace loomstone
