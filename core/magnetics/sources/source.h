// Sources of magnetic fields in their own axes: what every source can do. Formulas stand in the
// files named after them.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/magnetics/sources/panel.h"
#include "core/parallel/team.h"

namespace loomstone {

using Gradients =
    Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;  // (n x 9) rows dB_i/dx_j, i slowest

// Points of a block lie as x[n], y[n], z[n]; fields likewise; gradients as xx, xy, xz, yy, yz, zz.
// n is a multiple of 8.
inline constexpr Index points_per_block = 128;

// What a field is asked for: flux density, or mu0 times the field strength. They differ inside
// magnets by the polarisation.
enum class Quantity { flux_density, mu0_field_strength };

class DipoleSet;
class Source;
using SourcePtr = std::shared_ptr<const Source>;

// A circular loop about z (length 0) or a sheet of current on the cylinder |z| <= length / 2.
struct CircularWinding {
  double radius, length;  // [m]
  double current;         // of a loop [A], of a sheet per length [A/m]
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
  // Both at once, the same bits.
  virtual void field_and_gradient_block(const double* points, Index n, Quantity quantity,
                                        double* field, double* gradient) const {
    field_block(points, n, quantity, field);
    gradient_block(points, n, gradient);
  }
  // mu0 times the scalar potential of one block, whose descent is mu0 H and which vanishes far away
  // [T m]. Throws Unsupported for currents, which have none.
  virtual void potential_block(const double* points, Index n, double* potential) const;
  // Vector potential [T m] of one block. Throws Unsupported unless winding() has a value.
  virtual void vector_potential_block(const double* points, Index n, double* potential) const;
  // Radius of the ball about the origin that holds the source [m].
  virtual double radius() const = 0;
  // Dipole moment [A m^2].
  virtual Vec3 moment() const = 0;
  // Of solid bodies: bounding box [m], and depth of a point below the surface, negative outside
  // [m].
  virtual std::optional<std::pair<Vec3, Vec3>> box() const { return std::nullopt; }
  virtual double depth(const Vec3&) const { return 0.0; }
  virtual bool spherical() const { return false; }
  // False where its current has ends.
  virtual bool steady() const { return true; }
  // Where its charge or current sits; empty for dipoles, which dipoles() gives.
  virtual std::vector<Panel> panels() const { return {}; }
  // Of solid bodies: their whole surface, also where it carries no charge.
  virtual std::vector<Panel> surface() const { return {}; }
  // Of induced bodies: their charge at points that are enough for integrals over it; empty for all
  // others.
  virtual bool induced() const { return false; }
  virtual std::vector<PanelSample> charges() const { return {}; }
  // The same induced body with the mean charge of each panel; null for all others and where the
  // charge is uniform on panels already.
  virtual SourcePtr panel_means() const { return nullptr; }
  // Dipoles with exactly the field of the source outside of it (of a sphere one); null for all
  // others.
  virtual const DipoleSet* dipoles() const { return nullptr; }
  // Forms that closed formulas are known for.
  virtual std::optional<CircularWinding> winding() const { return std::nullopt; }
  virtual std::optional<UniformCuboid> uniform_cuboid() const { return std::nullopt; }
};

// Throws InvalidInput naming the first point that is not finite.
void check_points(const ConstPointsRef& points, const char* name);

}  // namespace loomstone
