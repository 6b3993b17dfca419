// Interface of all field sources: magnets, currents and induced bodies. A source computes its field
// in its own axes, and a potential if there is one. It also returns its shape, and its charge or
// current as panels, as charges at points or as dipoles.
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

// (n x 9) Each row is the gradient dB_i/dx_j at one point, as a row-major 3 x 3 matrix.
using Gradients = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;

// A block consists of n <= points_per_block points, stored as separate coordinate arrays x[n],
// y[n], z[n]; n is a multiple of 8. Fields use the same layout. Symmetric gradients are stored as
// xx, xy, xz, yy, yz, zz.
inline constexpr Index points_per_block = 128;

// B or mu0 H. Inside a magnet of polarization J, B = mu0 H + J.
enum class Quantity { flux_density, mu0_field_strength };

class CellMagnet;
class ChargedPanels;
class DipoleSet;
class Source;
using SourcePtr = std::shared_ptr<const Source>;

// A circular loop about the z axis (length 0), or a current sheet on the cylinder
// |z| <= length / 2.
struct CircularWinding {
  double radius, length;  // [m]
  double current;         // total current of a loop [A], or current per length of a sheet [A/m]
  double turn_current;    // current in each turn [A]
};

// A uniformly magnetised cuboid centred at the origin.
struct UniformCuboid {
  Vec3 size, polarization;  // edge lengths [m], J [T]
};

// Radii of a uniformly magnetised cylinder or ring about the z axis, centred at the origin.
struct UniformCylinder {
  double radius, inner_radius;  // [m]; inner_radius is 0 for a cylinder
};

// End of a series of solid harmonics.
struct SeriesEnd {
  int degree = 0;  // highest degree of the series; 0: no series
  // Number x such that the terms of high degree l of the force on the source decay as exp(-x l); 0
  // if unknown.
  double decay = 0.0;
};

class Source {
 public:
  virtual ~Source() = default;
  // Computes mu0 H or B [T] at one block of points.
  virtual void field_block(const double* points, Index n, Quantity quantity,
                           double* field) const = 0;
  // Computes the symmetric gradient of mu0 H [T/m] at one block of points. Throws InvalidInput
  // unless steady().
  virtual void gradient_block(const double* points, Index n, double* gradient) const = 0;
  // Computes the results of field_block() and gradient_block() together. They are bit-identical to
  // those of two separate calls.
  virtual void field_and_gradient_block(const double* points, Index n, Quantity quantity,
                                        double* field, double* gradient) const {
    field_block(points, n, quantity, field);
    gradient_block(points, n, gradient);
  }
  // Computes the magnetic scalar potential, multiplied by mu0 [T m], at one block of points. This
  // product vanishes at infinity, and its negative gradient is mu0 H. Throws Unsupported for
  // currents and induced bodies.
  virtual void potential_block(const double* points, Index n, double* potential) const;
  // Computes the vector potential [T m] at one block of points. Throws Unsupported unless winding()
  // has a value.
  virtual void vector_potential_block(const double* points, Index n, double* potential) const;
  // Returns the radius of a sphere about the origin that contains the source [m].
  virtual double radius() const = 0;
  // Returns the dipole moment [A m^2].
  virtual Vec3 moment() const = 0;
  // For solid bodies, box() returns the bounding box [m], and depth() returns the depth of a point
  // below the surface [m], which is negative outside. For all other sources and for magnets divided
  // into cells, box() has no value and depth() is 0.
  virtual std::optional<std::pair<Vec3, Vec3>> box() const { return std::nullopt; }
  virtual double depth(const Vec3&) const { return 0.0; }
  virtual bool spherical() const { return false; }
  // Returns the end of the series of solid harmonics that describes the induced charge of a sphere.
  // For all other sources, the degree of the result is 0.
  virtual SeriesEnd series_end() const { return {}; }
  // Returns false for an open current path.
  virtual bool steady() const { return true; }
  // Returns the panels that carry magnetic charge or current. Spheres, dipoles, magnets divided
  // into cells, and induced bodies have none; see dipoles() and charges().
  virtual std::vector<Panel> panels() const { return {}; }
  // Returns the whole surface of a solid body, including panels without charge. The result is empty
  // for spheres, magnets divided into cells, and sources that are not solid.
  virtual std::vector<Panel> surface() const { return {}; }
  // induced() returns true for a body with induced surface charge. charges() returns quadrature
  // points of this charge, or an empty list for all other sources.
  virtual bool induced() const { return false; }
  virtual std::vector<PanelSample> charges() const { return {}; }
  // Returns the estimated errors of the first entries of charges() [A m]. The remaining entries
  // count as exact. The vector is empty if there is no estimate.
  virtual Vector charge_errors() const { return {}; }
  // If this is an induced body whose charge varies within panels, returns the same body with the
  // charge density on each panel replaced by its mean. Returns null for all other sources.
  virtual SourcePtr panel_means() const { return nullptr; }
  // Returns dipoles that produce the field outside the source (one for a hard sphere), or null if
  // there are none.
  virtual const DipoleSet* dipoles() const { return nullptr; }
  // charged_panels() returns the source itself if it consists of charged panels, and cell_magnet()
  // if it consists of dipole cells. Otherwise, each returns null.
  virtual const ChargedPanels* charged_panels() const { return nullptr; }
  virtual const CellMagnet* cell_magnet() const { return nullptr; }
  // winding() has a value for loops and solenoids, uniform_cuboid() for cuboids, and
  // uniform_cylinder() for cylinders and rings.
  virtual std::optional<CircularWinding> winding() const { return std::nullopt; }
  virtual std::optional<UniformCuboid> uniform_cuboid() const { return std::nullopt; }
  virtual std::optional<UniformCylinder> uniform_cylinder() const { return std::nullopt; }
  // Returns a copy of a loop or solenoid with the given current in each turn [A], or null for all
  // other sources.
  virtual SourcePtr with_current(double) const { return nullptr; }
  // Returns the recipe of the source. Its kind is empty for induced bodies and for ExpandedMesh.
  virtual SourceRecipe recipe() const { return {}; }
};

// Throws InvalidInput if a row is not finite. The message names the first such row.
void check_points(const ConstPointsRef& points, const char* name);

}  // namespace loomstone
