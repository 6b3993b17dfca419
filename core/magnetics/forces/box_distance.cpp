// Distance between two oriented boxes by the algorithm of Gilbert, Johnson and Keerthi [GJK88]. All
// faces of a simplex, which include its corners, its edges and the simplex itself, are tested to
// find the point of the simplex nearest to the origin.
#include <algorithm>
#include <array>
#include <limits>

#include "core/magnetics/forces/cells.h"

namespace loomstone {

namespace {

struct Simplex {
  std::array<Vec3, 4> points{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int n = 0;
};

// Reduces the simplex to the face that contains its point nearest to the origin, and returns that
// point.
Vec3 nearest(Simplex& simplex) {
  Vec3 best = Vec3::Zero();
  double least = std::numeric_limits<double>::infinity();
  Simplex kept;
  for (int mask = 1; mask < 1 << simplex.n; ++mask) {
    Simplex face;
    for (int i = 0; i < simplex.n; ++i)
      if (mask & 1 << i) face.points[face.n++] = simplex.points[i];
    // Finds the point nearest to the origin in the affine hull of the face's points. `weights` are
    // the barycentric weights of all points but the first.
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> edges(3, face.n - 1);
    for (int i = 1; i < face.n; ++i) edges.col(i - 1) = face.points[i] - face.points[0];
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> weights(face.n - 1);
    if (face.n > 1)
      weights = (edges.transpose() * edges).ldlt().solve(-edges.transpose() * face.points[0]);
    if (face.n > 1 && (!weights.allFinite() || weights.minCoeff() < 0.0 || weights.sum() > 1.0))
      continue;
    const Vec3 point = face.n > 1 ? Vec3(face.points[0] + edges * weights) : face.points[0];
    if (point.squaredNorm() < least) {
      least = point.squaredNorm();
      best = point;
      kept = face;
    }
  }
  simplex = kept;
  return best;
}

}  // namespace

double box_distance(const Vec3& low, const Vec3& high, const Vec3& other_low,
                    const Vec3& other_high, const RigidPose& pose) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  // Returns the support point of the Minkowski difference of the boxes along -direction.
  const auto support = [&](const Vec3& direction) {
    const Vec3 turned = rotation.transpose() * direction;
    Vec3 a, b;
    for (int k = 0; k < 3; ++k) {
      a[k] = direction[k] < 0.0 ? high[k] : low[k];
      b[k] = turned[k] < 0.0 ? other_low[k] : other_high[k];
    }
    return Vec3(a - (pose.position + rotation * b));
  };
  Simplex simplex;
  Vec3 point =
      support(0.5 * (low + high) - pose.position - rotation * (0.5 * (other_low + other_high)));
  simplex.points[simplex.n++] = point;
  for (int iteration = 0; iteration < 64; ++iteration) {
    const double square = point.squaredNorm();
    const Vec3 next = support(point);
    // point . next / |point| is a lower bound of the distance. A relative tolerance of 1e-6
    // suffices for the callers.
    if (square - point.dot(next) <= 1e-6 * square || simplex.n == 4) break;
    simplex.points[simplex.n++] = next;
    const Vec3 better = nearest(simplex);
    if (better.squaredNorm() >= square) break;
    point = better;
    if (simplex.n == 4) return 0.0;  // the boxes overlap
  }
  return point.norm();
}

}  // namespace loomstone
