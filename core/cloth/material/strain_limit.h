// Strain limits of cloth and the options for enforcing them. Limits other than those of edges apply
// to the co-rotational strain U - I with U = (F^T F)^(1/2). The components of this strain in
// weft/warp axes are (e11, e22, e12). Shear limits bound e12, half the engineering shear at small
// strains; see (3.3) of [Thomaszewski2010].
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/choice.h"
#include "core/base/field.h"

namespace loomstone {

struct StrainLimit {
  double weft = std::numeric_limits<double>::infinity();
  double warp = std::numeric_limits<double>::infinity();
  double shear = std::numeric_limits<double>::infinity();
  double weft_min = -1.0;
  double warp_min = -1.0;
  std::optional<double> shear_min;
  std::optional<double> edge;

  static auto fields() {
    using L = StrainLimit;
    constexpr Limits most{0.0, std::numeric_limits<double>::infinity(), false, true};
    return std::make_tuple(
        field("weft", &L::weft, "1", most, "largest strain along weft"),
        field("warp", &L::warp, "1", most, "largest strain along warp"),
        field("shear", &L::shear, "1", most,
              "largest shear strain e12 (half the engineering shear at small strains)"),
        field("weft_min", &L::weft_min, "1", between(-1.0, 0.0),
              "smallest strain along weft; -1: unlimited compression"),
        field("warp_min", &L::warp_min, "1", between(-1.0, 0.0),
              "smallest strain along warp; -1: unlimited compression"),
        field("shear_min", &L::shear_min, "1",
              Limits{-std::numeric_limits<double>::infinity(), 0.0, false, true},
              "smallest shear strain e12; None: -shear"),
        field("edge", &L::edge, "1", non_negative(),
              "largest elongation of an edge; if given, the edges of this cloth are limited with "
              "every method; None: with the method edges, the smaller of weft and warp"));
  }
  double least_shear() const { return shear_min.value_or(-shear); }
  double edge_bound() const { return edge.value_or(weft < warp ? weft : warp); }
};

// Returns the excess [1] that is tolerated where contacts and limits conflict: 20 % of the limit,
// but at most 0.01 and at least 1e-4. The stiff second phase of the implicit solve begins at this
// distance inside the limit.
inline double limit_margin(double limit) {
  return std::max(1e-4, std::min(0.01, 0.2 * std::abs(limit)));
}

enum class LimitMethod { GaussSeidel, GaussSeidelRandom, Jacobi, Edges };
constexpr auto choices(LimitMethod) {
  using M = LimitMethod;
  return std::array{ChoiceName{M::GaussSeidel, "gauss-seidel", "coloured, parallel"},
                    ChoiceName{M::GaussSeidelRandom, "gauss-seidel-random",
                               "random order of a given seed, one thread"},
                    ChoiceName{M::Jacobi, "jacobi"},
                    ChoiceName{M::Edges, "edges", "along edges, one bound for all directions"}};
}

struct LimitOptions {
  LimitMethod method = LimitMethod::GaussSeidel;
  double tolerance = 0.002;
  int max_sweeps = 100;
  bool active_set = true;
  bool in_solve = true;
  double strain_rate = 0.1;
  int seed = 1;

  static auto fields() {
    using O = LimitOptions;
    return std::make_tuple(
        field("method", &O::method, "method of correction"),
        field("tolerance", &O::tolerance, "1", positive(),
              "excess that sweeps leave uncorrected; a tenth of the limit for limits below 0.02"),
        field("max_sweeps", &O::max_sweeps, "1", between(1, 1e6),
              "largest number of sweeps over the elements per step; the remaining excess is "
              "reported"),
        field(
            "active_set", &O::active_set,
            "whether sweeps after the first evaluate only corrected elements and their neighbours"),
        field("in_solve", &O::in_solve,
              "whether implicit integrators stiffen the membrane near its limits (limit phase), so "
              "that sweeps have little to correct; not with the method edges"),
        field("strain_rate", &O::strain_rate, "1", non_negative(),
              "largest change of strain per step that velocities may cause; 0: no limit"),
        field("seed", &O::seed, "1", between(0, 2147483647), "seed of the random order"));
  }
};

}  // namespace loomstone
