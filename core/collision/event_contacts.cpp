#include "core/collision/event_contacts.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/base/sort_unique.h"
#include "core/collision/approach_bounds.h"
#include "core/collision/narrow_phase/crossing.h"
#include "core/parallel/merge_runs.h"

namespace loomstone {

namespace {

// Largest fraction of the missing distance (thickness minus distance) that a pair regains in a step
// [Bridson2002]; see movable().
constexpr double restored = 0.1;

}  // namespace

EventContacts::EventContacts(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                             const Vector& inverse_mass)
    : model_(model), surface_pairs_(pairs), inverse_mass_(inverse_mass) {}

void EventContacts::set_pairs(const ExpectedMotion& motion, std::vector<ApproachingPair> pairs) {
  motion_.emplace(motion);
  pairs_ = std::move(pairs);
  vertices_.clear();
  for (const ApproachingPair& pair : pairs_)
    vertices_.push_back(pair_vertices(model_, pair.kind, pair.key));
  n_evaluated_ = n_impulses_ = 0;
}

void EventContacts::begin(Index n_ticks) {
  n_ticks_ = n_ticks;
  work_ = {};
  side_.clear(), normal_.clear();
  for (const ApproachingPair& pair : pairs_)
    side_.push_back(pair.side), normal_.push_back(pair.normal);
  if (n_ticks == 0) return begin_queue();
  due_.assign(n_ticks + 1, {});
  const double length = motion_->step / static_cast<double>(n_ticks);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const auto tick = static_cast<Index>(std::min(pairs_[i].wake / length, 1.0 * n_ticks));
    due_[tick].push_back(static_cast<Index>(i));
  }
}

void EventContacts::begin_queue() {
  wake_.clear();
  for (const ApproachingPair& pair : pairs_) wake_.push_back(pair.wake);
  pairs_of_.assign(inverse_mass_.size(), {});
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    for (const Index vertex : vertices_[i])
      if (inverse_mass_[vertex] > 0.0) pairs_of_[vertex].push_back(static_cast<Index>(i));
}

Index EventContacts::body_of(Index vertex) const {
  return model_.surfaces[model_.surface_of_vertex(vertex)].body;
}

Vec3 EventContacts::place(Index vertex, double time, const EventMotion& motion) const {
  if (vertex < motion.x.rows())
    return (motion.x.row(vertex) - motion.ahead(vertex) * motion.v.row(vertex)).transpose();
  const Vec3 start = motion_->x0.row(vertex).transpose();
  if (const Index b = body_of(vertex); b >= 0) {
    const EventBody& body = bodies_[b].body;
    return body.pose.position + bodies_[b].turn * (start - body.start.position);
  }
  return start + time * motion_->v0.row(vertex).transpose();
}

void EventContacts::place_vertices(const Team& team, double time, const EventMotion& motion) {
  placed_.resize(motion_->x0.rows(), 3);
  parallel_for(
      team, static_cast<Index>(placed_.rows()),
      [&](Index i) { placed_.row(i) = place(i, time, motion).transpose(); }, 1024);
}

FourPoints EventContacts::points_of(Index pair, double time, const EventMotion& motion) const {
  FourPoints points;
  for (int k = 0; k < 4; ++k) {
    const Index i = vertices_[pair][k];
    points[k] = all_placed_ ? Vec3(placed_.row(i).transpose()) : place(i, time, motion);
  }
  return points;
}

// Returns the velocity of a vertex. For a vertex of a rigid body, returns instead the velocity of
// the body at the contact point. This is the weighted mean of the velocities of the body's vertices
// in the pair.
Vec3 EventContacts::velocity(Index vertex, const Event& event, const EventMotion& motion) const {
  if (vertex < motion.v.rows()) return motion.v.row(vertex).transpose();
  if (const Index b = body_of(vertex); b >= 0) return bodies_[b].body.velocity_at(event.touched);
  return motion_->v0.row(vertex).transpose();
}

Vec3 EventContacts::relative_velocity(const Event& event, const EventMotion& motion) const {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 4; ++k)
    if (!(event.with_body >> k & 1u))
      sum += event.weights[k] * velocity(event.vertices[k], event, motion);
  if (event.with_body == 0) return sum;
  const EventBody& body = bodies_[event.body].body;
  return sum + event.body_weight * body.velocity +
         body.angular_velocity.cross(event.body_moment - event.body_weight * body.pose.position);
}

