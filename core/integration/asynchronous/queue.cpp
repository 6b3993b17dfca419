// Asynchronous variational integrator as in section 4.2 of [Thomaszewski2010]: every triangle has
// its own step, and a queue orders the events. If Asynchronous::bending_multiple is not 0, groups
// of bending also have steps of their own.
#include <algorithm>
#include <utility>

#include "core/base/simd.h"
#include "core/integration/asynchronous/asynchronous.h"
#include "core/integration/asynchronous/event_queue.h"

namespace loomstone {

namespace {

// Returns a membrane in which all lanes of a batch contain the same triangle.
Membrane spread_membrane(const ClothModel& model) {
  const auto m = static_cast<Index>(model.triangles.rows());
  Triangles triangles(n_lanes * m, 3);
  std::vector<Corners2> corners;
  std::vector<MembraneConstants> constants;
  for (Index i = 0; i < n_lanes * m; ++i) {
    triangles.row(i) = model.triangles.row(i / n_lanes);
    corners.push_back(model.corners[i / n_lanes]);
    constants.push_back(model.constants_of(i / n_lanes));
  }
  return {model.n_vertices, triangles, corners, constants};
}

class QueueIntegrator final : public AsynchronousIntegrator {
 public:
  QueueIntegrator(const Asynchronous& options, const ClothModel& model, Elasticity& elasticity)
      : AsynchronousIntegrator(options, model, elasticity),
        membrane_(spread_membrane(model)),
        forces_(static_cast<std::size_t>(membrane_.n_batches()) * membrane::force_stride) {
    limit_membrane();
    const bool together = options.bending_multiple == 0.0;
    if (!together) own_ = bending_event_steps();
    group_of_.assign(model.triangles.rows(), -1);
    for (const BendingMesh& mesh : meshes_) add_groups(mesh, together);
    if (membrane_.viscous()) rates_ = Points::Zero(model.n_vertices, 3);
  }

  bool events_collide() const override { return true; }

  // Functions that take_events() calls. Elements are the triangles, followed by the groups of
  // bending that have events of their own.
  double step(Index element) const { return element_step_[element]; }
  void move(Index element, double time) {
    for_vertices(element, [&](Index i) {
      if (const Index body = bodies_.body_of(i); body >= 0) return move_body(body, time);
      state_->x.row(i) += (time - time_[i]) * state_->v.row(i);
      time_[i] = time;
    });
  }
  void kick(Index element, double duration) {
    for_vertices(element, [&](Index i) { kicks_.row(i) = -state_->v.row(i); });
    if (element < model_.triangles.rows()) {
      kick_membrane(element, duration);
      ++events_;
    }
    const Index group = group_at(element);
    if (group >= 0)
      groups_[group].kick({}, {duration, duration, false}, inverse_mass_, state_->x, state_->v);
    if (impulses_ && element < model_.triangles.rows())
      impulses_->correct(element, element_step_[element], state_->x, state_->v);
    for_vertices(element, [&](Index i) {
      if (const Index body = bodies_.body_of(i); body >= 0)
        bodies_.absorb(body, 0.0, state_->x, state_->v);
    });
    for_vertices(element, [&](Index i) { kicks_.row(i) += state_->v.row(i); });
    if (collisions_ && element < model_.triangles.rows()) collide(element);
    for_vertices(element, [&](Index i) { kicks_.row(i).setZero(); });
  }

