#include "core/magnetics/sources/polyhedron.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/message.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/flat_face.h"
#include "core/magnetics/sources/gauss.h"
#include "core/magnetics/sources/split_block.h"

namespace loomstone {

namespace {

constexpr int doubles_per_face = 16, doubles_per_edge = 14;

// Kernel data of a Polyhedron.
struct SurfaceTables {
  const double* faces;
  Index n_faces;
  const double* edges;
  Index n_edges;
  double radius;  // radius of the body [m]
};

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(SurfaceTables surface, const double* j, const double* points,
                                   Index n, double* out) {
  const auto [faces, n_faces, edges, n_edges, radius] = surface;
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> h{};
    Lanes around{};
    for (Index k = 0; k < n_faces; ++k) {
      const double* f = faces + doubles_per_face * k;
      const Lanes omega = solid_angle(p, f, on_face * radius);
      around += omega;
      h.x += f[13] * f[9] * omega;
      h.y += f[13] * f[10] * omega;
      h.z += f[13] * f[11] * omega;
    }
    for (Index k = 0; k < n_edges; ++k) {
      const double* e = edges + doubles_per_edge * k;
      const EdgeTerms<Lanes> t = edge_terms(p, e, on_edge * radius);
      const Lanes log = lanes_log(t.sum / t.defect);
      h.x += e[7] * log;
      h.y += e[8] * log;
      h.z += e[9] * log;
    }
    // The solid angles of all faces sum to -4 pi inside and to 0 outside. j is added inside: it is
    // the polarization for B, and 0 for mu0 H.
    const MaskOf<Lanes> inside = around < -2.0 * pi;
    lanes_store(out + i, h.x + lanes_select(inside, lanes_all<Lanes>(j[0]), Lanes{}));
    lanes_store(out + n + i, h.y + lanes_select(inside, lanes_all<Lanes>(j[1]), Lanes{}));
    lanes_store(out + 2 * n + i, h.z + lanes_select(inside, lanes_all<Lanes>(j[2]), Lanes{}));
  }
}

// Computes gradients from the edges alone. polyhedron.h defines Omega and L. The gradient of Omega
// is proportional to the field of a current along the boundary of the face. The gradient of L is an
// algebraic function; see edge_gradients().
template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(const double* edges, Index n_edges, double radius,
                                      const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes g[6];
    for (Lanes& s : g) s = Lanes{};
    for (Index k = 0; k < n_edges; ++k) {
      const double* e = edges + doubles_per_edge * k;
      add_edge_gradients(edge_gradients(edge_terms(p, e, on_edge * radius), e), e + 7, e + 10, g);
    }
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, g[c]);
  }
}

// Computes the potential by its closed form at any distance. Far away, the absolute rounding error
// grows in proportion to the distance, while the potential falls with the square of the distance.
template <class Lanes>
LOOMSTONE_INLINE void potential_kernel(SurfaceTables surface, const double* points, Index n,
                                       double* out) {
  const auto [faces, n_faces, edges, n_edges, radius] = surface;
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes sum{};
    for (Index k = 0; k < n_faces; ++k) {
      const double* f = faces + doubles_per_face * k;
      const Lanes height = f[9] * (p.x - f[0]) + f[10] * (p.y - f[1]) + f[11] * (p.z - f[2]);
      sum -= f[13] * height * solid_angle(p, f, on_face * radius);
    }
    for (Index k = 0; k < n_edges; ++k) {
      const double* e = edges + doubles_per_edge * k;
      const EdgeTerms<Lanes> t = edge_terms(p, e, on_edge * radius);
      sum -= (e[7] * t.r0.x + e[8] * t.r0.y + e[9] * t.r0.z) * lanes_log(t.sum / t.defect);
    }
    lanes_store(out + i, sum);
  }
}

Points box_corners(const Vec3& size) {
  Points corners(8, 3);
  for (int k = 0; k < 8; ++k)
    corners.row(k) << 0.5 * size.x() * (k & 1 ? 1 : -1), 0.5 * size.y() * (k & 2 ? 1 : -1),
        0.5 * size.z() * (k & 4 ? 1 : -1);
  return corners;
}

Triangles box_triangles() {
  Triangles faces(12, 3);
  faces << 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1,
      4, 5, 7, 4, 7, 6;
  return faces;
}

}  // namespace

