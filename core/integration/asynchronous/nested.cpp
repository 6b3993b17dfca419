// Asynchronous variational integrator [Lew2003] with nested steps: every triangle and every bending
// group has its own step, a power-of-two fraction of a common step. Its force acts as an impulse at
// both ends of its steps. Between impulses, vertices that are not attached to a body move at
// constant velocity. Elastic forces depend on positions only, so their impulses at the same time
// commute.
#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/message.h"
#include "core/integration/asynchronous/asynchronous.h"
#include "core/integration/asynchronous/level_membrane.h"
#include "core/integration/asynchronous/nested_steps.h"

namespace loomstone {

namespace {

// Vertices sorted by level. The level of a vertex is the finest level of its triangles and bending
// groups. Vertices attached to one body share the finest of their levels.
struct LevelVertices {
  std::vector<Index> order;         // (n) finest level first
  std::vector<std::uint8_t> level;  // (n)
  std::vector<Index> end;           // (levels) end of each level's vertices in `order`

  explicit LevelVertices(std::vector<std::uint8_t> levels, int finest) : level(std::move(levels)) {
    for (int k = finest; k >= 0; --k) {
      for (Index i = 0; i < static_cast<Index>(level.size()); ++i)
        if (level[i] == k) order.push_back(i);
      end.insert(end.begin(), static_cast<Index>(order.size()));
    }
  }
};

// Levels of the triangles for an interval, and the tables that depend on them.
struct Plan {
  double interval = 0.0;  // [s]
  Index base = 1;         // level k has base * 2^k steps in the interval
  // (m) For each triangle, the coarsest level whose step is at most the triangle's longest step.
  std::vector<std::uint8_t> wanted;
  // (m) Level of each triangle: that in `wanted`, or a finer one where LevelMembrane requires it.
  std::vector<std::uint8_t> level;
  std::vector<double> step_of;  // (levels) step of each level [s]
  std::unique_ptr<LevelMembrane> membrane;
  // (levels) Triangles of each level and of all finer levels; empty without limit impulses.
  std::vector<std::vector<Index>> limited;
  Vector steps;  // (m) step of the level of each triangle [s]
  LevelGroups groups;
  std::unique_ptr<LevelVertices> vertices;

  int finest() const { return static_cast<int>(step_of.size()) - 1; }
};

// The prescribed vertices in an interval, and the work that their scripted motion does against the
// forces of the cloth and the loads on it.
struct MovedPins {
  std::vector<Index> rows;  // empty if no prescribed vertex moves
  Points velocity;          // prescribed velocities [m/s]
  const Vector& mass;
  double work = 0.0;  // work of the script [J], without changes of the vertices' kinetic energy

  // Undoes the impulses that the vertices in `rows` have received, and adds the script's work
  // against these impulses to `work`.
  void absorb(Points& v) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Index i = rows[k];
      const auto given = velocity.row(static_cast<Index>(k));
      work -= mass[i] * (v.row(i) - given).dot(given);
      v.row(i) = given;
    }
  }
};

// The cloth with its bodies: the system that take_nested_steps() moves.
struct NestedCloth {
  const Team& team;
  Plan& plan;
  const Points& load;  // (n x 3) forces that do not change within the interval [N]
  const Vector& inverse_mass;
  MovedPins& pins;
  AttachedBodies& bodies;
  LimitImpulses* impulses;      // may be null
  EventCollisions* collisions;  // may be null
  Points &x, &v, &kicks;
  bool start = true;
  std::vector<double> ahead = {};  // (levels) see EventMotion::Levels

  void measure(int first, bool at_start) {
    start = at_start;
    plan.membrane->measure(team, first, x, start ? &v : nullptr, plan.step_of);
  }
  void kick(int first, bool half) {
    const double share = half ? 0.5 : 1.0;
    if (collisions) note_kicks(first, [&](Index i) { kicks.row(i) = -v.row(i); });
    plan.groups.for_event(first, [&](BendingGroup& group, int level) {
      const double h = plan.step_of[level];
      group.kick(team, {share * h, h, start}, inverse_mass, x, v);
      pins.absorb(v);
    });
    const LevelVertices& vertices = *plan.vertices;
    parallel_for(team, vertices.end[first], [&](Index k) {
      const Index i = vertices.order[k];
      const Vec3 impulse = plan.membrane->impulse(
          i, first, load.data() + 3 * static_cast<std::size_t>(i), plan.step_of);
      v.row(i) += share * inverse_mass[i] * impulse.transpose();
    });
    pins.absorb(v);
    for (Index b = 0; b < bodies.size(); ++b) {
      const int level = bodies.all()[b].level;
      if (level < first) continue;
      bodies.load(b, share * plan.step_of[level] / plan.interval);
      bodies.absorb(b, 0.0, x, v);
    }
    if (collisions)
      note_kicks(first, [&](Index i) { kicks.row(i) = (kicks.row(i) + v.row(i)) / share; });
  }
  template <class Note>
  void note_kicks(int first, Note&& note) const {
    parallel_for(team, plan.vertices->end[first], [&](Index k) { note(plan.vertices->order[k]); });
  }
  void drift(int first, Index tick) {
    find_ahead(tick);
    if (impulses) impulses->correct(team, plan.limited[first], plan.steps, x, v);
    const EventMotion::Levels levels{plan.vertices->level, plan.step_of, ahead};
    if (collisions) collisions->act(team, tick, {x, v, bodies.all(), kicks, &levels});
    for (Index b = 0; b < bodies.size() && (impulses || collisions); ++b)
      bodies.absorb(b, ahead[bodies.all()[b].level], x, v);
    const LevelVertices& vertices = *plan.vertices;
    parallel_for(team, vertices.end[first], [&](Index k) {
      const Index i = vertices.order[k];
      x.row(i) += plan.step_of[vertices.level[i]] * v.row(i);
    });
    for (Index b = 0; b < bodies.size(); ++b)
      if (const int level = bodies.all()[b].level; level >= first)
        bodies.drift(b, plan.step_of[level], x, v);
  }
  void find_ahead(Index tick) {
    const int finest = plan.finest();
    ahead.resize(plan.step_of.size());
    for (int level = 0; level <= finest; ++level) {
      const Index ticks = Index{1} << (finest - level), since = tick % ticks;
      ahead[level] = since == 0 ? 0.0 : static_cast<double>(ticks - since) * plan.step_of[finest];
    }
  }
};