 private:
  // Handles the collisions of a triangle's corners in an event of the triangle, and passes their
  // impulses on to the attached bodies.
  void collide(Index triangle) {
    corners_.assign(model_.triangles.row(triangle).begin(), model_.triangles.row(triangle).end());
    const double now = time_[corners_[0]];
    const EventMotion::Clocks clocks{time_, body_time_, now};
    collisions_->act_on(corners_, {state_->x, state_->v, bodies_.all(), kicks_, nullptr, &clocks});
    for (Index b = 0; b < bodies_.size(); ++b)
      bodies_.absorb(b, body_time_[b] - now, state_->x, state_->v);
  }
  template <class Visit>
  void for_vertices(Index element, Visit&& visit) {
    const Index group = group_at(element);
    if (group >= 0)
      for (const Index i : groups_[group].vertices()) visit(i);
    else
      for (int k = 0; k < 3; ++k) visit(model_.triangles(element, k));
  }
  void move_body(Index body, double time) {
    if (body_time_[body] == time) return;
    bodies_.drift(body, time - body_time_[body], state_->x, state_->v);
    body_time_[body] = time;
    for (const Index i : bodies_.vertices(body)) time_[i] = time;
  }
  // Adds the limit potential, if there is one, to membrane_, in which all lanes of a batch contain
  // the same triangle.
  void limit_membrane() {
    if (limits_.empty()) return;
    std::vector<LimitModes> spread;
    for (const LimitModes& modes : limits_) spread.insert(spread.end(), n_lanes, modes);
    membrane_.add_limits(spread);
    entered_.assign(membrane::entered_stride * limits_.size(), 0);
  }
  // Returns, for each triangle (m), the highest phase of each of its limit modes at its events in
  // the interval and at the end of the interval; empty without a limit potential.
  std::vector<LimitPhases> take_phases() {
    std::vector<LimitPhases> phases;
    if (limits_.empty()) return phases;
    for (Index t = 0; t < model_.triangles.rows(); ++t) find_force(t, 0.0);
    for (std::size_t i = 0; i < entered_.size(); i += membrane::entered_stride)
      phases.push_back(phases_of_lane(entered_.data() + i, 0));
    std::fill(entered_.begin(), entered_.end(), 0);
    return phases;
  }

  // Adds the bending groups of a mesh. If `together` is true, each triangle has a group, which acts
  // at the events of the triangle. Otherwise, each run of consecutive triangles with the same
  // bending step has a group with its own events.
  void add_groups(const BendingMesh& mesh, bool together) {
    const auto m = static_cast<Index>(mesh.triangles.size());
    for (Index first = 0, last = 0; first < m; first = last) {
      std::vector<Index> acting;
      const Index t = mesh.triangles[first];
      do acting.push_back(last++);
      while (!together && last < m && own_[mesh.triangles[last]] == own_[t]);
      if (together)
        group_of_[t] = static_cast<Index>(groups_.size());
      else
        group_step_.push_back(own_[t]);
      groups_.emplace_back(mesh, acting);
    }
  }
  // Returns the group that acts in the events of the element; -1: none.
  Index group_at(Index element) const {
    const auto m = static_cast<Index>(group_of_.size());
    return element < m ? group_of_[element] : element - m;
  }

  // Returns the forces of a triangle on its corners. Viscous forces depend on the mean strain rate
  // over `duration`, the time since the last event of the triangle [s], and are omitted if it is 0.
  // If they are included, stores the positions of the corners for the next event of the triangle.
  // Records the limit phases of the triangle in entered_.
  const double* find_force(Index triangle, double duration) {
    membrane::Tables tables = membrane_.tables();
    if (!entered_.empty()) tables.entered = entered_.data();
    const bool viscous = membrane_.viscous() && duration > 0.0;
    for (int k = 0; k < 3 && viscous; ++k) {
      const Index i = model_.triangles(triangle, k);
      auto last = state_->element_positions.row(3 * triangle + k);
      rates_.row(i) = (state_->x.row(i) - last) / duration;
      last = state_->x.row(i);
    }
    tables.rate_time = duration;
    membrane::forces(tables, &triangle, 1, state_->x.data(), viscous ? rates_.data() : nullptr,
                     forces_.data());
    return forces_.data() + membrane::force_stride * static_cast<std::size_t>(triangle);
  }
  void kick_membrane(Index triangle, double duration) {
    const double* f = find_force(triangle, duration);
    for (int k = 0; k < 3; ++k) {
      const Index i = model_.triangles(triangle, k);
      for (int d = 0; d < 3; ++d)
        state_->v(i, d) += duration * inverse_mass_[i] *
                           (f[n_lanes * (3 * k + d)] + steps_.share(triangle, k) * load_(i, d));
    }
  }

