// The interface that magnets, currents and induced bodies share: fields and potentials in the
// source's own axes, its shape, and its charge or current as quadrature points. Formulas stand in
// the files named after the sources.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/magnetics/sources/panel.h"
#include "core/magnetics/sources/recipe.h"
#include "core/parallel/team.h"

namespace loomstone {

using Gradients =
    Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;  // (n x 9) rows dB_i/dx_j, i slowest

// A block stores its n points by columns, x[n], y[n], z[n], and fields likewise; symmetric
// gradients as xx, xy, xz, yy, yz, zz. n is a multiple of 8.
inline constexpr Index points_per_block = 128;

// B, or mu0 H; inside a magnet B = mu0 H + J with the polarisation J.
enum class Quantity { flux_density, mu0_field_strength };

class DipoleSet;
class Source;
using SourcePtr = std::shared_ptr<const Source>;

// A circular loop about z (length 0) or a sheet of current on the cylinder |z| <= length / 2.
struct CircularWinding {
  double radius, length;  // [m]
  double current;         // of a loop [A], of a sheet per length [A/m]
  double turn_current;    // in each turn [A]
};

// A cuboid about the origin with uniform polarisation.
struct UniformCuboid {
  Vec3 size, polarization;  // edges [m], J [T]
};

class Source {
 public:
  virtual ~Source() = default;
  // mu0 H or B [T] of one block.
  virtual void field_block(const double* points, Index n, Quantity quantity,
                           double* field) const = 0;
  // Symmetric gradient of mu0 H [T/m] of one block.
  virtual void gradient_block(const double* points, Index n, double* gradient) const = 0;
  // Both at once; the same bits as one after the other.
  virtual void field_and_gradient_block(const double* points, Index n, Quantity quantity,
                                        double* field, double* gradient) const {
    field_block(points, n, quantity, field);
    gradient_block(points, n, gradient);
  }
  // Magnetic scalar potential times mu0 of one block [T m]: mu0 H is minus its gradient, and it
  // vanishes at infinity. Throws Unsupported for currents and induced bodies.
  virtual void potential_block(const double* points, Index n, double* potential) const;
  // Vector potential [T m] of one block. Throws Unsupported unless winding() has a value.
  virtual void vector_potential_block(const double* points, Index n, double* potential) const;
  // Radius of the bounding ball about the origin [m].
  virtual double radius() const = 0;
  // Dipole moment [A m^2].
  virtual Vec3 moment() const = 0;
  // Bounding box of a solid body [m]; other sources have none. Depth of a point below its surface,
  // negative outside [m].
  virtual std::optional<std::pair<Vec3, Vec3>> box() const { return std::nullopt; }
  virtual double depth(const Vec3&) const { return 0.0; }
  virtual bool spherical() const { return false; }
  // False for a current whose ends do not meet.
  virtual bool steady() const { return true; }
  // Panels that carry magnetic charge or current. Empty for dipoles (see dipoles()) and induced
  // bodies (see charges()).
  virtual std::vector<Panel> panels() const { return {}; }
  // The whole surface of a solid body, panels without charge included.
  virtual std::vector<Panel> surface() const { return {}; }
  // True for a body that the field around it magnetises. charges() then samples its surface charge
  // densely enough for integrals; for other sources it is empty.
  virtual bool induced() const { return false; }
  virtual std::vector<PanelSample> charges() const { return {}; }
  // An induced body with the mean charge on each panel. Null for other sources, and where the
  // charge is uniform on each panel already.
  virtual SourcePtr panel_means() const { return nullptr; }
  // Dipoles whose field equals that of the source everywhere outside it (one for a sphere); null
  // for other sources.
  virtual const DipoleSet* dipoles() const { return nullptr; }
  // Shapes with closed formulas for forces and inductances.
  virtual std::optional<CircularWinding> winding() const { return std::nullopt; }
  virtual std::optional<UniformCuboid> uniform_cuboid() const { return std::nullopt; }
  // The same winding with another current in each turn [A]; null for all other sources.
  virtual SourcePtr with_current(double) const { return nullptr; }
  // Without kind of what is found by induction.
  virtual SourceRecipe recipe() const { return {}; }
};

// Throws InvalidInput naming the first point that is not finite.
void check_points(const ConstPointsRef& points, const char* name);

}  // namespace loomstone
