// A membrane sheet for tests, a strongly deformed shape of it, and helpers that evaluate its forces
// and matrices.
#pragma once

#include <random>

#include "core/cloth/membrane/membrane.h"
#include "core/mesh/generators.h"

namespace loomstone {

struct Sheet {
  TriangleMesh mesh;
  Membrane membrane;
};

inline Sheet make_sheet(const ClothMaterial& material, double jitter = 0.24) {
  TriangleMesh mesh = jittered_grid(0.3, 0.2, 6, 4, jitter, 7);
  const auto corners = rest_corners(mesh, true, "mesh");
  Membrane membrane(
      mesh.n_vertices(), mesh.triangles(), corners,
      std::vector<MembraneConstants>(mesh.n_triangles(), membrane_constants(material, "material")));
  return {std::move(mesh), std::move(membrane)};
}

inline ClothMaterial orthotropic() {
  ClothMaterial m;
  m.weft_stiffness = 400, m.warp_stiffness = 150, m.shear_stiffness = 40, m.poisson = 0.4;
  m.viscosity_dilation = -0.02, m.viscosity_shear = 0.05;
  return m;
}

inline Points random_points(Index n, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  Points p(n, 3);
  for (Index i = 0; i < p.size(); ++i) p.data()[i] = uniform(generator);
  return p;
}

// Returns the vertices of a sheet that is strongly stretched and sheared, bent into waves and
// jittered at random.
inline Points deformed(const TriangleMesh& mesh, unsigned seed) {
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i) {
    const double u = x(i, 0), v = x(i, 1);
    x.row(i) << 1.2 * u + 0.3 * v, 0.8 * v - 0.1 * u, 0.05 * std::sin(20 * u) * std::cos(15 * v);
  }
  return x + random_points(static_cast<Index>(x.rows()), 0.004, seed);
}

inline Points force_of(Membrane& membrane, const Points& x, const Points* v = nullptr) {
  Points f = Points::Zero(x.rows(), 3);
  membrane.add_forces({}, x, v, 0, static_cast<Index>(x.rows()), f);
  return f;
}

inline BlockMatrix pattern(const TriangleMesh& mesh) {
  std::vector<std::pair<Index, Index>> couplings;
  for (Index t = 0; t < mesh.n_triangles(); ++t)
    for (int k = 0; k < 3; ++k)
      couplings.emplace_back(mesh.triangles()(t, k), mesh.triangles()(t, (k + 1) % 3));
  return BlockMatrix(mesh.n_vertices(), couplings);
}

inline Eigen::MatrixXd dense(const BlockMatrix& a) {
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(3 * a.n_rows(), 3 * a.n_rows());
  for (Index i = 0; i < a.n_rows(); ++i)
    for (Index k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k)
      d.block<3, 3>(3 * i, 3 * a.columns()[k]) = a.block_map(k);
  return d;
}

inline double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

}  // namespace loomstone
