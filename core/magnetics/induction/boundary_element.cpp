#include "core/magnetics/induction/boundary_element.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "core/base/simd.h"
#include "core/magnetics/sources/charged_panels.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

// If the centres of two panels are farther apart than this multiple of the sum of their
// FlatPanel::reach, the flux between the panels is computed by quadrature over both.
constexpr double near = 3.0;

// Returns log(r - u) without cancellation, where r^2 = u^2 + rest. For r = u, it returns a finite
// value in place of -infinity, because the kernels below then multiply it by zero.
double log_below(double r, double u, double rest) {
  return std::log(std::max(u > 0.0 ? rest / (r + u) : r - u, 1e-300));
}

// Antiderivatives with which the normal component of the field of a point charge is integrated over
// two rectangles: the positions of the charge and the points that receive the field [Akoun1984].
// They are summed over all pairs of corners with alternating signs (rectangle_flux). u, v and w are
// coordinate differences between two corners, and r is their distance. For parallel rectangles, w
// is along their normal, and the component is w / r^3. For perpendicular rectangles, u is along the
// normal of the rectangle that receives the field, v is along their common edge direction, and the
// component is u / r^3.
double parallel_kernel(double u, double v, double w) {
  const double r = std::sqrt(u * u + v * v + w * w);
  return -u * w * log_below(r, u, v * v + w * w) - v * w * log_below(r, v, u * u + w * w) +
         u * v * std::atan2(u * v, r * w) - r * w;
}

double perpendicular_kernel(double u, double v, double w) {
  const double r = std::sqrt(u * u + v * v + w * w);
  return 0.5 * (v * v - u * u) * log_below(r, w, u * u + v * v) +
         w * v * log_below(r, v, u * u + w * w) + v * u * std::atan2(w * v, r * u) + 0.5 * r * w;
}

struct Rectangle {
  int axis = 0;
  Vec3 low, high;
};

Rectangle rectangle_of(const FlatPanel& p) {
  Rectangle r;
  p.normal.cwiseAbs().maxCoeff(&r.axis);
  r.low = r.high = p.corner[0];
  for (int k = 1; k < 4; ++k)
    r.low = r.low.cwiseMin(p.corner[k]), r.high = r.high.cwiseMax(p.corner[k]);
  return r;
}

// Returns the flux through `on` that a unit charge density on `by` causes [m^2]. A flux along the
// positive coordinate axis on.axis, which is normal to `on`, counts as positive.
double rectangle_flux(const Rectangle& on, const Rectangle& by) {
  const Vec3 on_ends[2] = {on.low, on.high}, by_ends[2] = {by.low, by.high};
  double sum = 0.0;
  const bool parallel = on.axis == by.axis;
  const int a = parallel ? (on.axis + 1) % 3 : on.axis,
            b = parallel ? (on.axis + 2) % 3 : 3 - on.axis - by.axis;
  for (int i = 0; i < 16; ++i) {
    const int s = i & 1, t = i >> 1 & 1, p = i >> 2 & 1, q = i >> 3 & 1;
    const double sign = (s + t + p + q) % 2 == 0 ? 1.0 : -1.0;
    if (parallel) {
      sum += sign * parallel_kernel(on_ends[s][a] - by_ends[t][a], on_ends[p][b] - by_ends[q][b],
                                    on.low[on.axis] - by.low[on.axis]);
    } else {
      sum += sign * perpendicular_kernel(on.low[a] - by_ends[s][a], on_ends[p][b] - by_ends[q][b],
                                         on_ends[t][by.axis] - by.low[by.axis]);
    }
  }
  return sum / (4.0 * pi);
}

// Quadrature points of a panel.
struct PanelPoints {
  Vec3 position[4];
  double area[4];
  Vec3 normal;

  explicit PanelPoints(const FlatPanel& panel) : normal(panel.normal) {
    const std::vector<PanelPoint> points = panel_points(panel, 2);
    for (int k = 0; k < 4; ++k) {
      position[k] = points[k].position;
      area[k] = points[k].share * panel.area;
    }
  }
};

// Quadrature points of eight panels, with one panel in each lane.
struct EightPanels {
  double position[4][3][n_lanes], area[4][n_lanes], normal[3][n_lanes];

  void set(int lane, const PanelPoints& from) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 4; ++k) position[k][axis][lane] = from.position[k][axis];
      normal[axis][lane] = from.normal[axis];
    }
    for (int k = 0; k < 4; ++k) area[k][lane] = from.area[k];
  }
};

template <class Lanes>
LOOMSTONE_INLINE Lanes in_lanes(double value) {
  return lanes_all<Lanes>(value);
}
template <class Lanes>
LOOMSTONE_INLINE Lanes in_lanes(const double* values) {
  return lanes_load<Lanes>(values);
}

