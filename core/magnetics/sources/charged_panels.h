// Surface charge that is uniform on each of many flat panels, as induced bodies carry it: exact
// beside a panel, from points of quadrature beyond `near` times its reach. What varies within
// panels besides is known at points.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/flat_panels.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

// What stays when the charge changes.
struct PanelSet {
  static constexpr double near =
      5.0;  // in reaches of a panel, from its centre: there points err by 2e-4 of its field

  // order: points a direction on which fields are sampled.
  PanelSet(std::vector<FlatPanel> panels, int order);

  std::vector<FlatPanel> panels;
  Points samples;  // (k x 3), panel after panel [m]
  Vector shares;   // (k) of the panel's area
  int per_panel = 0;
  double radius = 0.0;         // of the ball about the origin that holds them [m]
  std::vector<double> tables;  // of the kernels
};

using FluxMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
// Fluxes of unit charge on the panels of `by` (columns) through those of `on` (rows) [m^2], which
// stands at a pose in the axes of `by`.
FluxMatrix panel_fluxes(const Team& team, const PanelSet& on, const RigidPose& pose,
                        const PanelSet& by);

class ChargedPanels final : public Source {
 public:
  // charges: mu0 sigma on each panel [T]; solid: the body that has this surface, if it is closed.
  ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid = nullptr);
  // Besides, charge that varies within panels: at samples of the set, and uniform on parts of
  // panels with samples of theirs.
  struct Fine {
    Vector at_samples;  // (of the set) [T m^2]
    std::vector<FlatPanel> parts;
    Vector charges;                    // of each part, its mean [T]
    std::vector<PanelSample> samples;  // of the parts, the same number of each: their whole charge
    SourcePtr panel_means;             // the same body with charge that is uniform on panels
  };
  ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid, Fine fine);
  // Inside of the surface the flux density is given as mu0 H: how the body is magnetised there is
  // not known here.
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
  // What fields of the fine part need, made when the first is asked for: the parts, and what
  // samples have beyond their share of the charge of panels, by five: position, charge / 4 pi [T
  // m^2], square of a length that blunts it [m^2].
  struct FineTables {
    PanelSet parts;
    std::vector<double> points;
  };
  const FineTables* fine() const;  // null: there is none
  FineTables make_tables() const;

  std::shared_ptr<const PanelSet> set_;
  Vector charges_;
  SourcePtr solid_;
  Fine fine_;
  mutable std::once_flag once_;
  mutable std::optional<FineTables> tables_;
};

}  // namespace loomstone
