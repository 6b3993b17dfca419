// Triangles, sheets and momenta for the tests of strain limits.
#pragma once

#include <array>
#include <random>
#include <vector>

#include "core/cloth/limits/strain_limiter.h"
#include "core/mesh/generators.h"

namespace loomstone::test {

inline LimitedCloth one_triangle(const Corners2& corners, const Vec3& mass,
                                 const StrainLimit& limit) {
  LimitedCloth cloth;
  cloth.n_vertices = 3;
  cloth.triangles.resize(1, 3);
  cloth.triangles << 0, 1, 2;
  cloth.corners = {corners};
  cloth.limits = {limit};
  cloth.limit_of = {0};
  cloth.mass = mass;
  cloth.prescribed = {0, 0, 0};
  return cloth;
}

inline LimitedCloth sheet(const TriangleMesh& mesh, const StrainLimit& limit,
                          const std::vector<Index>& pins = {}) {
  LimitedCloth cloth;
  cloth.n_vertices = mesh.n_vertices();
  cloth.triangles = mesh.triangles();
  cloth.corners = rest_corners(mesh, true, "mesh");
  cloth.limits = {limit};
  cloth.limit_of.assign(mesh.n_triangles(), 0);
  cloth.mass = Vector::Zero(mesh.n_vertices());
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    const Corners2& c = cloth.corners[t];
    const Vec2 a = (c.row(1) - c.row(0)).transpose(), b = (c.row(2) - c.row(0)).transpose();
    for (int k = 0; k < 3; ++k)
      cloth.mass[mesh.triangles()(t, k)] += 0.3 / 6 * (a.x() * b.y() - a.y() * b.x());
  }
  cloth.prescribed.assign(mesh.n_vertices(), 0);
  for (const Index pin : pins) cloth.prescribed[pin] = 1;
  return cloth;
}

inline LimitOptions sweeping(const char* method, double tolerance = 1e-3, int max_sweeps = 2000,
                             bool active_set = true) {
  LimitOptions o;
  o.method = choice_named<LimitMethod>(method, "method");
  o.tolerance = tolerance, o.max_sweeps = max_sweeps, o.active_set = active_set;
  return o;
}

inline Points strain_of(const LimitedCloth& cloth, const Points& x) {
  Points strain;
  corotational_strain({}, cloth.triangles, cloth.corners, x, strain);
  return strain;
}

inline Vec3 momentum(const Vector& mass, const Points& shift) { return shift.transpose() * mass; }
inline Vec3 angular_momentum(const Vector& mass, const Points& x, const Points& shift) {
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < x.rows(); ++i) sum += mass[i] * Vec3(x.row(i)).cross(Vec3(shift.row(i)));
  return sum;
}

// Equilateral, right-angled, sliver and low isosceles triangles. Matrix A1 of (3.12) in
// [Thomaszewski2010] is singular if the third corner lies above the middle of the base, as in the
// first and in the last of these triangles.
inline std::vector<Corners2> shapes() {
  Corners2 equilateral, right, sliver, middle;
  equilateral << 0, 0, 0.01, 0, 0.005, 0.008660254037844387;
  right << 0, 0, 0.01, 0, 0, 0.01;
  sliver << 0, 0, 0.01, 0, 0.0101, 0.0002;
  middle << 0, 0, 0.01, 0, 0.005, 0.003;
  return {equilateral, right, sliver, middle};
}

}  // namespace loomstone::test
