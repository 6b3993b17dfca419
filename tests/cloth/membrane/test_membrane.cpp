// Tests of the orthotropic membrane, equations (2.7) to (2.36) of [Thomaszewski2010].
#include <catch2/catch.hpp>

#include <Eigen/LU>

#include "core/base/error.h"
#include "tests/cloth/membrane_support.h"
#include "tests/support/decompositions.h"

using namespace loomstone;

TEST_CASE("the membrane force is minus the gradient of its energy, with error of order 2") {
  Sheet s = make_sheet(orthotropic());
  const Points x = deformed(s.mesh, 1), d = random_points(s.mesh.n_vertices(), 1.0, 2);
  const double exact = -dot(force_of(s.membrane, x), d);
  double previous = 0.0;
  for (const double step : {1e-4, 1e-5, 1e-6}) {
    const double difference =
        (s.membrane.energy({}, x + step * d) - s.membrane.energy({}, x - step * d)) / (2 * step);
    const double error = std::abs(difference - exact) / std::abs(exact);
    // The error of central differences is of second order: a tenth of the step gives a hundredth of
    // the error, until rounding errors of 1e-16 / step dominate.
    if (previous > 1e-9) CHECK(error < previous / 90.0 + 1e-10);
    previous = error;
  }
  CHECK(previous < 1e-8);
}

TEST_CASE("the exact Jacobian is the derivative of the force, with error of order 2") {
  Sheet s = make_sheet(orthotropic());
  const Index n = s.mesh.n_vertices();
  const Points x = deformed(s.mesh, 3), d = random_points(n, 1.0, 4);
  BlockMatrix k = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {1.0, 0.0}}, 0, n, k);
  const Eigen::VectorXd flat = Eigen::Map<const Eigen::VectorXd>(d.data(), 3 * n);
  const Eigen::VectorXd product = dense(k) * flat;
  double previous = 0.0;
  for (const double step : {1e-4, 1e-5, 1e-6}) {
    const Points difference =
        (force_of(s.membrane, x - step * d) - force_of(s.membrane, x + step * d)) / (2 * step);
    const double error =
        (Eigen::Map<const Eigen::VectorXd>(difference.data(), 3 * n) - product).norm() /
        product.norm();
    if (previous > 1e-9) CHECK(error < previous / 90.0 + 1e-10);
    previous = error;
  }
  CHECK(previous < 1e-8);
}

TEST_CASE("the viscous Jacobian is the derivative of the viscous force") {
  Sheet s = make_sheet(orthotropic());
  const Index n = s.mesh.n_vertices();
  const Points x = deformed(s.mesh, 5), v = random_points(n, 1.0, 6);
  BlockMatrix d = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {0.0, 1.0}}, 0, n, d);
  // `viscous` is minus the viscous force, because `d` is minus the derivative of this force with
  // respect to v.
  const Points viscous = force_of(s.membrane, x) - force_of(s.membrane, x, &v);
  const Eigen::VectorXd product = dense(d) * Eigen::Map<const Eigen::VectorXd>(v.data(), 3 * n);
  // The force is linear in v, so both sides agree to rounding.
  CHECK((Eigen::Map<const Eigen::VectorXd>(viscous.data(), 3 * n) - product).norm() <
        1e-12 * product.norm() + 1e-13);
}

TEST_CASE("the positive Jacobian is symmetric and positive semidefinite, also under compression") {
  Sheet s = make_sheet(orthotropic());
  const Index n = s.mesh.n_vertices();
  Points x = deformed(s.mesh, 7);
  x.col(0) *= 0.5;
  BlockMatrix k = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Positive, {1.0, 0.3}}, 0, n, k);
  const Eigen::MatrixXd d = dense(k);
  CHECK((d - d.transpose()).norm() == 0.0);
  const Eigen::VectorXd eigenvalues = test::eigenvalues(d);
  CHECK(eigenvalues.minCoeff() > -1e-12 * eigenvalues.maxCoeff());
}

