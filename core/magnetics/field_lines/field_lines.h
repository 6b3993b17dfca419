// Field lines: curves along B, traced by an adaptive Runge-Kutta pair of order 5 and 4
// [Dormand1980] in the length of the curve, all lines abreast. They end where they enter a solid
// body, leave a ball, meet themselves, or the field vanishes.
#pragma once

#include <cstdint>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Why a line ends; a line that is followed one way begins at its seed.
enum class LineEnd : std::uint8_t { seed, body, left, closed, length, no_field };

// Description.
struct LineOptions {
  Vec3 uniform = Vec3::Zero();  // flux density besides that of the bodies [T]
  Vec3 centre = Vec3::Zero();   // of the ball that lines do not leave [m]
  double extent = 0.0;          // its radius [m]
  double tolerance = 1e-5;      // error of a step over the extent [1]
  double length = 0.0;          // where lines end at the latest [m]
};

// Where lines begin, and which way they go: 1 with the field, -1 against it, 0 both ways.
struct LineSeeds {
  Points points;
  std::vector<std::int8_t> way;
};

struct FieldLines {
  Points points;             // all lines end to end, each in the sense of B [m]
  std::vector<Index> first;  // (lines + 1) rows of `points`
  std::vector<LineEnd> begins, ends;
};

// Neighbouring points of a line turn by about a tenth [rad] at most. Throws InvalidInput.
FieldLines trace_field_lines(const Team& team, const std::vector<MagneticBody>& bodies,
                             const LineSeeds& seeds, const LineOptions& options);

// About `lines` seeds that stand for equal flux each: on the surface of solid bodies where it goes
// out, and on the discs that loops, solenoids and closed polylines span. Throws InvalidInput where
// there is none of these.
LineSeeds flux_seeds(const Team& team, const std::vector<MagneticBody>& bodies, const Vec3& uniform,
                     Index lines);

// The ball that holds all bodies: centre and radius [m].
std::pair<Vec3, double> bounding_ball(const std::vector<MagneticBody>& bodies);

// (n) depth of points below the surface of the solid magnet that holds them deepest, negative
// outside [m]; minus infinity without solid magnets.
Vector magnetic_depth(const std::vector<MagneticBody>& bodies, const ConstPointsRef& points);

}  // namespace loomstone