bool EventContacts::attached(Index vertex, Index body) const {
  const Index surface = model_.attached[vertex].surface;
  return surface >= 0 && model_.surfaces[surface].body == body;
}

// Sets Event::with_body, body_weight and body_moment. If the pair contains no vertex of a body, but
// one that is attached to a body, also sets Event::body.
void EventContacts::find_with_body(const FourPoints& points, Event& event) const {
  event.with_body = 0, event.body_weight = 0.0, event.body_moment = Vec3::Zero();
  if (model_.attached.empty() || bodies_.empty()) return;
  bool any = false;
  for (const Index i : event.vertices) {
    const Index surface = model_.attached[i].surface;
    if (event.body < 0 && surface >= 0) event.body = model_.surfaces[surface].body;
    any |= event.body >= 0 && attached(i, event.body);
  }
  if (!any) return;
  for (int k = 0; k < 4; ++k) {
    const Index i = event.vertices[k];
    if (body_of(i) != event.body && !attached(i, event.body)) continue;
    event.with_body |= 1u << k;
    event.body_weight += event.weights[k];
    event.body_moment += event.weights[k] * points[k];
  }
}

// Returns the change of the normal velocity of a pair per unit impulse [1/kg].
double EventContacts::inverse_mass_of(const Event& event) const {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k)
    if (!(event.with_body >> k & 1u))
      sum += event.weights[k] * event.weights[k] * inverse_mass_[event.vertices[k]];
  if (event.body < 0) return sum;
  const EventBody& body = bodies_[event.body].body;
  if (event.with_body == 0) return sum + body.inverse_mass_at(event.touched, event.normal);
  const Vec3 arm = (event.body_moment - event.body_weight * body.pose.position).cross(event.normal);
  return sum + event.body_weight * event.body_weight / body.mass +
         arm.dot(body.world_inertia(body.pose.orientation).inverse() * arm);
}

EventContacts::Event EventContacts::evaluate(Index pair, const FourPoints& points) {
  const ApproachingPair& which = pairs_[pair];
  const bool vertex_face = which.kind == ContactKind::VertexFace;
  Event event;
  event.vertices = vertices_[pair];
  event.thickness =
      contact_distance(model_, surface_pairs_[which.pair], which.kind, event.vertices);
  const ClosestPair closest = vertex_face ? closest_vertex_face(points) : closest_edge_edge(points);
  event.weights = closest.weights;
  event.distance = closest.distance;
  event.normal = vertex_face ? contact_normal_vertex_face(points, closest, Vec3::Zero())
                             : contact_normal_edge_edge(points, closest, Vec3::Zero());
  event.at_end = !vertex_face && !closest.interior;
  event.to_cross = event.at_end ? motion_to_cross(points, event.thickness) : 0.0;
  // The features count as passed through each other if side_of() and the contact normal have both
  // reversed. They are then pushed back to their previous side. While a vertex moves around the
  // border of a face, its side is unknown (0). Edges that rotate through the parallel position
  // reverse side_of(), but not the contact normal.
  const std::int8_t side = closest.interior ? side_of(which.kind, points) : std::int8_t{0};
  Vec3& last = normal_[pair];
  if (side_[pair] != 0 && side == -side_[pair] && event.normal.dot(last) < 0.0)
    event.normal = -event.normal, event.distance = -event.distance;
  else
    side_[pair] = side;
  last = event.normal;
  event.inverse_mass = 0.0;
  event.body = -1;
  event.touched = Vec3::Zero();
  for (int k = 0; k < 4 && !bodies_.empty(); ++k) {
    const Index body = body_of(event.vertices[k]);
    if (body < 0) continue;
    event.body = body;
    event.touched += std::abs(event.weights[k]) * points[k];
  }
  find_with_body(points, event);
  if (event.at_end || !(event.distance < event.thickness)) return event;
  event.inverse_mass = inverse_mass_of(event);
  return event;
}

