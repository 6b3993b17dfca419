#include "core/magnetics/polyhedron.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/base/error.h"
#include "core/magnetics/constants.h"
#include "core/magnetics/gauss.h"
#include "core/magnetics/lane_math.h"
#include "core/magnetics/split_block.h"

namespace loomstone {

namespace {

constexpr int face_stride = 16, edge_stride = 14;
constexpr double on_face = 1e-12, on_edge = 1e-15;  // in units of the radius

// What a straight edge gives: the logarithm's argument as a fraction, without cancellation on or beside its line.
struct EdgeTerms {
  Lanes3 r0, r1;      // from the ends to the point
  Lanes d0, d1;       // their lengths
  Lanes sum, defect;  // d0 + d1 + l and d0 + d1 - l
};

LOOMSTONE_INLINE EdgeTerms edge_terms(const Lanes3& p, const double* e, double nearest) {
  EdgeTerms t;
  t.r0 = {p.x - e[0], p.y - e[1], p.z - e[2]};
  t.r1 = {p.x - e[3], p.y - e[4], p.z - e[5]};
  const double l = e[6], ux = (e[3] - e[0]) / l, uy = (e[4] - e[1]) / l, uz = (e[5] - e[2]) / l;
  // Coordinates along the edge from its ends, and the distance to its line from the nearer end.
  const Lanes t0 = ux * t.r0.x + uy * t.r0.y + uz * t.r0.z;
  const Lanes t1 = ux * t.r1.x + uy * t.r1.y + uz * t.r1.z;
  const LaneMask first = lanes_abs(t0) < lanes_abs(t1);
  const Lanes3 r = {lanes_select(first, t.r0.x, t.r1.x), lanes_select(first, t.r0.y, t.r1.y),
                    lanes_select(first, t.r0.z, t.r1.z)};
  const Lanes3 c = {uy * r.z - uz * r.y, uz * r.x - ux * r.z, ux * r.y - uy * r.x};
  const Lanes square = lanes_max(dot(c, c), lanes_all(nearest * nearest));
  t.d0 = lanes_sqrt(t0 * t0 + square);
  t.d1 = lanes_sqrt(t1 * t1 + square);
  const Lanes beyond = lanes_select(t0 * t1 > 0.0, lanes_min(lanes_abs(t0), lanes_abs(t1)), lanes_all(0.0));
  t.sum = t.d0 + t.d1 + l;
  t.defect = square * (1.0 / (t.d0 + lanes_abs(t0)) + 1.0 / (t.d1 + lanes_abs(t1))) + 2.0 * beyond;
  return t;
}

// Solid angle of a triangle [VanOosteromStrackee1983], positive on the side of its normal.
LOOMSTONE_INLINE Lanes solid_angle(const Lanes3& p, const double* f, double nearest) {
  const Lanes3 a = {p.x - f[0], p.y - f[1], p.z - f[2]}, b = {p.x - f[3], p.y - f[4], p.z - f[5]},
               c = {p.x - f[6], p.y - f[7], p.z - f[8]};
  const Lanes da = norm(a), db = norm(b), dc = norm(c);
  // The height from the nearest corner loses least.
  Lanes height = f[9] * a.x + f[10] * a.y + f[11] * a.z;
  const Lanes from_b = f[9] * b.x + f[10] * b.y + f[11] * b.z, from_c = f[9] * c.x + f[10] * c.y + f[11] * c.z;
  const LaneMask b_near = (db < da) & (db < dc), c_near = (dc < da) & (dc <= db);
  height = lanes_select(b_near, from_b, lanes_select(c_near, from_c, height));
  height = lanes_select(lanes_abs(height) < nearest, lanes_all(nearest), height);
  const Lanes below = da * db * dc + dot(a, b) * dc + dot(a, c) * db + dot(b, c) * da;
  return 2.0 * lanes_atan2(height * f[12], below);
}

LOOMSTONE_CLONES void field_kernel(const double* faces, Index n_faces, const double* edges, Index n_edges,
                                   double radius, const double* j, const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3 p{lanes_load(points + i), lanes_load(points + n + i), lanes_load(points + 2 * n + i)};
    Lanes3 h{lanes_all(0.0), lanes_all(0.0), lanes_all(0.0)};
    Lanes around = lanes_all(0.0);
    for (Index k = 0; k < n_faces; ++k) {
      const double* f = faces + face_stride * k;
      const Lanes omega = solid_angle(p, f, on_face * radius);
      around += omega;
      h.x += f[13] * f[9] * omega;
      h.y += f[13] * f[10] * omega;
      h.z += f[13] * f[11] * omega;
    }
    for (Index k = 0; k < n_edges; ++k) {
      const double* e = edges + edge_stride * k;
      const EdgeTerms t = edge_terms(p, e, on_edge * radius);
      const Lanes log = lanes_log(t.sum / t.defect);
      h.x += e[7] * log;
      h.y += e[8] * log;
      h.z += e[9] * log;
    }
    // Inside, all faces are seen from behind: -4 pi in all. j is zero where mu0 H is wanted.
    const LaneMask inside = around < -2.0 * pi;
    lanes_store(out + i, h.x + lanes_select(inside, lanes_all(j[0]), lanes_all(0.0)));
    lanes_store(out + n + i, h.y + lanes_select(inside, lanes_all(j[1]), lanes_all(0.0)));
    lanes_store(out + 2 * n + i, h.z + lanes_select(inside, lanes_all(j[2]), lanes_all(0.0)));
  }
}

// Derivatives need edges only: d Omega is the field of a unit current along the face's rim, dL is rational.
LOOMSTONE_CLONES void gradient_kernel(const double* edges, Index n_edges, double radius, const double* points, Index n,
                                      double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3 p{lanes_load(points + i), lanes_load(points + n + i), lanes_load(points + 2 * n + i)};
    Lanes g[6];
    for (Lanes& s : g) s = lanes_all(0.0);
    for (Index k = 0; k < n_edges; ++k) {
      const double* e = edges + edge_stride * k;
      const EdgeTerms t = edge_terms(p, e, on_edge * radius);
      const double l = e[6], lx = e[3] - e[0], ly = e[4] - e[1], lz = e[5] - e[2];
      const Lanes i0 = 1.0 / t.d0, i1 = 1.0 / t.d1;
      const Lanes outer = 1.0 / (t.sum * t.defect);  // 1 / ((d0 + d1)^2 - l^2)
      // dL = -2 l (r0/d0 + r1/d1) / ((d0+d1)^2 - l^2);  dOmega = -(l x r0) * 2 (1/d0 + 1/d1) / ((d0+d1)^2 - l^2)
      const Lanes a = -2.0 * l * outer;
      const Lanes dx = a * (t.r0.x * i0 + t.r1.x * i1), dy = a * (t.r0.y * i0 + t.r1.y * i1),
                  dz = a * (t.r0.z * i0 + t.r1.z * i1);
      const Lanes b = -2.0 * (i0 + i1) * outer;
      const Lanes wx = b * (ly * t.r0.z - lz * t.r0.y), wy = b * (lz * t.r0.x - lx * t.r0.z),
                  wz = b * (lx * t.r0.y - ly * t.r0.x);
      g[0] += e[7] * dx + e[10] * wx;
      g[1] += 0.5 * (e[7] * dy + e[8] * dx + e[10] * wy + e[11] * wx);
      g[2] += 0.5 * (e[7] * dz + e[9] * dx + e[10] * wz + e[12] * wx);
      g[3] += e[8] * dy + e[11] * wy;
      g[4] += 0.5 * (e[8] * dz + e[9] * dy + e[11] * wz + e[12] * wy);
      g[5] += e[9] * dz + e[12] * wz;
    }
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, g[c]);
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
  faces << 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6;
  return faces;
}

}  // namespace