  bool damped() const {
    return membrane_.viscous() ||
           std::any_of(groups_.begin(), groups_.end(),
                       [](const auto& group) { return group.damping() > 0; });
  }
  // Sets BendingGroup::last() from ClothState::element_positions, which contains the positions at
  // the last events of all elements: corners of the triangles, then vertices of the groups. Rows of
  // elements without damping are not used. If the table is empty or `refill` is true, sets last()
  // and the corners in the table to the positions at the start of the interval instead. Does
  // nothing if no element is damped.
  void begin_damping(bool refill, ClothState& state) {
    if (!damped()) return;
    Points& rows = state.element_positions;
    Index next = 3 * model_.triangles.rows();
    const bool known = rows.rows() > 0 && !refill;
    for (BendingGroup& group : groups_) next += static_cast<Index>(group.vertices().size());
    rows.conservativeResize(next, 3);
    next = 3 * model_.triangles.rows();
    for (Index i = 0; i < next && !known; ++i)
      rows.row(i) = state.x.row(model_.triangles(i / 3, i % 3));
    for (BendingGroup& group : groups_)
      for (Index i = 0; i < group.last().rows(); ++i, ++next)
        group.last().row(i) = known ? rows.row(next) : state.x.row(group.vertices()[i]);
  }
  void end_damping(ClothState& state) {
    if (!damped()) return;
    Index next = 3 * model_.triangles.rows();
    for (BendingGroup& group : groups_)
      for (Index i = 0; i < group.last().rows(); ++i, ++next)
        state.element_positions.row(next) = group.last().row(i);
  }

  Taken take_interval(const Team&, double interval, const Vector& steps,
                      ClothState& state) override {
    const auto m = static_cast<Index>(steps.size());
    element_step_.resize(m + static_cast<Index>(group_step_.size()));
    for (Index e = 0; e < element_step_.size(); ++e)
      element_step_[e] = e < m ? steps[e] : group_step_[e - m];
    const bool refill = options_.schedule == Schedule::Refill;
    // An element whose step is longer than the interval would otherwise have no event.
    if (refill) element_step_ = element_step_.cwiseMin(interval);
    Points2& clocks = state.element_clocks;
    if (refill || clocks.rows() != element_step_.size()) {
      clocks.resize(element_step_.size(), 2);
      clocks.col(0).setZero();
      clocks.col(1) = element_step_;
    }
    state_ = &state;
    begin_damping(refill, state);
    events_ = 0;
    time_ = Vector::Zero(model_.n_vertices);
    kicks_ = Points::Zero(model_.n_vertices, 3);
    body_time_ = Vector::Zero(bodies_.size());
    if (collisions_) collisions_->begin(0);
    for (Index b = 0; b < bodies_.size(); ++b) {
      bodies_.load(b, 0.5);
      bodies_.absorb(b, 0.0, state.x, state.v);
    }
    take_events(interval, *this, clocks);
    for (Index i = 0; i < model_.n_vertices; ++i)
      if (bodies_.body_of(i) < 0) state.x.row(i) += (interval - time_[i]) * state.v.row(i);
    for (Index b = 0; b < bodies_.size(); ++b) move_body(b, interval);
    for (Index b = 0; b < bodies_.size(); ++b) {
      bodies_.load(b, 0.5);
      bodies_.absorb(b, 0.0, state.x, state.v);
    }
    end_damping(state);
    std::vector<LimitPhases> phases = take_phases();
    state_ = nullptr;
    return {element_step_.head(m), events_, std::move(phases)};
  }

  Membrane membrane_;
  std::vector<double> forces_;
  // (n x 3) Scratch memory of find_force(): mean velocities since the last event of the triangle
  // [m/s]. Used only if the membrane is viscous.
  Points rates_;
  // Bits of the limit phases that have been entered, see membrane::Tables; empty without a limit
  // potential.
  std::vector<std::uint8_t> entered_;
  std::vector<BendingGroup> groups_;
  Vector own_;                      // (m) bending steps [s]; empty: bending acts at membrane events
  std::vector<Index> group_of_;     // (m) group that acts at the events of each triangle; -1: none
  std::vector<double> group_step_;  // steps of the groups with events of their own [s]

  // Within an interval: the state, the times since the start of the interval that vertices and
  // bodies have reached [s], and the steps of the elements [s].
  ClothState* state_ = nullptr;
  Vector time_, body_time_, element_step_;
  std::vector<Index> corners_;
  Points kicks_;             // see EventMotion
  std::int64_t events_ = 0;  // number of events of triangles
};

}  // namespace

std::unique_ptr<Integrator> make_queue(const Asynchronous& options, const ClothModel& model,
                                       Elasticity& elasticity) {
  return std::make_unique<QueueIntegrator>(options, model, elasticity);
}

}  // namespace loomstone
