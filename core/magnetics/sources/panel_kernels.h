// Fields, fluxes and gradients of uniformly charged flat panels, and fields and gradients of
// smoothed point charges, at blocks of points. Near a panel, closed forms are used. Far from it,
// point charges at 2 x 2 quadrature points replace the panel.
#pragma once

#include <vector>

#include "core/magnetics/sources/charged_panels.h"
#include "core/magnetics/sources/flat_face.h"

namespace loomstone::panel_kernels {

// Layout of a panel's table:
//   centre, squared distance beyond which points replace the closed form,
//   number of triangles, number of edges,
//   2 triangles: corners, normal, twice the area,
//   4 edges: two ends, length, outward normal of the edge in the plane of the panel,
//   4 points: position, and the area that the point represents, divided by 4 pi.
// A triangular panel leaves the second triangle and the fourth edge unused.
inline constexpr int triangles_at = 6, triangle_stride = 13,
                     edges_at = triangles_at + 2 * triangle_stride, edge_stride = 10,
                     points_at = edges_at + 4 * edge_stride, stride = points_at + 16;

inline void add_panel_table(const FlatPanel& p, std::vector<double>& tables) {
  const std::size_t begin = tables.size();
  tables.resize(begin + stride, 0.0);
  double* t = tables.data() + begin;
  Eigen::Map<Vec3>(t + 0) = p.centre;
  t[3] = PanelSet::near * PanelSet::near * p.reach * p.reach;
  t[4] = p.corners - 2;
  t[5] = p.corners;
  for (int k = 0; k < p.corners - 2; ++k) {
    double* f = t + triangles_at + triangle_stride * k;
    const Vec3 corners[3] = {p.corner[0], p.corner[k + 1], p.corner[k + 2]};
    for (int c = 0; c < 3; ++c) Eigen::Map<Vec3>(f + 3 * c) = corners[c];
    Eigen::Map<Vec3>(f + 9) = p.normal;
    f[12] = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
  }
  for (int k = 0; k < p.corners; ++k) {
    double* e = t + edges_at + edge_stride * k;
    const Vec3 a = p.corner[k], b = p.corner[(k + 1) % p.corners];
    Eigen::Map<Vec3>(e + 0) = a;
    Eigen::Map<Vec3>(e + 3) = b;
    e[6] = (b - a).norm();
    Eigen::Map<Vec3>(e + 7) = (b - a).normalized().cross(p.normal);
  }
  const std::vector<PanelPoint> points = panel_points(p, 2);
  for (int k = 0; k < 4; ++k) {
    Eigen::Map<Vec3>(t + points_at + 4 * k) = points[k].position;
    t[points_at + 4 * k + 3] = points[k].share * p.area / (4.0 * pi);
  }
}

// Adds the field charge * r / square^(3/2) of a point charge. `square` is |r|^2, plus the squared
// smoothing length if the charge is smoothed.
template <class Lanes>
LOOMSTONE_INLINE void add_charge_field(const Lanes3<Lanes>& r, const Lanes& square, double charge,
                                       Lanes3<Lanes>& h) {
  const Lanes scale = charge / (square * lanes_sqrt(square));
  h.x += scale * r.x;
  h.y += scale * r.y;
  h.z += scale * r.z;
}

// Adds the gradient of the field of add_charge_field() as xx, xy, xz, yy, yz, zz.
template <class Lanes>
LOOMSTONE_INLINE void add_charge_gradient(const Lanes3<Lanes>& r, const Lanes& square,
                                          double charge, Lanes g[6]) {
  const Lanes inverse = 1.0 / square;
  const Lanes scale = charge * inverse * lanes_sqrt(inverse), three = 3.0 * scale * inverse;
  g[0] += scale - three * r.x * r.x;
  g[1] -= three * r.x * r.y;
  g[2] -= three * r.x * r.z;
  g[3] += scale - three * r.y * r.y;
  g[4] -= three * r.y * r.z;
  g[5] += scale - three * r.z * r.z;
}

// Returns the field of a unit charge density on the panel with table t.
template <class Lanes>
LOOMSTONE_INLINE Lanes3<Lanes> panel_field(const Lanes3<Lanes>& p, const double* t, double radius) {
  const Lanes3<Lanes> away{p.x - t[0], p.y - t[1], p.z - t[2]};
  const MaskOf<Lanes> beside = dot(away, away) < t[3];
  Lanes3<Lanes> h{};
  for (int c = 0; c < 4; ++c) {
    const double* q = t + points_at + 4 * c;
    const Lanes3<Lanes> r{p.x - q[0], p.y - q[1], p.z - q[2]};
    add_charge_field(r, dot(r, r), q[3], h);
  }
  if (!lanes_any(beside)) return h;
  Lanes omega{};
  for (int c = 0; c < t[4]; ++c)
    omega += solid_angle(p, t + triangles_at + triangle_stride * c, on_face * radius);
  const double* normal = t + triangles_at + 9;
  Lanes3<Lanes> exact{normal[0] * omega, normal[1] * omega, normal[2] * omega};
  for (int c = 0; c < t[5]; ++c) {
    const double* e = t + edges_at + edge_stride * c;
    const EdgeTerms<Lanes> terms = edge_terms(p, e, on_edge * radius);
    const Lanes log = lanes_log(terms.sum / terms.defect);
    exact.x += e[7] * log;
    exact.y += e[8] * log;
    exact.z += e[9] * log;
  }
  return {lanes_select(beside, exact.x / (4.0 * pi), h.x),
          lanes_select(beside, exact.y / (4.0 * pi), h.y),
          lanes_select(beside, exact.z / (4.0 * pi), h.z)};
}

// Tables of consecutive panels of a set, and the radius of the body's bounding sphere about the
// origin [m].
struct PanelTables {
  const double* tables;
  Index panels;
  double radius;
  LOOMSTONE_INLINE const double* of(Index panel) const {
    return tables + stride * static_cast<std::ptrdiff_t>(panel);
  }
};

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(PanelTables by, const double* charges, const double* points,
                                   Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> sum{};
    for (Index k = 0; k < by.panels; ++k) {
      const Lanes3<Lanes> h = panel_field(p, by.of(k), by.radius);
      sum.x += charges[k] * h.x;
      sum.y += charges[k] * h.y;
      sum.z += charges[k] * h.z;
    }
    lanes_store(out + i, sum.x);
    lanes_store(out + n + i, sum.y);
    lanes_store(out + 2 * n + i, sum.z);
  }
}

