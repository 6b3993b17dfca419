#include "core/cloth/bending/midedge_setup.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace loomstone::midedge {

namespace {

using Row3 = Eigen::RowVector3d;  // linear form on the curvature (kxx, kyy, 2 kxy)

// A triangle at rest. Edge i lies opposite corner i and runs from corner i + 1 to corner i + 2,
// modulo 3. The angle at an edge is measured from the triangle to the tangent plane of the surface
// at the midpoint of the edge.
struct RestTriangle {
  double area;
  std::array<double, 3> direction;  // angle of edge i from weft [rad]
  std::array<Vec3, 3> curvature;    // N_i: curvature per unit angle at edge i [1/m]
  std::array<Row3, 3> angle;        // psi_i: angle at edge i per unit curvature [m]
};

RestTriangle rest_triangle(const Corners2& corners) {
  RestTriangle r;
  const Vec2 x[3] = {corners.row(0).transpose(), corners.row(1).transpose(),
                     corners.row(2).transpose()};
  const Vec2 e1 = x[1] - x[0], e2 = x[2] - x[0];
  r.area = 0.5 * (e1.x() * e2.y() - e1.y() * e2.x());
  for (int i = 0; i < 3; ++i) {
    const Vec2 p = x[(i + 1) % 3], q = x[(i + 2) % 3];
    const double l = (q - p).norm(), h = 2.0 * r.area / l;
    const Vec2 t = (q - p) / l, n(t.y(), -t.x());
    // psi_i maps a curvature to the angle (h / 2) k_nn - a k_nt + b k_tt, where k_nn, k_nt and k_tt
    // are the components of the curvature along the normal n and the tangent t of the edge. h is
    // the height of the triangle over the edge, `a` is the position of corner i along t, relative
    // to the midpoint of the edge, and b is (a^2 - l^2 / 4) / (2 h) with the length l of the edge.
    const double a = (x[i] - 0.5 * (p + q)).dot(t), b = (a * a - 0.25 * l * l) / (2.0 * h);
    const auto form = [](const Vec2& u, const Vec2& v) {
      return Row3(u.x() * v.x(), u.y() * v.y(), 0.5 * (u.x() * v.y() + u.y() * v.x()));
    };
    r.direction[i] = std::atan2(t.y(), t.x());
    r.curvature[i] = l / r.area * Vec3(n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y());
    r.angle[i] = 0.5 * h * form(n, n) - a * form(n, t) + b * form(t, t);
  }
  return r;
}

// Matrix that transforms a curvature (kxx, kyy, 2 kxy) to axes that are rotated by alpha [rad].
Mat3 turn(double alpha) {
  const double c = std::cos(alpha), s = std::sin(alpha);
  Mat3 r;
  r << c * c, s * s, c * s, s * s, c * c, -c * s, -2.0 * c * s, 2.0 * c * s, c * c - s * s;
  return r;
}

// Null space and pseudo-inverse of a positive semi-definite matrix. Eigenvalues up to `threshold`
// times the largest eigenvalue count as zero. For a matrix S S^T, this means that singular values
// of S up to sqrt(threshold) times the largest one count as zero.
struct Split {
  Mat3 vectors;
  Vec3 values;
  double least;

  Split(const Mat3& matrix, double threshold) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(matrix);
    vectors = solver.eigenvectors(), values = solver.eigenvalues();
    least = threshold * values[2];
  }
  // Projector onto the null space.
  Mat3 null_space() const {
    return part([](double) { return 1.0; }, false);
  }
  Mat3 pseudo_inverse() const {
    return part([](double v) { return 1.0 / v; }, true);
  }

 private:
  template <class Factor>
  Mat3 part(Factor&& factor, bool counting) const {
    Mat3 sum = Mat3::Zero();
    for (int i = 0; i < 3; ++i)
      if ((values[i] > least) == counting)
        sum += factor(values[i]) * vectors.col(i) * vectors.col(i).transpose();
    return sum;
  }
};

