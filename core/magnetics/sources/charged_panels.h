// Surface charge of induced bodies: uniform on each of many flat panels, optionally with a part
// that varies within panels and is known at points. The field of a panel has a closed form near it
// and is that of four point charges farther away than `near` times its reach.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/flat_panels.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

// The panels of a body, without their charge.
struct PanelSet {
  static constexpr double near =
      5.0;  // in reaches of a panel, from its centre; four points err by 2e-4 of its field there

  // order: sample points in each direction of a panel.
  PanelSet(std::vector<FlatPanel> panels, int order);

  std::vector<FlatPanel> panels;
  Points samples;  // (k x 3), panel by panel [m]
  Vector shares;   // (k) share of the panel's area [1]
  int per_panel = 0;
  double radius = 0.0;         // of the bounding ball about the origin [m]
  std::vector<double> tables;  // as the kernels read them
};

using FluxMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
// Fluxes of unit charge densities on the panels of `by` (columns) through the panels of `on` (rows)
// [m^2]; pose: that of `on` in the axes of `by`.
FluxMatrix panel_fluxes(const Team& team, const PanelSet& on, const RigidPose& pose,
                        const PanelSet& by);

class ChargedPanels final : public Source {
 public:
  // charges: mu0 sigma on each panel [T]; solid: the body that this surface encloses, if any.
  ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid = nullptr);
  // Additional charge that varies within panels: at samples of the set, and on parts of panels with
  // samples of their own.
  struct Fine {
    Vector at_samples;  // (of the set) [T m^2]
    std::vector<FlatPanel> parts;
    Vector charges;                    // of each part, its mean [T]
    std::vector<PanelSample> samples;  // whole charge of the parts, equally many samples each
    SourcePtr panel_means;             // the same body with uniform charge on panels
  };
  ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid, Fine fine);
  // Inside the surface B is reported as mu0 H, because the magnetisation there is unknown.
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  double radius() const override { return set_->radius; }
  Vec3 moment() const override;
  std::optional<std::pair<Vec3, Vec3>> box() const override {
    return solid_ ? solid_->box() : std::nullopt;
  }
  double depth(const Vec3& point) const override { return solid_ ? solid_->depth(point) : 0.0; }
  std::vector<Panel> surface() const override {
    return solid_ ? solid_->surface() : std::vector<Panel>();
  }
  bool induced() const override { return true; }
  std::vector<PanelSample> charges() const override;
  SourcePtr panel_means() const override { return fine_.panel_means; }

 private:
  // Tables for the field of the fine part, built on first use: the parts with their mean charge,
  // and the deviations of the samples from it as smoothed point charges, five numbers each:
  // position, charge / 4 pi [T m^2], square of the smoothing length [m^2].
  struct FineTables {
    PanelSet parts;
    std::vector<double> points;
  };
  const FineTables* fine() const;  // null where there is no fine part
  FineTables make_tables() const;

  std::shared_ptr<const PanelSet> set_;
  Vector charges_;
  SourcePtr solid_;
  Fine fine_;
  mutable std::once_flag once_;
  mutable std::optional<FineTables> tables_;
};

}  // namespace loomstone
