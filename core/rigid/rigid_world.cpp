// Implements RigidWorld with Bullet. Bullet's body frame uses the principal axes of inertia. States
// and callers use the axes of the mesh with the origin at the centre of mass.
//
// A body in a bearing can only turn about its axis, which is the first axis of Bullet's body frame.
// Its inverse moments of inertia about the other two axes are zero, and its inverse mass is nearly
// zero.
//
// Bullet's contact cache, pair order and tree are hidden state. Therefore restore() always builds a
// new world in a fixed order and restores the saved contact points. A run that saves its state and
// then calls restore() continues bitwise identically to a run that loads this state from a file.
#include <optional>
#include <string>
#include <vector>

#include "core/base/message.h"
#include "core/base/rotation.h"
#include "core/rigid/bullet_engine.h"
#include "core/rigid/bullet_shapes.h"
#include "core/rigid/contact_bytes.h"
#include "core/rigid/facets.h"
#include "core/rigid/free_motion.h"
#include "core/rigid/rigid_body.h"
#include "core/rigid/shape_geometry.h"

namespace loomstone {

namespace {

// Factor on the inverse mass of a body in a bearing [1]. If it were 0, Bullet would ignore contacts
// between such a body and obstacles.
constexpr double held_share = 1e-9;

// Returns the changes of velocities that the impulses on body i cause.
BulletWorld::Kick kick_of(const btRigidBody& body, const BodyImpulses& impulses, std::size_t i) {
  const auto row = static_cast<Index>(i);
  const btVector3 linear = to_bullet(Vec3(impulses.linear.row(row).transpose())),
                  angular = to_bullet(Vec3(impulses.angular.row(row).transpose()));
  return {linear * body.getLinearFactor() * body.getInvMass(),
          body.getInvInertiaTensorWorld() * angular * body.getAngularFactor()};
}

}  // namespace

// Pose and velocities that a body has at the end of a step if nothing touches it.
struct FreeMotion {
  btVector3 velocity, angular_velocity, position;
  std::optional<Vec4> orientation;  // empty: as Bullet turns the body
  Vec4 start;                       // orientation at the start of the step

  bool is_of(const btRigidBody& body) const {
    return body.getLinearVelocity() == velocity && body.getAngularVelocity() == angular_velocity &&
           body.getWorldTransform().getOrigin() == position;
  }
};

struct RigidWorld::Data {
  std::vector<RigidBody> bodies;
  std::vector<RigidObstacle> obstacles;
  Vec3 gravity;
  bool gyroscopic = true;
  int iterations = RigidWorld::default_iterations;
  BearingAxes axes;
  std::vector<MassProperties> masses;
  std::vector<Mat3> principal;  // columns: Bullet's body axes in mesh axes
  // Moments of inertia about Bullet's body axes [kg m^2]. Zero: no rotation about this axis.
  std::vector<Vec3> moments;
  std::vector<Shapes> shapes;      // shapes of each body
  std::vector<std::size_t> stiff;  // indices of the obstacles of constant shape
  std::vector<std::unique_ptr<ObstacleMesh>> obstacle_meshes;  // meshes of the obstacles in `stiff`
  std::vector<Facet> facets;                                   // facets of deforming obstacles
  ObstaclePlaces start_places, places;  // initial and current positions of obstacles
  std::unique_ptr<BulletEngine> engine;
  RigidState known;            // state after the last restore() or advance(), without manifolds
  double obstacle_work = 0.0;  // work of obstacles on bodies in the latest advance() [J]