Polyhedron::Polyhedron(Points vertices, Triangles triangles, const Vec3& polarization)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)), polarization_(polarization) {
  if (!polarization.allFinite()) throw InvalidInput("polarization must be finite [T], got a component that is not");
  radius_ = vertices_.rowwise().norm().maxCoeff();
  struct Sides {
    Vec3 in_plane = Vec3::Zero(), normal = Vec3::Zero();
  };
  std::map<std::pair<Index, Index>, Sides> sides;
  faces_.resize(face_stride * triangles_.rows());
  for (Index t = 0; t < triangles_.rows(); ++t) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = vertices_.row(triangles_(t, k)).transpose();
    const Vec3 area = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    const Vec3 normal = area.normalized();
    const double charge = polarization.dot(normal) / (4.0 * pi);
    volume_ += corner[0].dot(area) / 6.0;
    double* f = faces_.data() + face_stride * t;
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
    const Vec3 a = vertices_.row(ends.first).transpose(), b = vertices_.row(ends.second).transpose();
    edges_.insert(edges_.end(), {a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), (b - a).norm()});
    for (const Vec3& v : {s.in_plane, s.normal}) edges_.insert(edges_.end(), v.data(), v.data() + 3);
    edges_.push_back(0.0);
  }
}

Vec3 Polyhedron::moment() const { return polarization_ * volume_ / mu0; }