// Returns the largest magnitude of the total weights [1] of three groups: the free vertices of the
// first feature, those of the second feature, and the body with its attached vertices. A pair
// regains its thickness at a speed in proportion to this magnitude, which is limited to 1. If this
// speed were the same for all pairs, free vertices with small weights would get large velocities.
// Returns 1 if no vertex of the pair is attached to Event::body.
double EventContacts::movable(const Event& event, Index pair) const {
  if (event.with_body == 0) return 1.0;
  const int n_a = pairs_[pair].kind == ContactKind::VertexFace ? 1 : 2;
  std::array<double, 2> free{};
  for (int k = 0; k < 4; ++k)
    if (!(event.with_body >> k & 1u) && inverse_mass_[event.vertices[k]] > 0.0)
      free[k < n_a ? 0 : 1] += std::abs(event.weights[k]);
  return std::min(1.0, std::max({free[0], free[1], std::abs(event.body_weight)}));
}

// Applies an impulse with friction, so that the pair stops approaching and slowly regains its
// thickness. Returns false if no impulse is needed, or if event.inverse_mass is 0.
bool EventContacts::push(const Event& event, Index pair, const EventMotion& motion) {
  const SurfacePair& surfaces = surface_pairs_[pairs_[pair].pair];
  const double missing = event.thickness - event.distance;
  if (missing <= 0.0 || !(event.inverse_mass > 0.0)) return false;
  const Vec3 velocity = relative_velocity(event, motion);
  const double along = event.normal.dot(velocity);
  const double lack = movable(event, pair) * restored * missing / motion_->step - along;
  if (lack <= 0.0) return false;
  Vec3 change = lack * event.normal;
  const Vec3 sliding = velocity - along * event.normal;
  const double speed = sliding.norm(), limit = surfaces.friction * lack;
  const double stopped = speed > 0.0 ? std::min(1.0, limit / speed) : 0.0;
  change -= stopped * sliding;
  const double apart = std::max(0.0, along), restoring = along + lack;
  work_.restored += 0.5 * (restoring * restoring - apart * apart) / event.inverse_mass;
  // The work of an impulse is the impulse times the mean of the velocities before the kick
  // (EventMotion::kicks) and after the impulse. `velocity` contains the kick, so half of the kick
  // is subtracted.
  Vec3 kick = Vec3::Zero();
  for (int k = 0; k < 4; ++k)
    if (event.vertices[k] < motion.v.rows() && !(event.with_body >> k & 1u))
      kick += event.weights[k] * motion.kick(event.vertices[k]);
  work_.friction +=
      stopped * sliding.dot((1.0 - 0.5 * stopped) * sliding - 0.5 * kick) / event.inverse_mass;
  add_work(event, change / event.inverse_mass, motion);
  for (int k = 0; k < 4; ++k) {
    const Index i = event.vertices[k];
    if (inverse_mass_[i] == 0.0 || event.with_body >> k & 1u) continue;
    const Vec3 own = event.weights[k] * inverse_mass_[i] / event.inverse_mass * change;
    motion.v.row(i) += own.transpose();
    motion.x.row(i) += motion.ahead(i) * own.transpose();
  }
  if (event.body < 0) return true;
  EventBody& body = bodies_[event.body].body;
  body.touched = true;
  if (event.with_body != 0) {
    const Vec3 impulse = change / event.inverse_mass;
    const Vec3 arm = event.body_moment - event.body_weight * body.pose.position;
    body.push(event.body_weight * impulse, arm.cross(impulse));
    return true;
  }
  // The first feature, whose weights are positive, receives the impulse along `change`. The second
  // feature receives the opposite impulse.
  const bool first = body_of(event.vertices[0]) == event.body;
  const Vec3 impulse = (first ? 1.0 : -1.0) / event.inverse_mass * change;
  body.push(impulse, (event.touched - body.pose.position).cross(impulse));
  return true;
}

// Adds the work of prescribed vertices and obstacles. `impulse` acts on the feature whose weights
// are positive, and the opposite impulse acts on the other feature.
void EventContacts::add_work(const Event& event, const Vec3& impulse, const EventMotion& motion) {
  for (int k = 0; k < 4; ++k) {
    const Index i = event.vertices[k];
    if (inverse_mass_[i] == 0.0 && body_of(i) < 0)
      work_.prescribed -= event.weights[k] * impulse.dot(velocity(i, event, motion));
  }
}