  bool turns_in_bearing(std::size_t body) const { return body < axes.size() && axes[body]; }
  void add_body(const RigidBody& body, const std::string& where);
  void add_obstacle(const RigidObstacle& obstacle, const std::string& where);
  void put_obstacles();
  void set_body(std::size_t i, const RigidState& state);
  void follow(const RigidState& state);
  void know(const RigidState& state) {
    known = {state.positions, state.orientations, state.velocities, state.angular_velocities, {}};
  }
  bool turns_freely(std::size_t body) const;
  std::vector<FreeMotion> begin_free_motion(double step, const RigidState& state);
  void end_free_turns(const std::vector<FreeMotion>& free, double step, RigidState& state);
  void hold_centres(const RigidState& start);
  void read(RigidState& state) const;
  double work_of_obstacles() const;
  std::vector<unsigned char> manifold_bytes() const;
  const btPersistentManifold& manifold(int m) const {
    return *engine->dispatcher.btCollisionDispatcher::getManifoldByIndexInternal(m);
  }
};

void RigidWorld::Data::add_body(const RigidBody& body, const std::string& where) {
  check_fields(body, where);
  check_orientation(body.orientation, where);
  try {
    masses.push_back(loomstone::mass_properties(body));
  } catch (const InvalidInput& error) {
    fail<InvalidInput>("{}.{}", where, error.what());
  }
  const MassProperties& mass = masses.back();
  const std::size_t index = bodies.size();
  if (turns_in_bearing(index)) {
    const Vec3 axis = rotation_matrix(body.orientation.normalized()).transpose() * *axes[index];
    principal.push_back(axes_from(axis));
    moments.push_back(Vec3(axis.dot(mass.inertia * axis), 0.0, 0.0));
  } else {
    principal.push_back(principal_axes(mass.inertia));
    moments.push_back((principal.back().transpose() * mass.inertia * principal.back()).diagonal());
  }
  shapes.push_back(make_shapes(body, mass, principal.back(), where));
  bodies.push_back(body);
}

void RigidWorld::Data::add_obstacle(const RigidObstacle& obstacle, const std::string& where) {
  if (!obstacle.mesh) fail<InvalidInput>("{}.mesh must be a mesh, got none; give one", where);
  check_orientation(obstacle.orientation, where);
  start_places.poses.push_back({obstacle.position, obstacle.orientation});
  if (obstacle.vertices.rows() == 0) {
    stiff.push_back(obstacles.size());
    obstacle_meshes.push_back(std::make_unique<ObstacleMesh>(*obstacle.mesh));
  } else {
    const Index first = static_cast<Index>(start_places.deformed.rows());
    start_places.deformed.conservativeResize(first + obstacle.vertices.rows(), 3);
    start_places.deformed.bottomRows(obstacle.vertices.rows()) = obstacle.vertices;
    add_facets(obstacle, first, places.deformed, facets);
  }
  obstacles.push_back(obstacle);
}

void RigidWorld::Data::put_obstacles() {
  std::size_t body = bodies.size();
  for (const std::size_t i : stiff) set_pose(*engine->bodies[body++], bullet_pose(places.poses[i]));
  for (const Facet& facet : facets) facet.put(*engine->bodies[body++], places.deformed);
}

void RigidWorld::Data::set_body(std::size_t i, const RigidState& state) {
  const Vec4 orientation = state.orientations.row(i).transpose();
  const Vec3 position = state.positions.row(i).transpose();
  set_pose(*engine->bodies[i],
           btTransform(to_bullet(Mat3(rotation_matrix(orientation) * principal[i])),
                       to_bullet(position)));
  set_velocity(*engine->bodies[i], state.velocities.row(i).transpose(),
               state.angular_velocities.row(i).transpose());
}

// Copies `state` to Bullet for each body whose state the caller has changed since the last
// restore() or advance().
void RigidWorld::Data::follow(const RigidState& state) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (state.positions.row(i) != known.positions.row(i) ||
        state.orientations.row(i) != known.orientations.row(i) ||
        state.velocities.row(i) != known.velocities.row(i) ||
        state.angular_velocities.row(i) != known.angular_velocities.row(i))
      set_body(i, state);
  }
}

// Returns whether gyroscopic torques act on a body.
bool RigidWorld::Data::turns_freely(std::size_t body) const {
  const Vec3& m = moments[body];
  constexpr double equal = 1e-9;  // relative difference that counts as rounding
  return gyroscopic && !turns_in_bearing(body) &&
         m.maxCoeff() - m.minCoeff() > equal * m.maxCoeff();
}

// Applies gyroscopic torques to the angular velocities of the bodies, and returns the free motion
// of each body. Sets FreeMotion::orientation for bodies that Bullet would turn wrongly: its own
// gyroscopic torques lose energy and angular momentum, and it turns no body by more than a quarter
// of pi in a step.
std::vector<FreeMotion> RigidWorld::Data::begin_free_motion(double step, const RigidState& state) {
  constexpr double largest_turn = 0.25 * M_PI * (1.0 - 1e-9);  // turn that Bullet makes fully [rad]
  std::vector<FreeMotion> free;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    btRigidBody& body = *engine->bodies[i];
    std::optional<Vec4> turned;
    const Vec4 orientation = state.orientations.row(i).transpose();
    const Vec3 spin = from_bullet(body.getAngularVelocity());
    if (turns_freely(i)) {
      const Rotor rotor{principal[i], moments[i]};
      const Vec3 momentum = angular_momentum(rotor, orientation, spin);
      turned = freely_turned(rotor, orientation, momentum, step);
      body.setAngularVelocity(to_bullet(angular_velocity(rotor, *turned, momentum)));
    } else if (step * spin.norm() > largest_turn) {
      turned = quaternion_product(quaternion_from_rotation_vector(step * spin), orientation);
    }
    const btVector3 velocity =
        body.getLinearVelocity() + to_bullet(gravity) * body.getLinearFactor() * step;
    free.push_back({velocity, body.getAngularVelocity(),
                    body.getWorldTransform().getOrigin() + velocity * step, turned, orientation});
  }
  return free;
}