const Multipoles& Polyhedron::far() const {
  std::call_once(once_, [&] {
    std::vector<Vec3> positions;
    std::vector<double> charges;
    for (Index t = 0; t < triangles_.rows(); ++t) {
      const Vec3 a = vertices_.row(triangles_(t, 0)).transpose(), ab = vertices_.row(triangles_(t, 1)).transpose() - a,
                 bc = vertices_.row(triangles_(t, 2)).transpose() - a - ab;
      const double flux = ab.cross(bc).dot(polarization_), share = std::max(ab.norm(), bc.norm()) / radius_;
      // Points a side: exact for degree 24 on large faces; on small ones a harmonic is nearly linear.
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
  field_kernel(faces_.data(), static_cast<Index>(triangles_.rows()), edges_.data(),
               static_cast<Index>(edges_.size() / edge_stride), radius_, j.data(), points, n, field);
}

void Polyhedron::field_block(const double* points, Index n, Quantity quantity, double* field) const {
  const double bound = Multipoles::near * Multipoles::near * radius_ * radius_;
  split_block(
      points, n, 3, field, [&](double x, double y, double z) { return x * x + y * y + z * z < bound; },
      [&](const double* some, Index m, double* out) { near_field(some, m, quantity, out); },
      [&](const double* some, Index m, double* out) { far().field_block(some, m, out); });
}

void Polyhedron::gradient_block(const double* points, Index n, double* gradient) const {
  const double bound = Multipoles::near * Multipoles::near * radius_ * radius_;
  split_block(
      points, n, 6, gradient, [&](double x, double y, double z) { return x * x + y * y + z * z < bound; },
      [&](const double* some, Index m, double* out) {
        gradient_kernel(edges_.data(), static_cast<Index>(edges_.size() / edge_stride), radius_, some, m, out);
      },
      [&](const double* some, Index m, double* out) { far().gradient_block(some, m, out); });
}

MeshMagnet::MeshMagnet(const TriangleMesh& mesh, const Vec3& polarization)
    : Polyhedron(mesh.vertices(), mesh.triangles(), polarization) {
  if (!mesh.closed())
    throw InvalidInput("mesh must be closed to be a magnet, got a surface with open edges; close its holes");
  // 1e-12: far below any sheet a body can be, far above rounding.
  if (volume() < 1e-12 * std::pow(radius(), 3))
    throw InvalidInput("mesh must enclose a volume > 0 [m^3] with faces counter-clockwise seen from outside, got " +
                       std::to_string(volume()) + "; turn its faces or give it a thickness");
}

Cuboid::Cuboid(const Vec3& size, const Vec3& polarization)
    : Polyhedron(box_corners(size), box_triangles(), polarization), size_(size) {
  if (!(size.minCoeff() > 0.0) || !size.allFinite())
    throw InvalidInput("size must be three lengths > 0 [m], got (" + std::to_string(size.x()) + ", " +
                       std::to_string(size.y()) + ", " + std::to_string(size.z()) + ")");
}

std::optional<std::pair<Vec3, Vec3>> Polyhedron::box() const {
  return std::pair(Vec3(vertices_.colwise().minCoeff().transpose()), Vec3(vertices_.colwise().maxCoeff().transpose()));
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