TEST_CASE("where all stresses are tensile the positive Jacobian is the exact one") {
  Sheet s = make_sheet(orthotropic());
  const Index n = s.mesh.n_vertices();
  Points x = s.mesh.vertices() * 1.1;
  BlockMatrix a = pattern(s.mesh), b = pattern(s.mesh);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {1.0, 0.0}}, 0, n, a);
  s.membrane.set_jacobian({}, x, {JacobianKind::Positive, {1.0, 0.0}}, 0, n, b);
  CHECK((dense(a) - dense(b)).norm() < 1e-13 * dense(a).norm());
}

TEST_CASE("viscous power is never positive, and zero for rigid velocities at any strain") {
  Sheet s = make_sheet(orthotropic());
  const Points x = deformed(s.mesh, 8), elastic = force_of(s.membrane, x);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Points v = random_points(s.mesh.n_vertices(), 1.0, 100 + seed);
    CHECK(dot(force_of(s.membrane, x, &v) - elastic, v) <= 0.0);
  }
  Points rigid(x.rows(), 3);
  const Vec3 a(1, -2, 3), omega(4, 5, -6);
  for (Index i = 0; i < x.rows(); ++i)
    rigid.row(i) = (a + omega.cross(x.row(i).transpose())).transpose();
  const Points random = random_points(s.mesh.n_vertices(), 1.0, 9);
  const double scale = (force_of(s.membrane, x, &random) - elastic).norm();
  CHECK((force_of(s.membrane, x, &rigid) - elastic).norm() < 1e-12 * scale);
}

TEST_CASE("rigid motion causes no membrane force") {
  Sheet s = make_sheet(orthotropic());
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Points moved =
      (s.mesh.vertices() * turn.transpose()).rowwise() + Eigen::RowVector3d(5, 6, 7);
  // Coordinates of about 10 m have rounding errors of 1e-15 m. The tolerance [N] allows for these
  // errors times a stiffness of 400 N/m.
  CHECK(force_of(s.membrane, moved).cwiseAbs().maxCoeff() < 1e-11);
}

TEST_CASE("internal forces have no sum and no torque") {
  Sheet s = make_sheet(orthotropic());
  const Points x = deformed(s.mesh, 10), v = random_points(s.mesh.n_vertices(), 1.0, 11),
               f = force_of(s.membrane, x, &v);
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  for (Index i = 0; i < x.rows(); ++i) sum += f.row(i), torque += x.row(i).cross(f.row(i));
  const double scale = f.cwiseAbs().sum();
  CHECK(sum.norm() < 1e-14 * scale);
  CHECK(torque.norm() < 1e-14 * scale);
}

TEST_CASE(
    "the patch test is exact on an irregular mesh: affine maps cause uniform strain and no inner "
    "force") {
  Sheet s = make_sheet(orthotropic(), 0.24);
  const TriangleMesh& mesh = s.mesh;
  Mat32 f;
  f << 1.1, 0.2, -0.1, 0.9, 0.3, 0.1;
  Points x(mesh.n_vertices(), 3);
  for (Index i = 0; i < x.rows(); ++i) x.row(i) = (f * mesh.uv().row(i).transpose()).transpose();
  Points green;
  Vector stretch;
  s.membrane.strain({}, x, green, stretch);
  const Mat2 e = 0.5 * (f.transpose() * f - Mat2::Identity());
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    CHECK(green(t, 0) == Approx(e(0, 0)).margin(1e-13));
    CHECK(green(t, 1) == Approx(e(1, 1)).margin(1e-13));
    CHECK(green(t, 2) == Approx(e(0, 1)).margin(1e-13));
  }
  const Points force = force_of(s.membrane, x);
  const double scale = force.cwiseAbs().maxCoeff();
  for (Index i = 0; i < x.rows(); ++i) {
    const bool inner = std::abs(mesh.uv()(i, 0)) < 0.149 && std::abs(mesh.uv()(i, 1)) < 0.099;
    if (inner) CHECK(force.row(i).norm() < 1e-12 * scale);
  }
}