// Corrects the orientations of bodies whose FreeMotion::orientation is set. A body that nothing has
// touched gets this orientation. If a body without a bearing was touched and its free motion turns
// it by at least `fast`, it gets this orientation and a further rotation by its change of angular
// velocity. Bullet has computed this change for the orientation at the start of the step, so the
// change is turned with the body. Without this correction, Bullet's orientation and the angular
// velocity would give a slender body a different energy. Other touched bodies keep the orientation
// that Bullet computes.
void RigidWorld::Data::end_free_turns(const std::vector<FreeMotion>& free, double step,
                                      RigidState& state) {
  constexpr double fast = 1e-2;  // turn in a step [rad]
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!free[i].orientation) continue;
    Vec4 turned = *free[i].orientation;
    if (const btRigidBody& body = *engine->bodies[i]; !free[i].is_of(body)) {
      const Vec3 spin = from_bullet(free[i].angular_velocity);
      if (turns_in_bearing(i) || step * spin.norm() < fast) continue;
      const Mat3 turn =
          rotation_matrix(quaternion_product(turned, quaternion_inverse(free[i].start)));
      const Vec3 gained = turn * (from_bullet(body.getAngularVelocity()) - spin);
      const Vec4 further = quaternion_from_rotation_vector(step * gained);
      turned = quaternion_product(further, turned);
      state.angular_velocities.row(i) = (rotation_matrix(further) * (spin + gained)).transpose();
    }
    state.orientations.row(i) =
        nearer_sign(turned, state.orientations.row(i).transpose()).transpose();
    set_body(i, state);
  }
}

// Puts the centres of mass of bodies in bearings back to their place at the start of a step and
// sets the velocities of these centres to zero.
void RigidWorld::Data::hold_centres(const RigidState& start) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!turns_in_bearing(i)) continue;
    btTransform pose = engine->bodies[i]->getWorldTransform();
    pose.setOrigin(to_bullet(Vec3(start.positions.row(i).transpose())));
    set_pose(*engine->bodies[i], pose);
    engine->bodies[i]->setLinearVelocity(btVector3(0, 0, 0));
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

// Returns the sum of the work at all contact points between bodies and obstacles: the impulse on
// the body times the velocity of the obstacle. Obstacles still have their poses at the start of the
// step and the velocities that lead to their poses at its end.
double RigidWorld::Data::work_of_obstacles() const {
  double work = 0.0;
  for (int m = 0; m < engine->dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& contact = manifold(m);
    const auto is_obstacle = [&](const btCollisionObject* object) {
      return object->getUserIndex() >= static_cast<int>(bodies.size());
    };
    const bool first = is_obstacle(contact.getBody0());
    if (first == is_obstacle(contact.getBody1())) continue;
    const auto& obstacle =
        static_cast<const btRigidBody&>(*(first ? contact.getBody0() : contact.getBody1()));
    for (int k = 0; k < contact.getNumContacts(); ++k) {
      const btManifoldPoint& point = contact.getContactPoint(k);
      const btVector3 impulse = point.m_appliedImpulse * point.m_normalWorldOnB +
                                point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
                                point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
      const btVector3 place = first ? point.m_positionWorldOnA : point.m_positionWorldOnB;
      const btVector3 velocity =
          obstacle.getVelocityInLocalPoint(place - obstacle.getCenterOfMassPosition());
      // `impulse` acts on the first body, and its opposite on the second.
      work += (first ? -1.0 : 1.0) * impulse.dot(velocity);
    }
  }
  return work;
}

std::vector<unsigned char> RigidWorld::Data::manifold_bytes() const {
  const int n = engine->dispatcher.getNumManifolds();
  ByteWriter bytes(512 * static_cast<std::size_t>(n));  // grows if necessary
  write_places(bytes, places);
  bytes.write<std::int32_t>(n);
  for (int m = 0; m < n; ++m) write_manifold(bytes, manifold(m));
  return bytes.take();
}

