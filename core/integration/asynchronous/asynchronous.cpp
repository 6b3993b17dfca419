#include "core/integration/asynchronous/asynchronous.h"

#include <cmath>

#include "core/base/message.h"
#include "core/cloth/limit_potential.h"

namespace loomstone {

namespace {

// Largest number of repetitions of an interval. An interval is repeated if shorten() has shortened
// the step of any triangle. Our choice.
constexpr int most_repetitions = 8;

std::vector<LimitModes> potential_of(const Asynchronous& options, const ClothModel& model) {
  if (options.limiting != Limiting::Potential || model.strain_limits.empty()) return {};
  return limit_potential(model, options.predicted);
}

}  // namespace

AsynchronousIntegrator::AsynchronousIntegrator(const Asynchronous& options, const ClothModel& model,
                                               Elasticity& elasticity)
    : model_(model),
      limits_(potential_of(options, model)),
      options_(options),
      steps_(model, options, limits_),
      elasticity_(elasticity) {
  if (!limits_.empty()) elasticity.add_limits(limits_);
  if (options.limiting == Limiting::Impulses && !model.strain_limits.empty())
    impulses_ = std::make_unique<LimitImpulses>(model, options);
  for (const auto& part : model.bending) meshes_.emplace_back(model, part);
  // With limit="inradius", the given safety is not a fraction of the stability limit. Bending then
  // uses the default safety of limit="eigenvalue".
  Asynchronous eigenvalue = options;
  if (options.limit == StepLimit::Inradius) eigenvalue = Asynchronous();
  bending_ = bending_steps(model, meshes_, eigenvalue.given_safety());
}

Vector AsynchronousIntegrator::bending_event_steps() const {
  if (options_.bending_multiple == 0.0) return steps_.at_rest().cwiseMin(bending_);
  return (options_.bending_multiple * mean_of_patches(steps_.at_rest())).cwiseMin(bending_);
}

IntegrationReport AsynchronousIntegrator::advance(const Team& team, const RowLayout& layout,
                                                  const StepInputs& inputs, ClothState& state,
                                                  Points& body_velocity) {
  if (model_.triangles.rows() == 0) return {};
  load_ = inputs.force->whole(model_.n_vertices);
  collisions_ = inputs.collisions;
  gather_cloth_rows(layout, load_, wide_);
  inverse_mass_.resize(model_.n_vertices);
  for (Index i = 0; i < model_.n_vertices; ++i)
    inverse_mass_[i] = (*inputs.fixed)[i] ? 0.0 : 1.0 / model_.mass[i];
  // Steps are computed from positions and velocities at the start of the interval. Energy often
  // grows when steps change, so steps become shorter where necessary, but never longer again.
  prescribe_velocities(inputs, state.x, state.v);
  Vector steps = steps_.at(team, state.x, state.v, elasticity_);
  if (state.element_steps.size() == steps.size()) steps = steps.cwiseMin(state.element_steps);
  const ClothState start = limits_.empty() ? ClothState() : state;
  Taken taken;
  for (int repetition = 0;; ++repetition) {
    state.element_steps = steps;
    bodies_.begin(inputs, model_.mass, body_velocity, state.x, state.v);
    const Vector used = options_.bending_multiple == 0.0 ? steps.cwiseMin(bending_).eval() : steps;
    taken = take_interval(team, inputs.step, used, state);
    if (repetition == most_repetitions || !shorten(taken, steps)) break;
    state = start;
  }
  place_fixed(inputs, state.x);
  bodies_.finish(inputs, body_velocity);
  const Index t = steps_.first_unstable(team, state.x, taken.steps, elasticity_);
  if (t >= 0)
    throw StepFailure(
        formatted("cloth stretched so much within {:.3g} s that steps of {:.3g} s are unstable; "
                  "lower integrator.step or integrator.safety",
                  inputs.step, taken.steps[t]));
  IntegrationReport report;
  report.events = taken.events;
  report.synchronous_events =
      steps.size() * static_cast<std::int64_t>(std::ceil(inputs.step / steps.minCoeff()));
  return report;
}

// Shortens the step of each triangle that entered a stiff phase of a strain limit and took a longer
// step than its phases permit. Returns true if there is such a triangle.
bool AsynchronousIntegrator::shorten(const Taken& taken, Vector& steps) const {
  bool any = false;
  for (std::size_t t = 0; t < taken.phases.size(); ++t) {
    if (taken.phases[t] == LimitPhases{}) continue;
    const auto row = static_cast<Index>(t);
    const double step = steps_.step_in_phases(row, taken.phases[t]);
    if (taken.steps[row] <= step) continue;
    steps[row] = std::min(steps[row], step);
    any = true;
  }
  return any;
}

std::unique_ptr<Integrator> make_asynchronous(const Asynchronous& options, const ClothModel& model,
                                              Elasticity& elasticity) {
  if (options.bending_multiple > 0.0 && options.bending_multiple < 1.0)
    fail<InvalidInput>("integrator.bending_multiple must be 0 or at least 1, got {}",
                       options.bending_multiple);
  if (options.schedule == Schedule::Nested) return make_nested(options, model, elasticity);
  return make_queue(options, model, elasticity);
}

}  // namespace loomstone
