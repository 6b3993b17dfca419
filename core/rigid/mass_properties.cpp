// Volume, mass, centre and inertia of a closed mesh of uniform density. Computes the volume
// integrals of [Mirtich1996] as sums over signed tetrahedra. Each triangle spans a tetrahedron with
// a reference point, and the parts outside the body cancel.
#include "core/base/message.h"
#include "core/rigid/rigid_body.h"

namespace loomstone {

MassProperties mass_properties(const TriangleMesh& mesh, double density) {
  if (!mesh.closed()) {
    fail<InvalidInput>(
        "mesh must be closed to have a mass, got a surface with open edges; close its holes");
  }
  const Points& x = mesh.vertices();
  // Any reference point gives the same result. The mean of the vertices keeps the cancelling terms
  // small.
  const Vec3 reference = x.colwise().mean().transpose();
  const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();

  double volume = 0.0;
  Vec3 first = Vec3::Zero();   // integral of x - reference [m^4]
  Mat3 second = Mat3::Zero();  // integral of (x - reference) (x - reference)^T [m^5]
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    Mat3 corners;  // columns: corners of triangle t relative to `reference` [m]
    for (int k = 0; k < 3; ++k)
      corners.col(k) = x.row(mesh.triangles()(t, k)).transpose() - reference;
    const Vec3 sum = corners.rowwise().sum();
    const double tetrahedron = corners.col(0).cross(corners.col(1)).dot(corners.col(2)) / 6.0;
    volume += tetrahedron;
    first += tetrahedron / 4.0 * sum;
    second += tetrahedron / 20.0 * (corners * corners.transpose() + sum * sum.transpose());
  }
  // As a fraction of the cubed diagonal of the bounding box, 1e-12 is far below the volume of thin
  // sheets (about 4e-5 for a square with a thickness of 1e-4 of its side) and far above rounding
  // errors (1e-16).
  const double smallest = 1e-12 * size * size * size;
  if (volume < -smallest) {
    fail<InvalidInput>(
        "mesh must have its faces counter-clockwise seen from outside, got an inside-out surface "
        "of volume {:.6g} m^3; swap two corners of every triangle",
        volume);
  }
  if (volume < smallest) {
    fail<InvalidInput>(
        "mesh must enclose a volume > 0 [m^3], got a surface that encloses none; give the body a "
        "thickness");
  }

  MassProperties result;
  const Vec3 offset = first / volume;
  result.volume = volume;
  result.mass = density * volume;
  result.centre = reference + offset;
  second -= volume * offset * offset.transpose();  // parallel axis theorem
  result.inertia = density * (second.trace() * Mat3::Identity() - second);
  return result;
}

MassProperties mass_properties(const RigidBody& body) {
  if (!body.mesh) throw InvalidInput("mesh must be a closed mesh, got none; give one");
  MassProperties result = mass_properties(*body.mesh, body.density);
  if (body.mass == 0.0) return result;
  result.inertia *= body.mass / result.mass;
  result.mass = body.mass;
  return result;
}

}  // namespace loomstone