class NestedIntegrator final : public AsynchronousIntegrator {
 public:
  using AsynchronousIntegrator::AsynchronousIntegrator;
  bool events_collide() const override { return true; }
  std::optional<double> work_on_prescribed() const override { return work_on_prescribed_; }

 private:
  Taken take_interval(const Team& team, double interval, const Vector& steps,
                      ClothState& state) override {
    make_plan(interval, steps);
    bodies_.share_levels(plan_.vertices->level);
    MovedPins pins{{}, {}, model_.mass};
    const Vector inverse_mass = find_pins(state.v, pins);
    NestedCloth cloth{team,        plan_,   load_,   inverse_mass, pins, bodies_, impulses_.get(),
                      collisions_, state.x, state.v, kicks_};
    if (collisions_) kicks_.resize(model_.n_vertices, 3);
    if (collisions_) collisions_->begin(plan_.base * (Index{1} << plan_.finest()));
    take_nested_steps(plan_.base, plan_.finest(), cloth);
    work_on_prescribed_ = pins.work;
    Taken taken{plan_.steps, 0, plan_.membrane->take_phases()};
    for (Index t = 0; t < steps.size(); ++t) {
      taken.events += plan_.base * (Index{1} << plan_.level[t]) + 1;
    }
    return taken;
  }

  // Lists the prescribed vertices in `pins` if any of them moves. Returns the inverse masses (n)
  // [1/kg], which are positive for listed vertices: impulses change their velocities until
  // MovedPins::absorb() undoes this.
  Vector find_pins(const Points& v, MovedPins& pins) const {
    Vector inverse = inverse_mass_;
    for (Index i = 0; i < inverse.size(); ++i)
      if (inverse[i] == 0.0) pins.rows.push_back(i);
    pins.velocity = v(pins.rows, Eigen::all);
    if (pins.velocity.isZero(0.0)) pins.rows.clear();
    for (const Index i : pins.rows) inverse[i] = 1.0 / model_.mass[i];
    return inverse;
  }

  // Updates plan_. The base does not depend on the state of the cloth, so a resumed run chooses the
  // same base.
  void make_plan(double interval, const Vector& steps) {
    if (interval != plan_.interval) {
      plan_ = {};
      plan_.interval = interval;
      const Vector bending = meshes_.empty() ? Vector() : bending_event_steps();
      plan_.base = choose_base(interval, steps_.at_rest(), bending);
      if (!meshes_.empty()) plan_.groups = LevelGroups(meshes_, levels_of(bending));
    }
    std::vector<std::uint8_t> wanted = levels_of(steps);
    if (wanted == plan_.wanted) return;
    plan_.wanted = plan_.level = std::move(wanted);
    plan_.membrane = std::make_unique<LevelMembrane>(model_, steps_, limits_, plan_.level);
    arrange();
  }

  // Sets the tables that depend on the levels of both membrane and bending.
  void arrange() {
    std::vector<std::uint8_t> levels = plan_.membrane->vertex_levels();
    plan_.groups.for_all([&](const BendingGroup& group, int level) {
      for (const Index i : group.vertices())
        levels[i] = std::max(levels[i], static_cast<std::uint8_t>(level));
    });
    bodies_.share_levels(levels);
    const int finest = *std::max_element(levels.begin(), levels.end());
    plan_.vertices = std::make_unique<LevelVertices>(std::move(levels), finest);
    plan_.step_of.clear();
    for (int level = 0; level <= finest; ++level)
      plan_.step_of.push_back(plan_.interval /
                              (static_cast<double>(plan_.base) * (Index{1} << level)));
    plan_.steps.resize(static_cast<Index>(plan_.level.size()));
    for (Index t = 0; t < plan_.steps.size(); ++t) plan_.steps[t] = plan_.step_of[plan_.level[t]];
    plan_.limited.clear();
    for (int level = 0; impulses_ && level <= finest; ++level)
      plan_.limited.push_back(plan_.membrane->triangles_from(level));
  }

  std::vector<std::uint8_t> levels_of(const Vector& longest) const {
    std::vector<std::uint8_t> levels;
    for (const double step : longest) {
      const int level = level_below(plan_.interval, plan_.base, step);
      if (level > finest_level)
        throw StepFailure(
            formatted("the asynchronous integrator needs steps of {:.3g} s in an interval of "
                      "{:.3g} s; lower integrator.step, or remove slivers from the mesh",
                      step, plan_.interval));
      levels.push_back(static_cast<std::uint8_t>(level));
    }
    return levels;
  }

  Plan plan_;
  double work_on_prescribed_ = 0.0;  // in the last interval [J]
  Points kicks_;                     // see EventMotion
};

}  // namespace

std::unique_ptr<Integrator> make_nested(const Asynchronous& options, const ClothModel& model,
                                        Elasticity& elasticity) {
  return std::make_unique<NestedIntegrator>(options, model, elasticity);
}

}  // namespace loomstone
