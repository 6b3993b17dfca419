// A small cloth with its integrator, without the other parts of a simulation.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/integration/integrator.h"
#include "core/integration/stable_step.h"
#include "core/mesh/generators.h"

namespace loomstone::test {

struct ClothRun {
  ClothModel model;
  std::unique_ptr<Elasticity> elasticity;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<RowLayout> layout;
  ClothState state;
  Points force, target, bodies;
  std::vector<std::uint8_t> fixed;
  std::vector<Mat3> body_mass;
  double step = 1e-3;
  int steps = 0;

  IntegrationReport advance() {
    StepInputs in;
    const OwnRows loads(force);
    in.step = step, in.time = steps++ * step;
    in.force = &loads, in.fixed = &fixed, in.target = &target, in.body_mass = &body_mass;
    return integrator->advance({}, *layout, in, state, bodies);
  }

  double kinetic_energy() const {
    double sum = 0.0;
    for (Index i = 0; i < model.n_vertices; ++i)
      sum += 0.5 * model.mass[i] * state.v.row(i).squaredNorm();
    return sum;
  }
  // Potential energy [J] of membrane, bending and the constant forces.
  double potential_energy() {
    double sum = elasticity->membrane_energy({}, state.x) + elasticity->bending_energy({}, state.x);
    for (Index i = 0; i < model.n_vertices; ++i) sum -= force.row(i).dot(state.x.row(i));
    return sum;
  }
  double energy() { return kinetic_energy() + potential_energy(); }
};

struct RunSetup {
  double bending = 0.0;          // flexural rigidity [N m]
  std::vector<Index> pins = {};  // prescribed vertices
  Vec3 gravity = Vec3::Zero();
  std::string element = "mid-edge";
};

inline ClothRun make_run(const TriangleMesh& mesh, const ClothMaterial& material,
                         const IntegratorOptions& options, const RunSetup& setup = {}) {
  const auto& [bending, pins, gravity, element] = setup;
  ClothRun run;
  ClothModel& m = run.model;
  m.n_vertices = mesh.n_vertices();
  m.triangles = mesh.triangles();
  m.corners = rest_corners(mesh, true, "mesh");
  m.first_vertex = {0, mesh.n_vertices()};
  m.first_triangle = {0, mesh.n_triangles()};
  m.constants = {membrane_constants(material, "material")};
  m.rest_positions = mesh.vertices();
  m.mass = lumped_mass(m.n_vertices, m.triangles, m.corners.all(),
                       std::vector<double>(mesh.n_triangles(), material.density));
  m.prescribed.assign(m.n_vertices, 0);
  for (const Index pin : pins) m.prescribed[pin] = 1;
  if (bending > 0.0) {
    ClothModel::BendingPart part;
    part.element = choice_named<BendingElement>(element, "element");
    part.rigidity.diagonal() << bending, bending, bending / 2;
    m.bending.push_back(part);
  }
  run.step = options.step().given.value();
  run.state.x = mesh.vertices();
  run.state.v = Points::Zero(m.n_vertices, 3);
  run.force = Points::Zero(m.n_vertices, 3);
  for (Index i = 0; i < m.n_vertices; ++i) run.force.row(i) = m.mass[i] * gravity.transpose();
  run.target = mesh.vertices();
  run.fixed = m.prescribed;
  run.bodies.resize(0, 3);
  run.layout = std::make_unique<RowLayout>(m.n_vertices, single_communicator());
  return run;
}

// Creates the elasticity and the integrator. They refer to the model, so `run` must not be moved
// afterwards.
inline void start(ClothRun& run, const IntegratorOptions& options) {
  run.elasticity = std::make_unique<Elasticity>(run.model, bending_treatment(options, run.model));
  run.integrator = make_integrator(options, run.model, *run.elasticity);
}

inline IntegratorOptions exact_options(const char* method, double step) {
  IntegratorOptions o = integrator_named(method);
  o.set_step(step);
  if (ImplicitOptions* const implicit = o.implicit())
    implicit->jacobian = JacobianKind::Exact, implicit->linear_solver = LinearMethod::Direct;
  if (NewtonOptions* const newton = o.newton()) newton->newton_tolerance = 1e-12;
  return o;
}

// Returns stable_step() [s] with explicit bending, for the cloths of a model at x (n x 3) [m].
inline double stable_step_at(const ClothModel& model, const Points& x) {
  Elasticity elasticity(model, BendingTreatment::Explicit);
  return stable_step(elasticity, model, x);
}

}  // namespace loomstone::test