Polyhedron::Polyhedron(Points vertices, Triangles triangles, const Vec3& polarization)
    : vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      polarization_(polarization) {
  if (!polarization.allFinite())
    throw InvalidInput("polarization must be finite [T], got a component that is not");
  radius_ = vertices_.rowwise().norm().maxCoeff();
  struct Sides {
    Vec3 in_plane = Vec3::Zero(), normal = Vec3::Zero();
  };
  std::map<std::pair<Index, Index>, Sides> sides;
  faces_.resize(doubles_per_face * triangles_.rows());
  for (Index t = 0; t < triangles_.rows(); ++t) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = vertices_.row(triangles_(t, k)).transpose();
    const Vec3 area = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    const Vec3 normal = area.normalized();
    const double charge = polarization.dot(normal) / (4.0 * pi);
    volume_ += corner[0].dot(area) / 6.0;
    double* f = faces_.data() + doubles_per_face * t;
    for (int k = 0; k < 3; ++k) Eigen::Map<Vec3>(f + 3 * k) = corner[k];
    Eigen::Map<Vec3>(f + 9) = normal;
    f[12] = area.norm();
    f[13] = charge;
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles_(t, k), b = triangles_(t, (k + 1) % 3);
      Sides& s = sides[{std::min(a, b), std::max(a, b)}];
      s.in_plane += charge * (corner[(k + 1) % 3] - corner[k]).normalized().cross(normal);
      s.normal += (a < b ? charge : -charge) * normal;
    }
  }
  const double negligible = 1e-15 * polarization.norm();
  for (const auto& [ends, s] : sides) {
    if (s.in_plane.norm() <= negligible && s.normal.norm() <= negligible) continue;
    const Vec3 a = vertices_.row(ends.first).transpose(),
               b = vertices_.row(ends.second).transpose();
    edges_.insert(edges_.end(), {a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), (b - a).norm()});
    for (const Vec3& v : {s.in_plane, s.normal})
      edges_.insert(edges_.end(), v.data(), v.data() + 3);
    edges_.push_back(0.0);
  }
}

Vec3 Polyhedron::moment() const { return polarization_ * volume_ / mu0; }

const MultipoleExpansion& Polyhedron::multipoles() const {
  std::call_once(once_, [&] {
    std::vector<Vec3> positions;
    std::vector<double> charges;
    for (Index t = 0; t < triangles_.rows(); ++t) {
      const Vec3 a = vertices_.row(triangles_(t, 0)).transpose(),
                 ab = vertices_.row(triangles_(t, 1)).transpose() - a,
                 bc = vertices_.row(triangles_(t, 2)).transpose() - a - ab;
      const double flux = ab.cross(bc).dot(polarization_),
                   share = std::max(ab.norm(), bc.norm()) / radius_;
      // The number of points in each direction depends on the size of the face. On large faces, the
      // rule is exact up to degree 24, the highest of the expansion. Small faces need fewer points,
      // because harmonics vary less on them.
      const GaussRule& rule = gauss_rule(share > 0.4 ? 14 : share > 0.1 ? 8 : 5);
      for (int i = 0; i < rule.n; ++i) {
        const double u = 0.5 * (1.0 + rule.nodes[i]);
        for (int k = 0; k < rule.n; ++k) {
          const double v = 0.5 * (1.0 + rule.nodes[k]);
          positions.push_back(a + u * ab + u * v * bc);
          charges.push_back(0.25 * rule.weights[i] * rule.weights[k] * u * flux);
        }
      }
    }
    Points x(positions.size(), 3);
    for (std::size_t i = 0; i < positions.size(); ++i) x.row(i) = positions[i].transpose();
    far_.emplace(x, Eigen::Map<const Vector>(charges.data(), charges.size()), radius_);
  });
  return *far_;
}

void Polyhedron::near_field(const double* points, Index n, Quantity quantity, double* field) const {
  const Vec3 j = quantity == Quantity::flux_density ? polarization_ : Vec3(Vec3::Zero());
  const SurfaceTables surface{faces_.data(), static_cast<Index>(triangles_.rows()), edges_.data(),
                              static_cast<Index>(edges_.size() / doubles_per_edge), radius_};
  LOOMSTONE_WIDEST(field_kernel)(surface, j.data(), points, n, field);
}

void Polyhedron::field_block(const double* points, Index n, Quantity quantity,
                             double* field) const {
  const double bound = MultipoleExpansion::near * MultipoleExpansion::near * radius_ * radius_;
  split_block(
      {points, n, field, 3},
      [&](double x, double y, double z) { return x * x + y * y + z * z < bound; },
      [&](const double* some, Index m, double* out) { near_field(some, m, quantity, out); },
      [&](const double* some, Index m, double* out) { multipoles().field_block(some, m, out); });
}