// Computes by quadrature the fluxes through `on` that a unit charge density on `by` causes [m^2].
// Either `on` or `by` contains eight panels, and flux[l] is the flux through or from the panel in
// lane l.
template <class Lanes, class On, class By>
LOOMSTONE_INLINE void flux_by_points(const On& on, const By& by, double* flux) {
  Lanes sum{};
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) {
      Lanes r[3], normal[3];
      for (int axis = 0; axis < 3; ++axis) {
        r[axis] = in_lanes<Lanes>(on.position[i][axis]) - in_lanes<Lanes>(by.position[k][axis]);
        normal[axis] = in_lanes<Lanes>(on.normal[axis]);
      }
      const Lanes square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
      sum += in_lanes<Lanes>(on.area[i]) * in_lanes<Lanes>(by.area[k]) *
             (normal[0] * r[0] + normal[1] * r[1] + normal[2] * r[2]) /
             (square * lanes_sqrt(square));
    }
  }
  lanes_store(flux, sum / (4.0 * pi));
}

// Returns whether panels are so far apart that flux_by_points() is accurate.
bool far_apart(const FlatPanel& a, const FlatPanel& b) {
  const double reach = near * (a.reach + b.reach);
  return (a.centre - b.centre).squaredNorm() > reach * reach;
}

// Returns the matrix (1/chi + 1/2) diag(areas) - flux of the equation for the charge densities. If
// a net charge is possible, `whole` is the total area (otherwise 0), and the term
// +-areas areas^T / whole with the sign of chi is added. The left-hand sides of all equations then
// add up to (1/chi +- 1) times the net charge. This factor is never zero.
DenseMatrix equation(const DenseMatrix& flux, const Vector& areas, double susceptibility,
                     double whole) {
  DenseMatrix matrix = -flux;
  matrix.diagonal() += (1.0 / susceptibility + 0.5) * areas;
  if (whole > 0.0) matrix += std::copysign(1.0 / whole, susceptibility) * areas * areas.transpose();
  return matrix;
}

// Removes the quadrature error of the total flux, in proportion to the areas. The exact total flux
// of an applied field through a closed surface is zero.
Vector without_sum(const Vector& fluxes, const Vector& areas) {
  return fluxes - fluxes.sum() / areas.sum() * areas;
}

using Lu = Eigen::PartialPivLU<DenseMatrix>;

class CuboidBoundaryElements final : public BoundaryElements {
 public:
  CuboidBoundaryElements(const Team& team, const std::vector<FlatPanel>& panels)
      : n_(static_cast<Index>(panels.size()) / 8) {
    areas_.resize(n_);
    std::vector<Rectangle> rectangles;
    std::vector<PanelPoints> points;
    for (const FlatPanel& panel : panels) {
      rectangles.push_back(rectangle_of(panel));
      points.emplace_back(panel);
    }
    for (Index i = 0; i < n_; ++i) areas_[i] = panels[i].area;
    for (DenseMatrix& flux : flux_) flux.resize(n_, n_);
    parallel_for(
        team, n_,
        [&](Index k) {
          static_assert(n_lanes == 8, "a lane for a panel and for each of its mirror images");
          EightPanels images;
          for (int m = 0; m < n_lanes; ++m) images.set(m, points[k + m * n_]);
          for (Index i = 0; i < n_; ++i) {
            double flux[n_lanes];
            LOOMSTONE_WIDEST(flux_by_points)(points[i], images, flux);
            for (int m = 0; m < n_lanes; ++m) {
              const Index image = k + m * n_;
              if (image == i)
                flux[m] = 0.0;
              else if (!far_apart(panels[i], panels[image]))
                flux[m] = rectangle_flux(rectangles[i], rectangles[image]);
            }
            for (int symmetry = 0; symmetry < 8; ++symmetry) {
              double sum = 0.0;
              for (int m = 0; m < n_lanes; ++m) sum += sign(symmetry, m) * flux[m];
              flux_[symmetry](i, k) = sum;
            }
          }
        },
        4);
    // The diagonal absorbs the quadrature error, so that Gauss' law holds exactly.
    const Vector rest = 0.5 * areas_ - flux_[0].colwise().sum().transpose();
    for (DenseMatrix& flux : flux_) flux.diagonal() += rest;
  }

  std::unique_ptr<Factors> factor(double susceptibility) const override {
    auto factors = std::make_unique<Eighths>();
    factors->areas = areas_;
    for (int s = 0; s < 8; ++s)
      factors->lu[s].compute(
          equation(flux_[s], areas_, susceptibility, s == 0 ? areas_.sum() : 0.0));
    return factors;
  }

