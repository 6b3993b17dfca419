#include "core/integration/asynchronous/asynchronous.h"

#include "core/base/message.h"

namespace loomstone {

AsynchronousIntegrator::AsynchronousIntegrator(const Asynchronous& options, const ClothModel& model,
                                               Elasticity& elasticity)
    : model_(model), options_(options), steps_(model, options), elasticity_(elasticity) {
  for (const auto& part : model.bending) meshes_.emplace_back(model, part);
  // The safety of limit="inradius" is not a share of the limit of stability.
  Asynchronous eigenvalue = options;
  if (options.limit == StepLimit::Inradius) eigenvalue = Asynchronous();
  bending_ = bending_steps(model, meshes_, eigenvalue.given_safety());
}

Vector AsynchronousIntegrator::own_bending_steps() const {
  Vector longest = (options_.bending_multiple * steps_.at_rest()).cwiseMin(bending_);
  equalise_patches(longest);
  return longest;
}

IntegrationReport AsynchronousIntegrator::advance(const Team& team, const RowLayout& layout,
                                                  const StepInputs& inputs, ClothState& state,
                                                  Points&) {
  if (model_.triangles.rows() == 0) return {};
  load_ = *inputs.force;
  gather_cloth_rows(layout, load_, wide_);
  inverse_mass_.resize(model_.n_vertices);
  for (Index i = 0; i < model_.n_vertices; ++i)
    inverse_mass_[i] = (*inputs.fixed)[i] ? 0.0 : 1.0 / model_.mass[i];
  // Steps follow the stretch at the start of the interval, and never grow again: steps that change
  // often gain energy.
  Vector steps = steps_.at(team, state.x, elasticity_);
  if (state.element_steps.size() == steps.size()) steps = steps.cwiseMin(state.element_steps);
  state.element_steps = steps;
  if (options_.bending_multiple == 0.0) steps = steps.cwiseMin(bending_);
  prescribe_velocities(inputs, state.x, state.v);
  const auto [taken, events] = take_interval(team, inputs.step, steps, state);
  place_fixed(inputs, state.x);
  const Index t = steps_.first_unstable(team, state.x, taken, elasticity_);
  if (t >= 0)
    throw StepFailure(
        formatted("cloth stretched so much within {:.3g} s that steps of {:.3g} s are unstable; "
                  "lower integrator.step or integrator.safety",
                  inputs.step, taken[t]));
  IntegrationReport report;
  report.events = events;
  return report;
}

std::unique_ptr<Integrator> make_asynchronous(const Asynchronous& options, const ClothModel& model,
                                              Elasticity& elasticity) {
  if (options.schedule == Schedule::Nested) return make_nested(options, model, elasticity);
  return make_queue(options, model, elasticity);
}

}  // namespace loomstone
