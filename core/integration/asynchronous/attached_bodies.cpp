#include "core/integration/asynchronous/attached_bodies.h"

#include <algorithm>

namespace loomstone {

namespace {

// Inertia of a point mass at `place` about the origin [kg m^2].
Mat3 point_inertia(double mass, const Vec3& place) {
  return mass * (place.squaredNorm() * Mat3::Identity() - place * place.transpose());
}

}  // namespace

void AttachedBodies::begin(const StepInputs& inputs, const Vector& mass,
                           const Points& body_velocity, const Points& x, Points& v) {
  bodies_.clear(), own_.clear(), body_of_.clear();
  interval_ = inputs.step;
  if (!inputs.bodies) return;
  const BodiesOfStep& given = *inputs.bodies;
  for (std::size_t b = 0; b < given.poses->size(); ++b) {
    const auto row = static_cast<Index>(2 * b);
    EventBody body;
    body.pose = body.start = (*given.poses)[b];
    body.velocity = given.velocity->row(row).transpose();
    body.angular_velocity = given.velocity->row(row + 1).transpose();
    body.mass = (*inputs.body_mass)[row](0, 0);
    const Mat3& inertia = (*inputs.body_mass)[row + 1];
    const Mat3 rotation = rotation_matrix(body.pose.orientation);
    body.inertia = rotation.transpose() * inertia * rotation;
    Own own;
    own.force = body.mass * (body_velocity.row(row).transpose() - body.velocity);
    own.torque = inertia * (body_velocity.row(row + 1).transpose() - body.angular_velocity);
    bodies_.push_back(body);
    own_.push_back(own);
  }
  if (given.attached->empty()) return;
  body_of_.assign(mass.size(), -1);
  for (const AttachedVertex& vertex : *given.attached) {
    const EventBody& body = bodies_[vertex.body];
    const Vec3 point = body.pose.position + rotation_matrix(body.pose.orientation) * vertex.local;
    body_of_[vertex.row] = vertex.body;
    own_[vertex.body].tied.push_back(
        {vertex.row, mass[vertex.row], vertex.local, x.row(vertex.row).transpose() - point});
  }
  for (Index b = 0; b < size(); ++b)
    if (!own_[b].tied.empty()) join(b, v);
}

// Adds the masses of the attached vertices to a body, and moves its pose to the common centre of
// mass. Body and vertices then move as one rigid body, with the velocity and angular velocity that
// conserve their momentum and angular momentum.
void AttachedBodies::join(Index b, Points& v) {
  EventBody& body = bodies_[b];
  Own& own = own_[b];
  const double alone = body.mass;
  Vec3 moment = Vec3::Zero(), momentum = alone * body.velocity;
  for (const Tied& tied : own.tied) {
    body.mass += tied.mass;
    moment += tied.mass * tied.local;
    momentum += tied.mass * v.row(tied.row).transpose();
  }
  // Centre of mass of the body with its vertices, relative to that of the body alone, in body axes
  // [m].
  const Vec3 centre = moment / body.mass;
  const Mat3 rotation = rotation_matrix(body.pose.orientation);
  Vec3 spin = rotation * body.inertia * rotation.transpose() * body.angular_velocity -
              (rotation * centre).cross(alone * body.velocity);
  own.centre = -centre;
  body.inertia += point_inertia(alone, centre);
  body.pose.position += rotation * centre;
  body.start = body.pose;
  for (Tied& tied : own.tied) {
    tied.local -= centre;
    body.inertia += point_inertia(tied.mass, tied.local);
    spin += (rotation * tied.local).cross(tied.mass * v.row(tied.row).transpose());
  }
  body.velocity = momentum / body.mass;
  body.angular_velocity = body.world_inertia(body.pose.orientation).inverse() * spin;
  place(b, nullptr, v);
}

// Sets the velocities of the vertices of a body and, if x is given, their positions.
void AttachedBodies::place(Index b, Points* x, Points& v) {
  const EventBody& body = bodies_[b];
  Own& own = own_[b];
  own.velocity = body.velocity, own.spin = body.angular_velocity;
  const Mat3 rotation = rotation_matrix(body.pose.orientation);
  const double left = std::max(0.0, 1.0 - own.elapsed / interval_);
  for (Tied& tied : own.tied) {
    const Vec3 point = body.pose.position + rotation * tied.local;
    tied.velocity = body.velocity_at(point) - tied.offset / interval_;
    v.row(tied.row) = tied.velocity.transpose();
    if (x) x->row(tied.row) = (point + left * tied.offset).transpose();
  }
}

void AttachedBodies::load(Index b, double share) {
  const Own& own = own_[b];
  const Vec3 arm = rotation_matrix(bodies_[b].pose.orientation) * own.centre;
  bodies_[b].push(share * own.force, share * (own.torque + arm.cross(own.force)));
}

void AttachedBodies::absorb(Index b, double ahead, Points& x, Points& v) {
  EventBody& body = bodies_[b];
  Own& own = own_[b];
  const Mat3 rotation = rotation_matrix(body.pose.orientation);
  Vec3 impulse = Vec3::Zero(), angular = Vec3::Zero();
  for (const Tied& tied : own.tied) {
    const Vec3 own_impulse = tied.mass * (v.row(tied.row).transpose() - tied.velocity);
    impulse += own_impulse;
    angular += (rotation * tied.local).cross(own_impulse);
  }
  body.push(impulse, angular);
  if (ahead != 0.0) {
    body.pose.position += ahead * (body.velocity - own.velocity);
    body.pose.orientation = turned(body.pose.orientation, body.angular_velocity - own.spin, ahead);
  }
  place(b, ahead == 0.0 ? nullptr : &x, v);
}

void AttachedBodies::drift(Index b, double time, Points& x, Points& v) {
  bodies_[b].drift(time);
  own_[b].elapsed += time;
  place(b, &x, v);
}

std::vector<Index> AttachedBodies::vertices(Index body) const {
  std::vector<Index> rows;
  for (const Tied& tied : own_[body].tied) rows.push_back(tied.row);
  return rows;
}

void AttachedBodies::share_levels(std::vector<std::uint8_t>& vertex_levels) {
  for (Index b = 0; b < size(); ++b) {
    std::uint8_t finest = 0;
    for (const Tied& tied : own_[b].tied) finest = std::max(finest, vertex_levels[tied.row]);
    for (const Tied& tied : own_[b].tied) vertex_levels[tied.row] = finest;
    bodies_[b].level = finest;
  }
}

void AttachedBodies::finish(const StepInputs& inputs, Points& body_velocity) const {
  if (inputs.bodies) inputs.bodies->with_cloth->resize(bodies_.size());
  for (Index b = 0; b < size(); ++b) {
    const EventBody& body = bodies_[b];
    const Vec3 centre =
        body.pose.position + rotation_matrix(body.pose.orientation) * own_[b].centre;
    (*inputs.bodies->end)[b] = {centre, body.pose.orientation};
    (*inputs.bodies->with_cloth)[b] = body.touched || !own_[b].tied.empty();
    body_velocity.row(2 * b) = body.velocity_at(centre).transpose();
    body_velocity.row(2 * b + 1) = body.angular_velocity.transpose();
  }
}

}  // namespace loomstone
