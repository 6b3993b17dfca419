#include "core/magnetics/sources/charged_panels.h"

#include <algorithm>
#include <cmath>

#include "core/magnetics/sources/flat_face.h"

namespace loomstone {

namespace {

// A panel in the tables: centre, square of the distance from which points serve, number of
// triangles and edges; two triangles (corners, normal, twice the area); four edges (two ends,
// length, normal of the edge in the plane); four points with their area / 4 pi.
constexpr int triangles_at = 6, triangle_stride = 13, edges_at = triangles_at + 2 * triangle_stride,
              edge_stride = 10, points_at = edges_at + 4 * edge_stride, stride = points_at + 16;

void add_table(const FlatPanel& p, std::vector<double>& tables) {
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

// Field q r / square^(3/2) of a charge at the distance r, square: r^2, more where the charge is
// blunted.
template <class Lanes>
LOOMSTONE_INLINE void add_charge_field(const Lanes3<Lanes>& r, const Lanes& square, double charge,
                                       Lanes3<Lanes>& h) {
  const Lanes scale = charge / (square * lanes_sqrt(square));
  h.x += scale * r.x;
  h.y += scale * r.y;
  h.z += scale * r.z;
}

// The gradient of that: xx, xy, xz, yy, yz, zz.
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

// Field of unit charge on the panel of a table.
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

template <class Lanes>
LOOMSTONE_INLINE void field_kernel(const double* tables, const double* charges, Index panels,
                                   double radius, const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes3<Lanes> sum{};
    for (Index k = 0; k < panels; ++k) {
      const Lanes3<Lanes> h =
          panel_field(p, tables + stride * static_cast<std::ptrdiff_t>(k), radius);
      sum.x += charges[k] * h.x;
      sum.y += charges[k] * h.y;
      sum.z += charges[k] * h.z;
    }
    lanes_store(out + i, sum.x);
    lanes_store(out + n + i, sum.y);
    lanes_store(out + 2 * n + i, sum.z);
  }
}

// normals: of each point times its area, laid out as the points; adds to rows of `out`, `row_of`
// each point.
template <class Lanes>
LOOMSTONE_INLINE void flux_kernel(const double* tables, Index panels, double radius,
                                  const double* points, const double* normals, Index n,
                                  const Index* row_of, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    const Lanes3<Lanes> a = lanes3_load<Lanes>(normals + i, n);
    for (Index k = 0; k < panels; ++k) {
      const Lanes flux =
          dot(a, panel_field(p, tables + stride * static_cast<std::ptrdiff_t>(k), radius));
      for (int lane = 0; lane < n_lanes; ++lane)
        out[static_cast<std::ptrdiff_t>(row_of[i + lane]) * panels + k] += flux[lane];
    }
  }
}

template <class Lanes>
LOOMSTONE_INLINE void gradient_kernel(const double* tables, const double* charges, Index panels,
                                      double radius, const double* points, Index n, double* out) {
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> p = lanes3_load<Lanes>(points + i, n);
    Lanes sum[6];
    for (Lanes& s : sum) s = Lanes{};
    for (Index k = 0; k < panels; ++k) {
      const double* t = tables + stride * static_cast<std::ptrdiff_t>(k);
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
      for (int c = 0; c < 6; ++c)
        sum[c] += charges[k] * lanes_select(beside, exact[c] / (4.0 * pi), g[c]);
    }
    for (int c = 0; c < 6; ++c) lanes_store(out + c * n + i, sum[c]);
  }
}

// Charges at points that are blunted: r / (r^2 + length^2)^(3/2).
template <class Lanes>
LOOMSTONE_INLINE void add_blunt_field(const double* charges, Index count, const double* points,
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
LOOMSTONE_INLINE void add_blunt_gradient(const double* charges, Index count, const double* points,
                                         Index n, double* out) {
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

}  // namespace

PanelSet::PanelSet(std::vector<FlatPanel> all, int order)
    : panels(std::move(all)), per_panel(order * order) {
  samples.resize(per_panel * static_cast<Eigen::Index>(panels.size()), 3);
  shares.resize(samples.rows());
  Eigen::Index row = 0;
  for (const FlatPanel& panel : panels) {
    for (const PanelPoint& point : panel_points(panel, order)) {
      samples.row(row) = point.position.transpose();
      shares[row++] = point.share;
    }
    for (int k = 0; k < panel.corners; ++k) radius = std::max(radius, panel.corner[k].norm());
    add_table(panel, tables);
  }
}

FluxMatrix panel_fluxes(const Team& team, const PanelSet& on, const RigidPose& pose,
                        const PanelSet& by) {
  constexpr Index at_once = 8;  // panels: points then come in eights
  const auto n = static_cast<Index>(on.panels.size());
  const Mat3 rotation = rotation_matrix(pose.orientation);
  FluxMatrix fluxes = FluxMatrix::Zero(n, by.panels.size());
  parallel_for(
      team, (n + at_once - 1) / at_once,
      [&](Index block) {
        const Index first = block * at_once, count = std::min(at_once, n - first) * on.per_panel;
        const Index padded = (count + n_lanes - 1) / n_lanes * n_lanes;
        std::vector<double> points(3 * padded), normals(3 * padded, 0.0);
        std::vector<Index> rows(padded);
        for (Index i = 0; i < padded; ++i) {
          const Index sample = first * on.per_panel + std::min(i, count - 1);
          rows[i] = sample / on.per_panel;
          const FlatPanel& panel = on.panels[rows[i]];
          const Vec3 x = pose.position + rotation * on.samples.row(sample).transpose();
          const Vec3 normal = on.shares[sample] * panel.area * (rotation * panel.normal);
          for (int c = 0; c < 3; ++c) {
            points[c * padded + i] = x[c];
            if (i < count) normals[c * padded + i] = normal[c];
          }
        }
        LOOMSTONE_WIDEST(flux_kernel)(by.tables.data(), static_cast<Index>(by.panels.size()),
                                      by.radius, points.data(), normals.data(), padded, rows.data(),
                                      fluxes.data());
      },
      1);
  return fluxes;
}

ChargedPanels::ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid)
    : ChargedPanels(std::move(set), std::move(charges), std::move(solid), Fine{}) {}