void Polyhedron::gradient_block(const double* points, Index n, double* gradient) const {
  const double bound = MultipoleExpansion::near * MultipoleExpansion::near * radius_ * radius_;
  split_block(
      {points, n, gradient, 6},
      [&](double x, double y, double z) { return x * x + y * y + z * z < bound; },
      [&](const double* some, Index m, double* out) {
        LOOMSTONE_WIDEST(gradient_kernel)(edges_.data(),
                                          static_cast<Index>(edges_.size() / doubles_per_edge),
                                          radius_, some, m, out);
      },
      [&](const double* some, Index m, double* out) { multipoles().gradient_block(some, m, out); });
}

void Polyhedron::potential_block(const double* points, Index n, double* potential) const {
  const SurfaceTables surface{faces_.data(), static_cast<Index>(triangles_.rows()), edges_.data(),
                              static_cast<Index>(edges_.size() / doubles_per_edge), radius_};
  LOOMSTONE_WIDEST(potential_kernel)(surface, points, n, potential);
}

MeshMagnet::MeshMagnet(const TriangleMesh& mesh, const Vec3& polarization)
    : Polyhedron(mesh.vertices(), mesh.triangles(), polarization) {
  if (!mesh.closed())
    throw InvalidInput(
        "mesh must be closed to be a magnet, got a surface with open edges; close its holes");
  // 1e-12 of the cubed radius is far below the volume of any practical sheet and far above rounding
  // errors.
  if (volume() < 1e-12 * std::pow(radius(), 3))
    fail<InvalidInput>(
        "mesh must enclose a volume > 0 [m^3] with faces counter-clockwise seen from outside, got "
        "{}; turn its faces or give it a thickness",
        volume());
}

Cuboid::Cuboid(const Vec3& size, const Vec3& polarization)
    : Polyhedron(box_corners(size), box_triangles(), polarization), size_(size) {
  if (!(size.minCoeff() > 0.0) || !size.allFinite())
    fail<InvalidInput>("size must be three lengths > 0 [m], got ({}, {}, {})", size.x(), size.y(),
                       size.z());
}

std::optional<std::pair<Vec3, Vec3>> Polyhedron::box() const {
  return std::pair(Vec3(vertices_.colwise().minCoeff().transpose()),
                   Vec3(vertices_.colwise().maxCoeff().transpose()));
}

double Polyhedron::depth(const Vec3& point) const {
  std::call_once(query_once_, [&] { query_.emplace(vertices_, triangles_); });
  const double distance = query_->closest(point, point.norm() + 2.0 * radius_).distance;
  return query_->inside(point) ? distance : -distance;
}

double Cuboid::depth(const Vec3& point) const {
  const Vec3 inner = 0.5 * size_ - point.cwiseAbs();
  return inner.minCoeff() >= 0.0 ? inner.minCoeff() : -inner.cwiseMin(0.0).norm();
}

std::vector<Panel> Polyhedron::faces(bool all) const {
  std::vector<Panel> panels;
  for (Index t = 0; t < triangles_.rows(); ++t) {
    Panel p{Panel::Shape::triangle};
    p.a = vertices_.row(triangles_(t, 0)).transpose();
    p.b = vertices_.row(triangles_(t, 1)).transpose() - p.a;
    p.c = vertices_.row(triangles_(t, 2)).transpose() - p.a;
    p.magnetization = polarization_ / mu0;
    if (all || p.b.cross(p.c).dot(polarization_) != 0.0) panels.push_back(p);
  }
  return panels;
}

std::vector<Panel> Cuboid::faces(bool all) const {
  std::vector<Panel> panels;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = -1; side <= 1; side += 2) {
      if (!all && polarization()[axis] == 0.0) continue;
      const int first = (axis + (side > 0 ? 1 : 2)) % 3, second = (axis + (side > 0 ? 2 : 1)) % 3;
      Panel p{Panel::Shape::parallelogram};
      p.b[first] = size_[first];
      p.c[second] = size_[second];
      p.a = -0.5 * (p.b + p.c);
      p.a[axis] = 0.5 * side * size_[axis];
      p.magnetization = polarization() / mu0;
      panels.push_back(p);
    }
  }
  return panels;
}

}  // namespace loomstone
