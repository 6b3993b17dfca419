// Field lines, the curves along B, parametrised by arc length. All lines are integrated at once by
// an adaptive Runge-Kutta pair of orders 5 and 4 [Dormand1980]. A line ends where it enters a solid
// body, leaves a bounding sphere, returns to its seed, reaches its maximum length, or where the
// field vanishes.
#pragma once

#include <cstdint>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Reason why a line begins or ends at a point. A line that is traced only along the field begins at
// its `seed`, and a line that is traced only against the field ends there. The other reasons apply
// in the direction of tracing. `body`: the line enters a solid body, or the thin layer around a
// body with charged panels. `left`: it leaves the sphere of LineOptions. `closed`: it returns to
// its seed. `length`: it reaches its maximum length or the largest number of steps. `no_field`: the
// field vanishes or is not finite, the step becomes too small or the line hardly moves.
enum class LineEnd : std::uint8_t { seed, body, left, closed, length, no_field };

// Options of trace_field_lines().
struct LineOptions {
  Vec3 uniform = Vec3::Zero();  // flux density added to that of the bodies [T]
  // Centre and radius of the sphere at which lines end [m]. If `extent` is 0, the sphere has the
  // centre of bounding_ball() and four times its radius.
  Vec3 centre = Vec3::Zero();
  double extent = 0.0;
  // Tolerated error of a step, as a fraction of the radius of the sphere at which lines end [1].
  double tolerance = 1e-5;
  // Maximum length of a line in each direction [m]; 0: 20 times the radius of the sphere at which
  // lines end.
  double length = 0.0;
};

// Starting points of lines (n x 3) [m], and the directions in which they are traced: 1 along the
// field, -1 against it, 0 both.
struct LineSeeds {
  Points points;
  std::vector<std::int8_t> way;
};

struct FieldLines {
  Points points;  // points of all lines, line by line in the direction of B [m]
  // (lines + 1) First row of each line in `points`, followed by the number of rows.
  std::vector<Index> first;
  std::vector<LineEnd> begins, ends;
};

// Traces lines from the seeds. The tangent turns by at most about 0.1 rad between neighbouring
// points, except where a line crosses a surface. Throws InvalidInput if a seed is not finite, if an
// option is not finite or out of range, or if `extent` is 0 and the bodies have no extent.
FieldLines trace_field_lines(const Team& team, const std::vector<MagneticBody>& bodies,
                             const LineSeeds& seeds, const LineOptions& options);

// Returns `lines` seeds that each represent the same flux. They lie where flux leaves the surfaces
// of solid bodies, on discs inside loops and solenoids, and on surfaces bounded by closed
// polylines. Lines from solid bodies are traced along the field, other lines in both directions.
// Throws InvalidInput if `lines` < 1, if there are no such surfaces or discs, or if no flux passes
// through them.
LineSeeds flux_seeds(const Team& team, const std::vector<MagneticBody>& bodies, const Vec3& uniform,
                     Index lines);

// Returns the centre and radius [m] of a bounding sphere of all bodies. Both are zero if there are
// no bodies.
std::pair<Vec3, double> bounding_ball(const std::vector<MagneticBody>& bodies);

// Returns the depth (n) of each point below the surfaces of solid bodies [m]: the largest over
// these bodies, negative outside all of them, minus infinity if there are none.
Vector magnetic_depth(const std::vector<MagneticBody>& bodies, const ConstPointsRef& points);

}  // namespace loomstone