 private:
  // Returns the sign of the charge on a mirror image of a panel, relative to the charge on the
  // panel. The bits that are set in `mirror` are the axes along which the image is mirrored, and
  // those set in `symmetry` are the axes along which the charge is odd.
  static double sign(int symmetry, int mirror) {
    const int odd = symmetry & mirror;
    return ((odd & 1) + (odd >> 1 & 1) + (odd >> 2 & 1)) % 2 == 0 ? 1.0 : -1.0;
  }

  struct Eighths final : Factors {
    std::array<Lu, 8> lu;
    Vector areas;
    Vector solve(const Vector& fluxes) const override {
      const Index n = static_cast<Index>(fluxes.size()) / 8;
      Vector charges = Vector::Zero(fluxes.size());
      for (int s = 0; s < 8; ++s) {
        Vector right = Vector::Zero(n);
        for (int m = 0; m < 8; ++m) right += sign(s, m) * fluxes.segment(m * n, n);
        if (s == 0) right = without_sum(right, areas);
        const Vector part = lu[s].solve(right);
        for (int m = 0; m < 8; ++m) charges.segment(m * n, n) += sign(s, m) / 8.0 * part;
      }
      return charges;
    }
  };

  Index n_;
  Vector areas_;
  std::array<DenseMatrix, 8> flux_;
};

class MeshBoundaryElements final : public BoundaryElements {
 public:
  MeshBoundaryElements(const Team& team, const std::vector<FlatPanel>& panels) {
    const auto n = static_cast<Index>(panels.size());
    flux_.resize(n, n);
    areas_.resize(n);
    std::vector<PanelPoints> points(panels.begin(), panels.end());
    std::vector<EightPanels> eights((n + n_lanes - 1) / n_lanes);
    for (Index i = 0; i < n_lanes * static_cast<Index>(eights.size()); ++i)
      eights[i / n_lanes].set(i % n_lanes, points[std::min(i, n - 1)]);
    for (Index i = 0; i < n; ++i) areas_[i] = panels[i].area;
    parallel_for(
        team, n,
        [&](Index k) {
          const auto one = std::make_shared<const PanelSet>(std::vector{panels[k]}, 1);
          const ChargedPanels source(one, Vector::Ones(1));
          // On panels near panel k, 4 x 4 points are used, because the field has a logarithmic
          // singularity along a shared edge.
          std::vector<Index> beside;
          double flux[n_lanes];
          for (Index i = 0; i < n; ++i) {
            if (i % n_lanes == 0)
              LOOMSTONE_WIDEST(flux_by_points)(eights[i / n_lanes], points[k], flux);
            if (i != k && far_apart(panels[i], panels[k]))
              flux_(i, k) = flux[i % n_lanes];
            else if (i != k)
              beside.push_back(i);
          }
          flux_(k, k) = 0.0;
          for (const Index i : beside) {
            alignas(64) double x[48], h[48];
            const std::vector<PanelPoint> at = panel_points(panels[i], 4);
            for (int c = 0; c < 48; ++c) x[c] = at[c % 16].position[c / 16];
            source.field_block(x, 16, Quantity::mu0_field_strength, h);
            double sum = 0.0;
            for (int c = 0; c < 16; ++c)
              sum += at[c].share * panels[i].normal.dot(Vec3(h[c], h[16 + c], h[32 + c]));
            flux_(i, k) = sum * panels[i].area;
          }
          flux_(k, k) = 0.5 * areas_[k] - flux_.col(k).sum();
        },
        4);
  }

  std::unique_ptr<Factors> factor(double susceptibility) const override {
    auto factors = std::make_unique<Whole>();
    factors->areas = areas_;
    factors->lu.compute(equation(flux_, areas_, susceptibility, areas_.sum()));
    return factors;
  }

 private:
  struct Whole final : Factors {
    Lu lu;
    Vector areas;
    Vector solve(const Vector& fluxes) const override {
      return lu.solve(without_sum(fluxes, areas));
    }
  };

  Vector areas_;
  DenseMatrix flux_;
};

}  // namespace

std::unique_ptr<BoundaryElements> cuboid_boundary_elements(const Team& team,
                                                           const std::vector<FlatPanel>& panels) {
  return std::make_unique<CuboidBoundaryElements>(team, panels);
}

std::unique_ptr<BoundaryElements> mesh_boundary_elements(const Team& team,
                                                         const std::vector<FlatPanel>& panels) {
  return std::make_unique<MeshBoundaryElements>(team, panels);
}

}  // namespace loomstone
