// Field lines: curves along B, parametrised by arc length and integrated by an adaptive Runge-Kutta
// pair of orders 5 and 4 [Dormand1980], all lines at once. A line ends where it enters a solid
// body, leaves a ball, returns to its start, or reaches its greatest length, and where the field
// vanishes.
#pragma once

#include <cstdint>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Why a line ends. A line that is traced one way only begins at its seed.
enum class LineEnd : std::uint8_t { seed, body, left, closed, length, no_field };

// Description.
struct LineOptions {
  Vec3 uniform = Vec3::Zero();  // flux density added to that of the bodies [T]
  Vec3 centre = Vec3::Zero();   // centre of the ball that bounds the lines [m]
  double extent = 0.0;          // its radius [m]; 0: four times the radius of the bodies
  double tolerance = 1e-5;      // error of a step divided by the extent [1]
  double length = 0.0;          // greatest length of a line [m]; 0: 20 extents
};

// Where lines begin, and the way they are traced: 1 with the field, -1 against it, 0 both ways.
struct LineSeeds {
  Points points;
  std::vector<std::int8_t> way;
};

struct FieldLines {
  Points points;             // of all lines, line by line in the direction of B [m]
  std::vector<Index> first;  // (lines + 1) first row of each line in `points`, and the end
  std::vector<LineEnd> begins, ends;
};

// Between neighbouring points a line turns by about 0.1 rad at most. Throws InvalidInput.
FieldLines trace_field_lines(const Team& team, const std::vector<MagneticBody>& bodies,
                             const LineSeeds& seeds, const LineOptions& options);

// `lines` seeds that represent equal flux each, on the surfaces of solid bodies where flux leaves
// them and on the discs that loops, solenoids and closed polylines span. Throws InvalidInput if
// there are no such bodies.
LineSeeds flux_seeds(const Team& team, const std::vector<MagneticBody>& bodies, const Vec3& uniform,
                     Index lines);

// A bounding ball of all bodies: centre and radius [m].
std::pair<Vec3, double> bounding_ball(const std::vector<MagneticBody>& bodies);

// (n) depth of points below the surface of solid magnets [m], the largest over all magnets;
// negative outside, minus infinity without solid magnets.
Vector magnetic_depth(const std::vector<MagneticBody>& bodies, const ConstPointsRef& points);

}  // namespace loomstone
