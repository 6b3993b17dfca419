// Surface charge of induced bodies, on flat panels. A uniform charge density on each panel can be
// supplemented by a charge that varies within panels and is given at sample points. Near a panel,
// the field of the uniform charge is computed in closed form. Farther away, four point charges
// replace the panel. Deviations from uniform charge act as smoothed point charges.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/base/rotation.h"
#include "core/magnetics/sources/flat_panels.h"
#include "core/magnetics/sources/source.h"

namespace loomstone {

// A grid of panels on the surface of a body. Richardson extrapolation superposes the charges of
// several grids, each multiplied by the grid's weight `share`.
struct PanelGrid {
  Index begin = 0, end = 0;  // range of its panels in the set
  double share = 1.0;
};

// Panels of a body, without their charge.
struct PanelSet {
  // Distance from a panel's centre, in units of FlatPanel::reach, beyond which four point charges
  // replace the closed form. Beyond this distance, the relative error of the field is at most about
  // 2.4e-4 for a square and 1.2e-3 for an equilateral triangle.
  static constexpr double near = 5.0;

  // `order` is the number of sample points in each direction of a panel.
  PanelSet(std::vector<FlatPanel> panels, int order, std::vector<PanelGrid> grids = {});

  std::vector<FlatPanel> panels;
  std::vector<PanelGrid> grids;
  Points samples;  // sample points (k x 3), ordered by panel [m]
  Vector shares;   // fraction of the panel's area that a sample represents (k)
  int per_panel = 0;
  double radius = 0.0;         // radius of the bounding sphere about the origin [m]
  std::vector<double> tables;  // kernel data (panel_kernels.h)
};

// Panels [begin, end) of a set.
struct PanelRange {
  const PanelSet& set;
  Index begin, end;
  Index size() const { return end - begin; }
};

using FluxMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
// Computes, for a unit charge density on each panel of `by` (columns), the flux [m^2] of its field
// through each panel of `on` (rows). `pose` is the pose of `on` in the axes of `by`.
FluxMatrix panel_fluxes(const PanelRange& on, const RigidPose& pose, const PanelRange& by);

// Computes mu0 H [T] of panels at n points. `charges` contains mu0 sigma on each panel [T]. Points
// and field have the layout of a block (see points_per_block), but n can be any multiple of 8.
void panel_field(const PanelRange& by, const double* charges, const double* points, Index n,
                 double* field);

class ChargedPanels final : public Source {
 public:
  // `charges` contains mu0 sigma on each panel [T], multiplied by PanelGrid::share. `solid` is the
  // body that the panels enclose, or null.
  ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid = nullptr);
  // Additional charge that varies within panels. On a panel that is divided into parts, it is given
  // on the parts, which have samples of their own. On all other panels, it is given at the samples
  // of the set.
  struct Fine {
    Vector at_samples;  // mu0 times the additional charge at each sample of the set [T m^2]
    std::vector<FlatPanel> parts;
    Vector charges;  // mean of the additional mu0 sigma on each part [T]
    // Samples of the additional charge on the parts. Their charges include the means in `charges`.
    // Each part has the same number of samples.
    std::vector<PanelSample> samples;
    SourcePtr panel_means;  // the same body with uniform charge on each panel
    Vector errors;          // estimated error of mu0 sigma on each panel [T]; empty if unknown
  };
  ChargedPanels(std::shared_ptr<const PanelSet> set, Vector charges, SourcePtr solid, Fine fine);
  // Inside the surface, field_block() returns mu0 H even if B is requested, because the
  // magnetisation is unknown there.
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
  Vector charge_errors() const override;
  SourcePtr panel_means() const override { return fine_.panel_means; }
  const ChargedPanels* charged_panels() const override { return this; }
  const PanelSet& set() const { return *set_; }
  const Vector& uniform_charges() const { return charges_; }  // `charges` of the constructor [T]
  // Returns the estimated errors of mu0 sigma on each panel [T], or an empty vector if they are
  // unknown.
  const Vector& panel_errors() const { return fine_.errors; }

 private:
  // Data for the field of the additional charge, built on first use. `parts` carry their mean
  // charge. `points` are smoothed point charges: those of Fine::at_samples, and the deviations of
  // Fine::samples from the mean charge of their part. Each point has five values: position [m],
  // mu0/4pi times the charge [T m^2] and squared smoothing length [m^2].
  struct FineTables {
    PanelSet parts;
    std::vector<double> points;
  };
  const FineTables* fine() const;  // null if there is no additional charge
  FineTables make_tables() const;

  std::shared_ptr<const PanelSet> set_;
  Vector charges_;
  SourcePtr solid_;
  Fine fine_;
  mutable std::once_flag once_;
  mutable std::optional<FineTables> tables_;
};

}  // namespace loomstone