// Points on a surface as coordinate arrays: positions, and normals times areas. `row_of` contains
// the row of each point's panel in the flux matrix.
struct FluxPoints {
  const double *points, *normals;
  const Index* row_of;
  Index n;
};

// Computes, for a unit charge density on each panel of `by` (columns), the flux of its field
// through the area of each point of `on`. Adds it to the flux matrix `out`, in the row of the
// point's panel.
template <class Lanes>
LOOMSTONE_INLINE void flux_kernel(PanelTables by, FluxPoints on, double* out) {
  for (Index i = 0; i < on.n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(on.points + i, on.n);
    const Lanes3<Lanes> a = lanes3_load<Lanes>(on.normals + i, on.n);
    for (Index k = 0; k < by.panels; ++k) {
      const Lanes flux = dot(a, panel_field(p, by.of(k), by.radius));
      for (int lane = 0; lane < n_lanes; ++lane)
        out[static_cast<std::ptrdiff_t>(on.row_of[i + lane]) * by.panels + k] += flux[lane];
    }
  }
}

// Adds the gradient of the field of the uniform charge density `charge` on the panel with table t.
template <class Lanes>
LOOMSTONE_INLINE void add_panel_gradient(const Lanes3<Lanes>& p, const double* t, double radius,
                                         double charge, Lanes* sum) {
  const Lanes3<Lanes> away{p.x - t[0], p.y - t[1], p.z - t[2]};
  const MaskOf<Lanes> beside = dot(away, away) < t[3];
  Lanes g[6], exact[6];
  for (int c = 0; c < 6; ++c) g[c] = exact[c] = Lanes{};
  for (int c = 0; c < 4; ++c) {
    const double* q = t + points_at + 4 * c;
    const Lanes3<Lanes> r{p.x - q[0], p.y - q[1], p.z - q[2]};
    add_charge_gradient(r, dot(r, r), q[3], g);
  }
  if (lanes_any(beside)) {
    for (int c = 0; c < t[5]; ++c) {
      const double* e = t + edges_at + edge_stride * c;
      add_edge_gradients(edge_gradients(edge_terms(p, e, on_edge * radius), e), e + 7,
                         t + triangles_at + 9, exact);
    }
  }
  for (int c = 0; c < 6; ++c) sum[c] += charge * lanes_select(beside, exact[c] / (4.0 * pi), g[c]);
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(PanelTables by, const double* charges, const double* points,
                                      Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes sum[6];
    for (Lanes& s : sum) s = Lanes{};
    for (Index k = 0; k < by.panels; ++k)
      add_panel_gradient(p, by.of(k), by.radius, charges[k], sum);
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, sum[c]);
  }
}

// Adds the fields q r / (|r|^2 + s^2)^(3/2) of point charges q with smoothing lengths s, where r is
// the vector from the charge to the point. `charges` contains five values for each charge:
// position, q and s^2.
template <class Lanes>
LOOMSTONE_INLINE void add_smoothed_field(const double* charges, Index count, const double* points,
                                         Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> sum{};
    for (Index k = 0; k < count; ++k) {
      const double* q = charges + 5 * static_cast<std::ptrdiff_t>(k);
      const Lanes3<Lanes> r{p.x - q[0], p.y - q[1], p.z - q[2]};
      add_charge_field(r, dot(r, r) + q[4], q[3], sum);
    }
    lanes_store(out + i, lanes_load<Lanes>(out + i) + sum.x);
    lanes_store(out + n + i, lanes_load<Lanes>(out + n + i) + sum.y);
    lanes_store(out + 2 * n + i, lanes_load<Lanes>(out + 2 * n + i) + sum.z);
  }
}

template <class Lanes>
LOOMSTONE_INLINE void add_smoothed_gradient(const double* charges, Index count,
                                            const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes sum[6];
    for (int c = 0; c < 6; ++c) sum[c] = lanes_load<Lanes>(out + c * n + i);
    for (Index k = 0; k < count; ++k) {
      const double* q = charges + 5 * static_cast<std::ptrdiff_t>(k);
      const Lanes3<Lanes> r{p.x - q[0], p.y - q[1], p.z - q[2]};
      add_charge_gradient(r, dot(r, r) + q[4], q[3], sum);
    }
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, sum[c]);
  }
}

}  // namespace loomstone::panel_kernels
