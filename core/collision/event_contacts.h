// Contacts at events within a step (core/base/event_motion.h). An impulse with Coulomb friction
// ([Thomaszewski2010], (2.58), (2.59)) stops the approach of a pair that is closer than its
// thickness, and the pair then regains its thickness slowly. Each pair is evaluated again when it
// may be closer than its thickness, but in nested steps no sooner than after the shortest time
// between events of its cloth vertices. Two edges push each other only if their closest points lie
// inside both edges. Otherwise an end vertex of one edge is closest to the other edge, and the
// pairs of this vertex with the faces at the other edge are at least as close. Implements the
// second stage of [Thomaszewski2010], 4.3.
#pragma once

#include <optional>
#include <vector>

#include "core/base/event_motion.h"
#include "core/collision/approach.h"
#include "core/collision/model/feature_pairs.h"
#include "core/parallel/team.h"

namespace loomstone {

// Work of the impulses of a step [J].
struct EventWork {
  double prescribed = 0.0;  // work done by prescribed vertices and obstacles
  double friction = 0.0;    // work done against friction
  // Work done by impulses that move two features apart, so that the pair regains its thickness.
  double restored = 0.0;
};

class EventContacts {
 public:
  EventContacts(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                const Vector& inverse_mass);

  // Sets the pairs to evaluate in a step. Vertices of obstacles follow the expected motion. The
  // arrays of `motion` must outlive the step.
  void set_pairs(const ExpectedMotion& motion, std::vector<ApproachingPair> pairs);
  // Begins or repeats the step. `n_ticks` is the number of ticks of equal length into which the
  // step is divided, or 0 if the events come from a queue.
  void begin(Index n_ticks);
  // Evaluates the pairs that are due at the start of a tick and applies their impulses. All events
  // of vertices lie at boundaries of ticks.
  void act(const Team& team, Index tick, const EventMotion& motion);
  // Evaluates, at an event of a queue, the due pairs that contain a free cloth vertex in
  // `vertices`, and applies their impulses.
  void act_on(const std::vector<Index>& vertices, const EventMotion& motion);

  // Number of pair evaluations and number of impulses since set_pairs().
  std::int64_t n_evaluated() const { return n_evaluated_; }
  std::int64_t n_impulses() const { return n_impulses_; }
  // Work of the impulses since begin().
  const EventWork& work() const { return work_; }

 private:
  struct Event {
    std::array<Index, 4> vertices;
    std::array<double, 4> weights;
    Vec3 normal;
    double distance, inverse_mass;  // [m], [1/kg]; inverse mass 0: the pair gets no impulse
    double thickness;               // contact_distance() [m]
    Index body;                     // body in the pair; -1: none
    Vec3 touched;                   // contact point on the body [m]
    // The vertices of the pair that move with the body, if some of them are attached to it: a bit
    // for each, the sum of their weights, and the sum of weight times position [m]. Otherwise 0.
    unsigned with_body;
    double body_weight;
    Vec3 body_moment;
    bool at_end;      // true: two edges for which ClosestPair::interior is false
    double to_cross;  // motion_to_cross() if `at_end`, otherwise 0 [m]
  };
  void begin_queue();
  // A rigid body at the start of the current tick, or at the current event of a queue.
  struct PlacedBody {
    EventBody body;
    Mat3 turn;  // rotation since the start of the step
  };
  // Body of a vertex; -1: none.
  Index body_of(Index vertex) const;
  Vec3 place(Index vertex, double time, const EventMotion& motion) const;
  void place_vertices(const Team& team, double time, const EventMotion& motion);
  FourPoints points_of(Index pair, double time, const EventMotion& motion) const;
  Vec3 velocity(Index vertex, const Event& event, const EventMotion& motion) const;
  Vec3 relative_velocity(const Event& event, const EventMotion& motion) const;
  bool attached(Index vertex, Index body) const;
  void find_with_body(const FourPoints& points, Event& event) const;
  double inverse_mass_of(const Event& event) const;
  double movable(const Event& event, Index pair) const;
  Event evaluate(Index pair, const FourPoints& points);
  void place_bodies(const EventMotion& motion);
  void return_bodies(const EventMotion& motion) const;
  bool push(const Event& event, Index pair, const EventMotion& motion);
  void add_work(const Event& event, const Vec3& impulse, const EventMotion& motion);
  double next_time(const Event& event, Index pair, double time, const EventMotion& motion) const;

  const CollisionModel& model_;
  const std::vector<SurfacePair>& surface_pairs_;
  const Vector& inverse_mass_;
  std::optional<ExpectedMotion> motion_;
  std::vector<ApproachingPair> pairs_;
  std::vector<std::array<Index, 4>> vertices_;  // (pairs) see pair_vertices()
  // (pairs) Side of the first feature as defined by side_of(): 1 or -1; 0: unknown.
  std::vector<std::int8_t> side_;
  // (pairs) Contact normal at the last evaluation in this step. Before the first evaluation:
  // ApproachingPair::normal.
  std::vector<Vec3> normal_;
  Index n_ticks_ = 1;
  // (n_ticks + 1) Pairs due at the start of each tick. Last entry: pairs that begin() found not due
  // in this step.
  std::vector<std::vector<Index>> due_;
  // Used with a queue: the pairs of each free cloth vertex, the time from which each pair is due
  // [s], and the pairs of the current event.
  std::vector<std::vector<Index>> pairs_of_;
  std::vector<double> wake_;
  std::vector<Index> touched_;
  EventWork work_;
  std::vector<Event> events_;
  std::vector<double> next_;  // scratch: time of the next evaluation of each due pair [ticks]
  // Scratch: positions of all vertices at the start of the current tick [m], if all_placed_.
  Points placed_;
  bool all_placed_ = false;  // placed_ is set for the current tick
  std::vector<PlacedBody> bodies_;
  std::int64_t n_evaluated_ = 0, n_impulses_ = 0;
};

}  // namespace loomstone