class Builder {
 public:
  Builder(const BendingSetup& setup, const EdgeTable& edges, const std::vector<Hinge>& hinges)
      : setup_(setup), edges_(edges), hinges_(hinges), hinge_of_edge_(edges.edges.rows(), -1) {
    for (Index e = 0; e < static_cast<Index>(hinges.size()); ++e)
      hinge_of_edge_[hinges[e].edge] = e;
    for (Index t = 0; t < setup.triangles.rows(); ++t)
      rest_.push_back(rest_triangle(setup.corners[t]));
  }

  // Slope of the surface at a hinge. Relative to the first triangle of the hinge, the slope is half
  // the hinge angle plus the weighted sum of the angles of `hinges`. Relative to the second
  // triangle, it is half the hinge angle minus that sum.
  struct Slope {
    std::vector<Index> hinges;
    std::vector<double> weights;
    bool averaged = false;
  };

  Slope slope(Index e) const;
  Element element(Index triangle, const std::vector<Slope>& slopes) const;

 private:
  int local_edge(Index triangle, Index edge) const {
    for (int i = 0; i < 2; ++i)
      if (edges_.of_triangle[triangle][i] == edge) return i;
    return 2;
  }
  bool prescribed(Index triangle) const {
    for (int i = 0; i < 3; ++i)
      if (!setup_.prescribed[setup_.triangles(triangle, i)]) return false;
    return true;
  }
  // Returns the matrix that transforms a curvature from the axes of `from` to the axes of `to`
  // across their common edge.
  Mat3 across(Index from, Index to, Index edge) const {
    // `to` traverses the edge in the opposite direction, but a rotation by 180 degrees leaves a
    // curvature unchanged.
    return turn(rest_[from].direction[local_edge(from, edge)] -
                rest_[to].direction[local_edge(to, edge)]);
  }
  // Returns the row whose product with a constant curvature of both triangles of hinge r is the
  // angle of this hinge. The curvature is given in the axes of `triangle`, one of the two
  // triangles.
  Row3 hinge_angle(Index r, Index triangle) const {
    const Hinge& h = hinges_[r];
    const Index other = h.triangles[0] == triangle ? h.triangles[1] : h.triangles[0];
    return rest_[triangle].angle[local_edge(triangle, h.edge)] +
           rest_[other].angle[local_edge(other, h.edge)] * across(triangle, other, h.edge);
  }

  const BendingSetup& setup_;
  const EdgeTable& edges_;
  const std::vector<Hinge>& hinges_;
  std::vector<Index> hinge_of_edge_;
  std::vector<RestTriangle> rest_;
};

Builder::Slope Builder::slope(Index e) const {
  const Hinge& h = hinges_[e];
  const Index first = h.triangles[0], second = h.triangles[1];
  const bool first_prescribed = prescribed(first), second_prescribed = prescribed(second);
  // If all vertices of a triangle are prescribed, its orientation is given. The slope at its edges
  // is that of the triangle, so the cloth beyond these edges is clamped. Between two such
  // triangles, the slope is the mean of their slopes.
  if (first_prescribed && second_prescribed) return {{e}, {0.0}};
  if (first_prescribed || second_prescribed) return {{e}, {first_prescribed ? -0.5 : 0.5}};

  const Mat3 to_second = across(first, second, h.edge);
  std::vector<Index> near;
  std::vector<Row3> angles;  // angles of the hinges in `near`
  // Unit rows for the boundary edges of both triangles of the hinge. The product of a row and a
  // curvature is the moment across the edge, up to a factor. These moments must vanish. Edges
  // across which no curvature causes a moment have no row.
  std::vector<Row3> free;
  for (const Index triangle : {first, second}) {
    const Mat3 axes = triangle == first ? Mat3(Mat3::Identity()) : to_second;
    for (int i = 0; i < 3; ++i) {
      const Index r = hinge_of_edge_[edges_.of_triangle[triangle][i]];
      if (r < 0) {
        const Row3 moment =
            rest_[triangle].curvature[i].transpose() * setup_.rigidity[triangle] * axes;
        const double size = moment.norm();
        if (size > 0.0) free.push_back(moment / size);
      } else if (std::find(near.begin(), near.end(), r) == near.end()) {
        near.push_back(r);
        angles.push_back(hinge_angle(r, triangle) * axes);
      }
    }
  }
  // Only curvatures without moments across boundary edges have to be reproduced. `kept` is the
  // projector onto these curvatures.
  Mat3 moments = Mat3::Zero();
  for (const Row3& row : free) moments += row.transpose() * row;
  const Mat3 kept = Split(moments, 1e-13).null_space();
  const Row3 wanted = 0.5 * (rest_[first].angle[local_edge(first, h.edge)] -
                             rest_[second].angle[local_edge(second, h.edge)] * to_second);
  // Computes the weights p of least norm such that sum_k p_k angles_k agrees with `wanted` for all
  // curvatures in the range of `kept`.
  Mat3 gram = Mat3::Zero();
  for (const Row3& angle : angles) gram += (angle * kept).transpose() * (angle * kept);
  const Vec3 dual = Split(gram, 1e-12).pseudo_inverse() * (wanted * kept).transpose();
  Slope result{near, std::vector<double>(near.size(), 0.0)};
  for (std::size_t k = 0; k < near.size(); ++k) result.weights[k] = angles[k] * kept * dual;
  // Weights of magnitude above 1, for example at slivers, would raise the highest frequency of
  // bending. An edge with such a weight uses the mean slope instead.
  result.averaged = !std::all_of(result.weights.begin(), result.weights.end(),
                                 [](double w) { return std::abs(w) <= 1.0; });
  if (result.averaged) std::fill(result.weights.begin(), result.weights.end(), 0.0);
  return result;
}

