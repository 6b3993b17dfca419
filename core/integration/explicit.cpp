// Explicit (forward) Euler and symplectic Euler. Both set v+ = v + h f/m with the step h, the force
// f at the start of the step and the mass m. Explicit Euler then sets x+ = x + h v, and symplectic
// Euler ((2.52), (2.53) of [Thomaszewski2010]) sets x+ = x + h v+.
#include "core/integration/integrator_factories.h"

#include <algorithm>

namespace loomstone {

namespace {

class ExplicitIntegrator final : public Integrator {
 public:
  ExplicitIntegrator(bool symplectic, const ClothModel& model, Elasticity& elasticity)
      : symplectic_(symplectic), model_(model), elasticity_(elasticity) {}

  bool implicit() const override { return false; }
  Memory memory() const override { return {bytes_of(force_, velocity_, wide_), 0, 0}; }

  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                            ClothState& state, Points&) override {
    const Index n = model_.n_vertices, begin = std::min(layout.begin(), n),
                end = std::min(layout.end(), n);
    const double h = inputs.step;
    force_ = *inputs.force;
    elasticity_.add_implicit_forces(team, state.x, &state.v, begin, end, force_);
    elasticity_.add_explicit_bending(team, state.x, state.v, begin, end, force_);
    velocity_ = state.v;
    parallel_for(team, end - begin, [&](Index i) {
      const Index row = begin + i;
      velocity_.row(row) += h / model_.mass[row] * force_.row(row);
    });
    gather_cloth_rows(layout, velocity_, wide_);
    prescribe_velocities(inputs, state.x, velocity_);
    const Points& used = symplectic_ ? velocity_ : state.v;
    parallel_for(team, n, [&](Index i) { state.x.row(i) += h * used.row(i); });
    place_fixed(inputs, state.x);
    state.v = velocity_;
    return {};
  }

 private:
  bool symplectic_;
  const ClothModel& model_;
  Elasticity& elasticity_;
  OwnRows force_;
  Points velocity_, wide_;
};

}  // namespace

std::unique_ptr<Integrator> make_explicit(bool symplectic, const ClothModel& model,
                                          Elasticity& elasticity) {
  return std::make_unique<ExplicitIntegrator>(symplectic, model, elasticity);
}

}  // namespace loomstone