TEST_CASE("a strip cut along weft, warp or bias and pulled has the strain of its compliance") {
  const ClothMaterial material = orthotropic();
  const MembraneConstants c = membrane_constants(material, "m");
  for (const double degrees : {0.0, 45.0, 90.0}) {
    const double angle = degrees * M_PI / 180.0;
    const Vec2 d(std::cos(angle), std::sin(angle));
    // Applies a uniaxial second Piola-Kirchhoff stress p along d; the strain follows from (2.23).
    const double p = 20.0, s11 = p * d.x() * d.x(), s22 = p * d.y() * d.y(),
                 s12 = p * d.x() * d.y();
    const double determinant = c.a11 * c.a22 - c.a12 * c.a12;
    Mat2 e;
    e(0, 0) = (c.a22 * s11 - c.a12 * s22) / determinant;
    e(1, 1) = (c.a11 * s22 - c.a12 * s11) / determinant;
    e(0, 1) = e(1, 0) = s12 / (2.0 * c.g);
    const Mat2 u = test::square_root(Mat2::Identity() + 2.0 * e);
    // Rectangle with its long side along d.
    const TriangleMesh base = jittered_grid(0.3, 0.1, 9, 3, 0.24, 3);
    Mat2 turn;
    turn << d.x(), -d.y(), d.y(), d.x();
    Points2 uv = base.uv() * turn.transpose();
    Points x = Points::Zero(uv.rows(), 3);
    x.leftCols<2>() = uv;
    const TriangleMesh mesh(x, base.triangles(), uv);
    Membrane membrane(mesh.n_vertices(), mesh.triangles(), rest_corners(mesh, true, "m"),
                      std::vector<MembraneConstants>(mesh.n_triangles(), c));
    x.leftCols<2>() = uv * u.transpose();
    const Points force = force_of(membrane, x);
    Vec2 pull = Vec2::Zero();  // force on the end at -0.15 m
    for (Index i = 0; i < x.rows(); ++i) {
      if (base.uv()(i, 0) < -0.1499)
        pull += force.row(i).head<2>().transpose();
      else if (base.uv()(i, 0) < 0.1499)
        CHECK(force.row(i).norm() < 1e-12);  // no force inside the sheet or on the long sides
    }
    // Width times F S d, with the stress S and the deformation gradient F = U.
    const Vec2 traction = 0.1 * (u * (p * d));
    CHECK((pull - traction).norm() < 1e-12);
    // Along weft and warp, the moduli are those of the material.
    if (degrees == 0.0) CHECK(e(0, 0) == Approx(p / material.weft_stiffness).epsilon(1e-12));
    if (degrees == 90.0) CHECK(e(1, 1) == Approx(p / material.warp_stiffness).epsilon(1e-12));
  }
}

namespace {

// Jacobian of the co-rotational model (2.36): the linear stiffness A B_i^T C B_k of every triangle,
// rotated by the factor R (3 x 2) of F = R U. A is the area, C the elasticity matrix, and B_i the
// matrix from displacements of corner i to strains.
Eigen::MatrixXd corotational_jacobian(const TriangleMesh& mesh, const MembraneConstants& c,
                                      const Points& x) {
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * x.rows(), 3 * x.rows());
  Mat3 elasticity = Mat3::Zero();
  elasticity << c.a11, c.a12, 0, c.a12, c.a22, 0, 0, 0, c.g;
  const auto corners = rest_corners(mesh, true, "mesh");
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    const Corners2& u = corners[t];
    Mat2 edges;
    edges << (u.row(1) - u.row(0)).transpose(), (u.row(2) - u.row(0)).transpose();
    Eigen::Matrix<double, 3, 2> gradients;  // row i: gradient of shape function i
    gradients.bottomRows<2>() = edges.inverse();
    gradients.row(0) = -gradients.row(1) - gradients.row(2);
    Mat3 corner;  // columns: positions of the corners
    for (int i = 0; i < 3; ++i) corner.col(i) = x.row(mesh.triangles()(t, i)).transpose();
    const Mat32 f = corner * gradients;
    const Mat32 r = test::polar_rotation(f);
    const auto b = [&](int i) {
      Eigen::Matrix<double, 3, 2> rows;
      rows << gradients(i, 0), 0, 0, gradients(i, 1), gradients(i, 1), gradients(i, 0);
      return rows;
    };
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        k.block<3, 3>(3 * mesh.triangles()(t, i), 3 * mesh.triangles()(t, j)) +=
            0.5 * edges.determinant() *
            (r * (b(i).transpose() * elasticity * b(j)) * r.transpose());
  }
  return k;
}

}  // namespace

