#include "core/magnetics/sources/charged_panels.h"

#include <algorithm>
#include <cmath>

#include "core/magnetics/sources/panel_kernels.h"

namespace loomstone {

namespace {

using namespace panel_kernels;

PanelTables tables_of(const PanelSet& set, double radius) {
  return {set.tables.data(), static_cast<Index>(set.panels.size()), radius};
}

PanelTables tables_of(const PanelRange& range) {
  PanelTables all = tables_of(range.set, range.set.radius);
  return {all.of(range.begin), range.size(), all.radius};
}

}  // namespace

PanelSet::PanelSet(std::vector<FlatPanel> all, int order, std::vector<PanelGrid> its_grids)
    : panels(std::move(all)), grids(std::move(its_grids)), per_panel(order * order) {
  samples.resize(per_panel * static_cast<Eigen::Index>(panels.size()), 3);
  shares.resize(samples.rows());
  Eigen::Index row = 0;
  for (const FlatPanel& panel : panels) {
    for (const PanelPoint& point : panel_points(panel, order)) {
      samples.row(row) = point.position.transpose();
      shares[row++] = point.share;
    }
    for (int k = 0; k < panel.corners; ++k) radius = std::max(radius, panel.corner[k].norm());
    add_panel_table(panel, tables);
  }
}

FluxMatrix panel_fluxes(const PanelRange& on, const RigidPose& pose, const PanelRange& by) {
  const Mat3 rotation = rotation_matrix(pose.orientation);
  FluxMatrix fluxes = FluxMatrix::Zero(on.size(), by.size());
  const Index count = on.size() * on.set.per_panel;
  const Index padded = (count + n_lanes - 1) / n_lanes * n_lanes;
  std::vector<double> points(3 * padded), normals(3 * padded, 0.0);
  std::vector<Index> rows(padded);
  for (Index i = 0; i < padded; ++i) {
    const Index sample = on.begin * on.set.per_panel + std::min(i, count - 1);
    const FlatPanel& panel = on.set.panels[sample / on.set.per_panel];
    rows[i] = sample / on.set.per_panel - on.begin;
    const Vec3 x = pose.position + rotation * on.set.samples.row(sample).transpose();
    const Vec3 normal = on.set.shares[sample] * panel.area * (rotation * panel.normal);
    for (int c = 0; c < 3; ++c) {
      points[c * padded + i] = x[c];
      if (i < count) normals[c * padded + i] = normal[c];
    }
  }
  const FluxPoints through{points.data(), normals.data(), rows.data(), padded};
  LOOMSTONE_WIDEST(flux_kernel)(tables_of(by), through, fluxes.data());
  return fluxes;
}

void panel_field(const PanelRange& by, const double* charges, const double* points, Index n,
                 double* field) {
  LOOMSTONE_WIDEST(field_kernel)(tables_of(by), charges, points, n, field);
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
  // Smoothing length in units of FlatPanel::reach. On a square with 3 x 3 samples, it is about a
  // quarter of the distance between neighbouring samples.
  constexpr double smoothing = 0.15;
  FineTables tables{PanelSet(fine_.parts, 1), {}};
  const auto add = [&](const Vec3& x, double charge, const FlatPanel& panel) {
    const double length = smoothing * panel.reach;
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
  LOOMSTONE_WIDEST(field_kernel)(tables_of(*set_, set_->radius), charges_.data(), points, n, field);
  const FineTables* fine = this->fine();
  if (!fine) return;
  alignas(64) double more[3 * points_per_block];
  LOOMSTONE_WIDEST(field_kernel)(tables_of(fine->parts, set_->radius), fine_.charges.data(), points,
                                 n, more);
  LOOMSTONE_WIDEST(add_smoothed_field)(
      fine->points.data(), static_cast<Index>(fine->points.size() / 5), points, n, more);
  for (Index i = 0; i < 3 * n; ++i) field[i] += more[i];
}

void ChargedPanels::gradient_block(const double* points, Index n, double* gradient) const {
  LOOMSTONE_WIDEST(gradient_kernel)(tables_of(*set_, set_->radius), charges_.data(), points, n,
                                    gradient);
  const FineTables* fine = this->fine();
  if (!fine) return;
  alignas(64) double more[6 * points_per_block];
  LOOMSTONE_WIDEST(gradient_kernel)(tables_of(fine->parts, set_->radius), fine_.charges.data(),
                                    points, n, more);
  LOOMSTONE_WIDEST(add_smoothed_gradient)(
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

Vector ChargedPanels::charge_errors() const {
  if (fine_.errors.size() == 0) return {};
  Vector errors(set_->samples.rows());
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    const Eigen::Index panel = i / set_->per_panel;
    errors[i] = fine_.errors[panel] / mu0 * set_->shares[i] * set_->panels[panel].area;
  }
  return errors;
}

}  // namespace loomstone
