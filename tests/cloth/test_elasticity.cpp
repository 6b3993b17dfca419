// Tests of the forces and energies that Elasticity stores for its last positions. They must be
// bitwise equal to those of a new object, which has stored none.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/cloth/elasticity.h"
#include "core/mesh/generators.h"

using namespace loomstone;

namespace {

ClothModel sheet(const TriangleMesh& mesh, double viscosity, double damping) {
  ClothMaterial material;
  material.viscosity_shear = viscosity;
  const Index n = mesh.n_triangles();
  ClothModel model;
  model.n_vertices = mesh.n_vertices();
  model.triangles = mesh.triangles();
  model.corners = rest_corners(mesh, true, "mesh");
  model.first_vertex = {0, model.n_vertices};
  model.first_triangle = {0, n};
  model.constants = {membrane_constants(material, "material")};
  model.rest_positions = mesh.vertices();
  model.mass = lumped_mass(model.n_vertices, model.triangles, model.corners.all(),
                           std::vector<double>(n, material.density));
  model.prescribed.assign(model.n_vertices, 0);
  ClothModel::BendingPart part;
  part.rigidity = 1e-5 * Mat3::Identity();
  part.damping = damping;
  model.bending.push_back(part);
  StrainLimit limit;
  limit.weft = limit.warp = 0.01;
  model.strain_limits.assign(1, limit);
  model.strain_limit_of.assign(n, 0);
  return model;
}

Points wavy(const Points& rest, double height) {
  Points x = rest;
  for (Index i = 0; i < x.rows(); ++i)
    x(i, 2) += height * std::sin(40.0 * x(i, 0)) * std::cos(30.0 * x(i, 1));
  return x;
}

struct Values {
  Points force;
  double membrane, bending;
  bool operator==(const Values& other) const {
    return force == other.force && membrane == other.membrane && bending == other.bending;
  }
};

Values values(Elasticity& elasticity, const Points& x, const Points* v) {
  Values found;
  found.force = Points::Constant(x.rows(), 3, 0.125);
  const Points still = Points::Zero(x.rows(), 3);
  const Index n = static_cast<Index>(x.rows());
  elasticity.add_implicit_forces(Team{2}, x, v, 0, n, found.force);
  elasticity.add_explicit_bending(Team{2}, x, v ? *v : still, 0, n, found.force);
  found.membrane = elasticity.membrane_energy(Team{2}, x);
  found.bending = elasticity.bending_energy(Team{2}, x);
  return found;
}

// Evaluates one Elasticity repeatedly, with and without a limit phase. Compares each result with
// that of a new Elasticity.
void check_repeated(const ClothModel& model, BendingTreatment treatment,
                    const std::vector<Points>& positions, const Points& v) {
  const auto phase_at = [&](Elasticity& elasticity, const Points& x) {
    return elasticity.limit_phase(Team{1}, x, 0, model.n_vertices);
  };
  const auto fresh = [&](const Points& x, const Points* velocity, bool phase) {
    Elasticity elasticity(model, treatment);
    const auto scope = phase ? phase_at(elasticity, x) : Elasticity::LimitPhaseScope();
    return values(elasticity, x, velocity);
  };
  Elasticity elasticity(model, treatment);
  for (const Points& x : positions)
    for (const Points* const velocity : {static_cast<const Points*>(nullptr), &v}) {
      CHECK(values(elasticity, x, velocity) == fresh(x, velocity, false));
      CHECK(values(elasticity, x, velocity) == fresh(x, velocity, false));
      {
        const auto scope = phase_at(elasticity, x);
        CHECK(values(elasticity, x, velocity) == fresh(x, velocity, true));
      }
      CHECK(values(elasticity, x, velocity) == fresh(x, velocity, false));
    }
  // The phase changes the values, so the checks above detect a phase that is kept by mistake.
  CHECK(!(fresh(positions.front(), nullptr, true) == fresh(positions.front(), nullptr, false)));
}

}  // namespace

TEST_CASE("forces and energies do not depend on those that were computed before") {
  const TriangleMesh mesh = grid_cells(0.3, 0.3, 17, 17);
  const Points low = wavy(mesh.vertices(), 1e-3), high = wavy(mesh.vertices(), 4e-3);
  const Points v = 10.0 * (high - low);
  for (const double damping : {0.0, 0.01})
    for (const auto treatment :
         {BendingTreatment::Explicit, BendingTreatment::Lumped, BendingTreatment::Full})
      check_repeated(sheet(mesh, damping, damping), treatment, {high, low, high, high, low}, v);
}

TEST_CASE("known forces of one range of rows are not used for another") {
  const TriangleMesh mesh = grid_cells(0.3, 0.3, 17, 17);
  const ClothModel model = sheet(mesh, 0.0, 0.0);
  const Points x = wavy(mesh.vertices(), 4e-3);
  const Index n = model.n_vertices, middle = n / 2;
  Elasticity elasticity(model, BendingTreatment::Explicit);
  const Points whole = values(elasticity, x, nullptr).force, still = Points::Zero(n, 3);
  for (const auto& [begin, end] : {std::pair(0, middle), std::pair(middle, n), std::pair(0, n)}) {
    Points force = Points::Constant(n, 3, 0.125);
    elasticity.add_implicit_forces(Team{1}, x, nullptr, begin, end, force);
    elasticity.add_explicit_bending(Team{1}, x, still, begin, end, force);
    CHECK(force.middleRows(begin, end - begin) == whole.middleRows(begin, end - begin));
    CHECK((force.topRows(begin).array() == 0.125).all());
    CHECK((force.bottomRows(n - end).array() == 0.125).all());
  }
}