TEST_CASE(
    "under tension the Jacobian resists motion out of the plane; the co-rotational one does not "
    "(figure 2.3)") {
  Sheet s = make_sheet(orthotropic(), 0.0);
  const MembraneConstants c = membrane_constants(orthotropic(), "m");
  const Index n = s.mesh.n_vertices();
  BlockMatrix rest = pattern(s.mesh), k = pattern(s.mesh);
  s.membrane.set_jacobian({}, s.mesh.vertices(), {JacobianKind::Exact, {1.0, 0.0}}, 0, n, rest);
  const Eigen::MatrixXd at_rest = dense(rest);
  // Both models agree without stress.
  CHECK((corotational_jacobian(s.mesh, c, s.mesh.vertices()) - at_rest).norm() <
        1e-12 * at_rest.norm());
  // The sheet is stretched by a tenth and rotated, so the co-rotational model must follow a
  // rotation.
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  Points x = s.mesh.vertices();
  x.col(0) *= 1.1;
  x = (x * turn.transpose()).eval();
  const Vec3 normal = turn.col(2);
  s.membrane.set_jacobian({}, x, {JacobianKind::Exact, {1.0, 0.0}}, 0, n, k);
  const Eigen::MatrixXd corotational = corotational_jacobian(s.mesh, c, x);
  for (Index i = 0; i < n; ++i) {
    CHECK(normal.dot(k.block_map(k.diagonal()[i]) * normal) > 1.0);
    CHECK((corotational.middleCols<3>(3 * i) * normal).norm() < 1e-12 * corotational.norm());
  }
}

TEST_CASE("any number of threads and any split of the rows give the same bits") {
  const TriangleMesh mesh = jittered_grid(1.0, 1.0, 40, 40, 0.24, 5);
  const auto corners = rest_corners(mesh, true, "mesh");
  const std::vector<MembraneConstants> constants(mesh.n_triangles(),
                                                 membrane_constants(orthotropic(), "m"));
  const Index n = mesh.n_vertices();
  const Points x = mesh.vertices() + random_points(n, 0.005, 12), v = random_points(n, 1.0, 13);
  Membrane one(n, mesh.triangles(), corners, constants);
  Points reference = Points::Zero(n, 3);
  one.add_forces({1}, x, &v, 0, n, reference);
  BlockMatrix k = pattern(mesh);
  one.set_jacobian({1}, x, {JacobianKind::Positive, {1e-4, 1e-2}}, 0, n, k);
  const double energy = one.energy({1}, x);
  for (const int threads : {2, 3, 7}) {
    Membrane other(n, mesh.triangles(), corners, constants);
    Points f = Points::Zero(n, 3);
    BlockMatrix a = pattern(mesh);
    for (const Index cut : {0, 384, 1024}) {
      const Index end = cut == 0 ? 384 : cut == 384 ? 1024 : n;
      other.add_forces({threads}, x, &v, cut, end, f);
      other.set_jacobian({threads}, x, {JacobianKind::Positive, {1e-4, 1e-2}}, cut, end, a);
    }
    CHECK(f == reference);
    CHECK(dense(a) == dense(k));
    CHECK(other.energy({threads}, x) == energy);
  }
}

TEST_CASE("materials without positive energy are refused with the reason") {
  ClothMaterial m;
  m.poisson = 0.9, m.weft_stiffness = 100, m.warp_stiffness = 300;
  CHECK_THROWS_WITH(
      membrane_constants(m, "cloths[0].material"),
      Catch::Contains("cloths[0].material.poisson") && Catch::Contains("positive definite"));
  m = ClothMaterial{};
  m.viscosity_dilation = -1.0;
  CHECK_THROWS_AS(membrane_constants(m, "m"), InvalidInput);
}