RigidWorld::RigidWorld(const std::vector<RigidBody>& bodies,
                       const std::vector<RigidObstacle>& obstacles, const Vec3& gravity,
                       bool gyroscopic, int iterations, const BearingAxes& axes)
    : data_(std::make_unique<Data>()) {
  data_->gravity = gravity;
  data_->gyroscopic = gyroscopic;
  data_->iterations = iterations;
  data_->axes = axes;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    data_->add_body(bodies[i], formatted("bodies[{}]", i));
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    data_->add_obstacle(obstacles[i], formatted("obstacles[{}]", i));
  restore(initial_state());
}

RigidWorld::~RigidWorld() = default;

const std::vector<MassProperties>& RigidWorld::mass_properties() const { return data_->masses; }

RigidState RigidWorld::initial_state() const { return start_state(data_->bodies, data_->masses); }

void RigidWorld::restore(const RigidState& state) {
  Data& data = *data_;
  const auto n = static_cast<Index>(data.bodies.size());
  check_rows(state, n);
  data.engine = std::make_unique<BulletEngine>(data.gravity, data.iterations);
  BulletEngine& engine = *data.engine;
  ByteReader bytes(state.manifolds);
  data.places = data.start_places;
  if (!state.manifolds.empty()) read_places(bytes, data.places);

  for (Index i = 0; i < n; ++i) {
    const RigidBody& body = data.bodies[i];
    btCollisionShape& shape = data.shapes[i].whole();
    btRigidBody& moving =
        engine.add(data.masses[i].mass, data.moments[i], shape, body.friction, body.restitution);
    if (data.turns_in_bearing(i))
      moving.setLinearFactor(btVector3(held_share, held_share, held_share));
    moving.setFlags(moving.getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
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

void RigidWorld::advance(double step, const BodyImpulses& impulses, const ObstaclePlaces& obstacles,
                         RigidState& state, std::vector<std::uint8_t>* touched,
                         const BodyImpulses* half) {
  Data& data = *data_;
  BulletEngine& engine = *data.engine;
  const std::size_t n = data.bodies.size();
  check_impulses(impulses.linear, impulses.angular, state, static_cast<Index>(n));
  const ObstaclePlaces& now = data.places;
  check_places(obstacles, now);
  data.follow(state);
  BulletWorld::Kicks kicks;
  for (std::size_t i = 0; i < n; ++i) {
    btRigidBody& body = *engine.bodies[i];
    kicks.whole.push_back(kick_of(body, impulses, i));
    if (half) kicks.half.push_back(kick_of(body, *half, i));
    body.setLinearVelocity(body.getLinearVelocity() + kicks.whole[i].linear);
    body.setAngularVelocity(body.getAngularVelocity() + kicks.whole[i].angular);
  }
  engine.world.set_kicks(std::move(kicks));
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
  const std::vector<FreeMotion> free = data.begin_free_motion(step, state);
  engine.world.stepSimulation(step, 0);
  if (touched) {
    touched->clear();
    for (std::size_t i = 0; i < n; ++i) touched->push_back(!free[i].is_of(*engine.bodies[i]));
  }
  data.hold_centres(state);
  data.obstacle_work = data.work_of_obstacles();
  data.places = obstacles;
  data.put_obstacles();
  data.read(state);
  data.end_free_turns(free, step, state);
  check_motion(state, step);
  data.know(state);
}

double RigidWorld::obstacle_work() const { return data_->obstacle_work; }

std::vector<std::uint8_t> RigidWorld::touching() const {
  std::vector<std::uint8_t> result(data_->bodies.size(), 0);
  for (int m = 0; m < data_->engine->dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& contact = data_->manifold(m);
    bool near = false;  // contact points beyond the threshold only anticipate contact
    for (int k = 0; k < contact.getNumContacts(); ++k)
      near |= contact.getContactPoint(k).getDistance() <= contact.getContactBreakingThreshold();
    if (!near) continue;
    for (const int body : {contact.getBody0()->getUserIndex(), contact.getBody1()->getUserIndex()})
      if (static_cast<std::size_t>(body) < result.size()) result[body] = 1;
  }
  return result;
}

std::vector<std::array<int, 2>> RigidWorld::pressed() const {
  std::vector<std::array<int, 2>> pressed;
  for (int m = 0; m < data_->engine->dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = data_->manifold(m);
    double impulse = 0.0;
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      impulse += manifold.getContactPoint(k).getAppliedImpulse();
    if (impulse > 0.0)
      pressed.push_back({manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()});
  }
  return pressed;
}

std::vector<std::uint8_t> RigidWorld::supported() const {
  return bodies_on_obstacles(static_cast<int>(data_->bodies.size()), pressed());
}

void RigidWorld::save(RigidState& state) const { state.manifolds = data_->manifold_bytes(); }

}  // namespace loomstone