Element Builder::element(Index triangle, const std::vector<Slope>& slopes) const {
  Element out;
  const auto add = [&](Index hinge, const Vec3& curvature) {
    const auto found = std::find(out.hinge.begin(), out.hinge.begin() + out.n_hinges, hinge);
    const int s = static_cast<int>(found - out.hinge.begin());
    if (s == out.n_hinges) out.hinge[out.n_hinges++] = hinge, out.curvature[s].setZero();
    out.curvature[s] += curvature;
  };
  Mat32 boundary = Mat32::Zero();
  int n_boundary = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3& n = rest_[triangle].curvature[i];
    const Index e = hinge_of_edge_[edges_.of_triangle[triangle][i]];
    if (e < 0) {
      if (n_boundary < 2) boundary.col(n_boundary) = n;
      ++n_boundary;
      continue;
    }
    const double sign = hinges_[e].triangles[0] == triangle ? 1.0 : -1.0;
    add(e, 0.5 * n);
    for (std::size_t k = 0; k < slopes[e].hinges.size(); ++k)
      if (slopes[e].weights[k] != 0.0) add(slopes[e].hinges[k], sign * slopes[e].weights[k] * n);
  }
  // The slope at a boundary edge is chosen so that the moment across the edge vanishes (static
  // condensation).
  const Mat3& d = setup_.rigidity[triangle];
  Mat3 condensed = d;
  if (n_boundary == 3) {
    condensed.setZero();
  } else if (n_boundary > 0) {
    Mat3 inner = Mat3::Zero();
    inner.topLeftCorner<2, 2>() = boundary.transpose() * d * boundary;
    const Mat2 inverse = Split(inner, 1e-15).pseudo_inverse().topLeftCorner<2, 2>();
    condensed -= d * boundary * inverse * boundary.transpose() * d;
  }
  out.rigidity = 0.5 * rest_[triangle].area * (condensed + condensed.transpose());
  return out;
}

}  // namespace

Elements make_elements(const BendingSetup& setup, const EdgeTable& edges,
                       const std::vector<Hinge>& hinges) {
  const Builder builder(setup, edges, hinges);
  std::vector<Builder::Slope> slopes;
  Elements out;
  for (Index e = 0; e < static_cast<Index>(hinges.size()); ++e) {
    slopes.push_back(builder.slope(e));
    out.n_averaged += slopes.back().averaged;
  }
  for (Index t = 0; t < setup.triangles.rows(); ++t)
    out.elements.push_back(setup.acts_on(t) ? builder.element(t, slopes) : Element{});
  return out;
}

}  // namespace loomstone::midedge