ChargedPanels::ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid,
                             Fine fine)
    : set_(std::move(set)),
      charges_(std::move(charges)),
      solid_(std::move(solid)),
      fine_(std::move(fine)) {}

ChargedPanels::FineTables ChargedPanels::make_tables() const {
  constexpr double blunt = 0.15;  // of a panel's reach, a quarter of the distance of samples
  FineTables tables{PanelSet(fine_.parts, 1), {}};
  const auto add = [&](const Vec3& x, double charge, const FlatPanel& panel) {
    const double length = blunt * panel.reach;
    tables.points.insert(tables.points.end(),
                         {x[0], x[1], x[2], charge / (4.0 * pi), length * length});
  };
  for (Eigen::Index i = 0; i < fine_.at_samples.size(); ++i)
    if (fine_.at_samples[i] != 0.0)
      add(set_->samples.row(i).transpose(), fine_.at_samples[i], set_->panels[i / set_->per_panel]);
  for (std::size_t i = 0; i < fine_.samples.size(); ++i) {
    const std::size_t part = i / (fine_.samples.size() / fine_.parts.size());
    const PanelSample& sample = fine_.samples[i];
    add(sample.position,
        mu0 * sample.charge - fine_.charges[static_cast<Eigen::Index>(part)] * sample.area.norm(),
        fine_.parts[part]);
  }
  return tables;
}

const ChargedPanels::FineTables* ChargedPanels::fine() const {
  if (fine_.at_samples.size() == 0) return nullptr;
  std::call_once(once_, [this] { tables_ = make_tables(); });
  return &*tables_;
}

void ChargedPanels::field_block(const double* points, Index n, Quantity, double* field) const {
  LOOMSTONE_WIDEST(field_kernel)(set_->tables.data(), charges_.data(),
                                 static_cast<Index>(charges_.size()), set_->radius, points, n,
                                 field);
  const FineTables* fine = this->fine();
  if (!fine) return;
  alignas(64) double more[3 * points_per_block];
  LOOMSTONE_WIDEST(field_kernel)(fine->parts.tables.data(), fine_.charges.data(),
                                 static_cast<Index>(fine_.charges.size()), set_->radius, points, n,
                                 more);
  LOOMSTONE_WIDEST(add_blunt_field)(fine->points.data(),
                                    static_cast<Index>(fine->points.size() / 5), points, n, more);
  for (Index i = 0; i < 3 * n; ++i) field[i] += more[i];
}

void ChargedPanels::gradient_block(const double* points, Index n, double* gradient) const {
  LOOMSTONE_WIDEST(gradient_kernel)(set_->tables.data(), charges_.data(),
                                    static_cast<Index>(charges_.size()), set_->radius, points, n,
                                    gradient);
  const FineTables* fine = this->fine();
  if (!fine) return;
  alignas(64) double more[6 * points_per_block];
  LOOMSTONE_WIDEST(gradient_kernel)(fine->parts.tables.data(), fine_.charges.data(),
                                    static_cast<Index>(fine_.charges.size()), set_->radius, points,
                                    n, more);
  LOOMSTONE_WIDEST(add_blunt_gradient)(
      fine->points.data(), static_cast<Index>(fine->points.size() / 5), points, n, more);
  for (Index i = 0; i < 6 * n; ++i) gradient[i] += more[i];
}

Vec3 ChargedPanels::moment() const {
  Vec3 sum = Vec3::Zero();
  for (Eigen::Index i = 0; i < charges_.size(); ++i)
    sum += charges_[i] / mu0 * set_->panels[i].area * set_->panels[i].centre;
  for (Eigen::Index i = 0; i < fine_.at_samples.size(); ++i)
    sum += fine_.at_samples[i] / mu0 * set_->samples.row(i).transpose();
  for (const PanelSample& sample : fine_.samples) sum += sample.charge * sample.position;
  return sum;
}

std::vector<PanelSample> ChargedPanels::charges() const {
  std::vector<PanelSample> result(set_->samples.rows());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto panel = static_cast<Eigen::Index>(i) / set_->per_panel;
    result[i].position = set_->samples.row(i).transpose();
    result[i].area = set_->shares[i] * set_->panels[panel].area * set_->panels[panel].normal;
    result[i].charge = charges_[panel] / mu0 * set_->shares[i] * set_->panels[panel].area;
    if (fine_.at_samples.size() > 0)
      result[i].charge += fine_.at_samples[static_cast<Eigen::Index>(i)] / mu0;
  }
  result.insert(result.end(), fine_.samples.begin(), fine_.samples.end());
  return result;
}

}  // namespace loomstone