double EventContacts::next_time(const Event& event, Index pair, double time,
                                const EventMotion& motion) const {
  double shortest = motion_->step;
  std::array<Vec3, 4> velocities;
  std::array<double, 4> speeds;
  for (int k = 0; k < 4; ++k) {
    const Index i = event.vertices[k];
    if (i < motion.v.rows()) shortest = std::min(shortest, motion.step(i));
    velocities[k] = velocity(i, event, motion);
    speeds[k] = event.normal.dot(velocities[k]);
  }
  const ContactKind kind = pairs_[pair].kind;
  const double gap = event.distance - event.thickness;
  double wait = time_to_close(gap, largest_approach(kind, speeds));
  if (event.to_cross > 0.0) {
    double fastest2 = 0.0;
    for (int i = 0; i < 2; ++i)
      for (int k = 2; k < 4; ++k)
        fastest2 = std::max(fastest2, (velocities[i] - velocities[k]).squaredNorm());
    wait = std::max(wait, time_to_close(event.to_cross, std::sqrt(fastest2)));
  }
  return time + std::max(shortest, wait);
}

void EventContacts::place_bodies(const EventMotion& motion) {
  bodies_.clear();
  for (std::size_t b = 0; b < motion.bodies.size(); ++b) {
    EventBody now = motion.bodies[b];
    if (const double ahead = motion.body_ahead(static_cast<Index>(b)); ahead != 0.0)
      now.pose = now.pose_after(-ahead);
    bodies_.push_back({now, rotation_matrix(now.pose.orientation) *
                                rotation_matrix(now.start.orientation).transpose()});
  }
}

void EventContacts::return_bodies(const EventMotion& motion) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    motion.bodies[b].velocity = bodies_[b].body.velocity;
    motion.bodies[b].angular_velocity = bodies_[b].body.angular_velocity;
    motion.bodies[b].touched = bodies_[b].body.touched;
  }
}

void EventContacts::act(const Team& team, Index tick, const EventMotion& motion) {
  std::vector<Index>& due = due_[tick];
  if (due.empty()) return;
  const double length = motion_->step / static_cast<double>(n_ticks_), time = tick * length;
  // begin() and each earlier call of act() have added their pairs in ascending order.
  merge_runs(due, ascending_runs(due), std::less<>());
  place_bodies(motion);
  all_placed_ = 4 * static_cast<Index>(due.size()) > motion_->x0.rows();
  if (all_placed_) place_vertices(team, time, motion);
  const auto n = static_cast<Index>(due.size());
  events_.resize(due.size());
  next_.resize(due.size());
  parallel_for(
      team, n, [&](Index i) { events_[i] = evaluate(due[i], points_of(due[i], time, motion)); },
      256);
  n_evaluated_ += n;
  for (Index i = 0; i < n; ++i) n_impulses_ += push(events_[i], due[i], motion);
  parallel_for(
      team, n, [&](Index i) { next_[i] = next_time(events_[i], due[i], time, motion) / length; },
      256);
  for (Index i = 0; i < n; ++i)
    if (next_[i] < static_cast<double>(n_ticks_))
      due_[std::max(tick + 1, static_cast<Index>(next_[i]))].push_back(due[i]);
  return_bodies(motion);
  due.clear();
}

void EventContacts::act_on(const std::vector<Index>& vertices, const EventMotion& motion) {
  const double now = motion.clocks->now;
  touched_.clear();
  for (const Index vertex : vertices)
    for (const Index pair : pairs_of_[vertex])
      if (wake_[pair] <= now) touched_.push_back(pair);
  if (touched_.empty()) return;
  sort_unique(touched_);
  place_bodies(motion);
  all_placed_ = false;
  for (const Index pair : touched_) {
    const Event event = evaluate(pair, points_of(pair, now, motion));
    n_impulses_ += push(event, pair, motion);
    wake_[pair] = next_time(event, pair, now, motion);
  }
  n_evaluated_ += static_cast<std::int64_t>(touched_.size());
  return_bodies(motion);
}

}  // namespace loomstone
