#include "core/magnetics/induction/mutual_inductance.h"

#include <cmath>

#include "core/base/error.h"
#include "core/base/simd.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/gauss.h"

namespace loomstone {

namespace {

// Number of levels of refinement. Each level doubles the number of points around the winding and,
// for a solenoid, along its length. The first level has 16 points around the winding, and the last
// has 512.
constexpr int finest = 6;

// A winding about its own z axis, with turns in |z| <= length / 2.
struct Winding {
  const Source* source;
  double radius, length;
  double current;  // total current of all turns [A]
};

Winding winding_of(const MagneticBody& body) {
  const std::optional<CircularWinding> w = body.source->winding();
  if (!w)
    throw InvalidInput("only loops and solenoids have a mutual inductance, got another source");
  const double current = w->length > 0.0 ? w->current * w->length : w->current;
  return {body.source.get(), w->radius, w->length, current};
}

struct Linkage {
  double flux = 0.0, size = 0.0;
};

// Winding along which the vector potential of the other winding is integrated. `pose` is given in
// the axes of the other winding, and `rotation` is the matrix of its orientation.
struct Path {
  const Winding& winding;
  RigidPose pose;
  Mat3 rotation;
};

// Integrates the tangential component of the vector potential of `by`, and the norm of this
// potential, along the circle of the path at the height z. Adds both integrals, times the current
// that the circle represents, to `sum`. The circle is divided into `around` equal arcs, and the
// potential is evaluated at the middle of each arc. `share` is the length of an arc times the
// current that the circle represents [A m].
void add_circle(const Path& path, double z, int around, double share, const Source& by,
                Linkage& sum) {
  alignas(64) double x[3 * points_per_block], a[3 * points_per_block];
  Vec3 tangents[points_per_block];
  const double radius = path.winding.radius;
  for (int begin = 0; begin < around; begin += points_per_block) {
    const int n = std::min(around - begin, static_cast<int>(points_per_block));
    for (int i = 0; i < n; ++i) {
      const double turn = 2.0 * pi * (begin + i + 0.5) / around, c = std::cos(turn),
                   s = std::sin(turn);
      const Vec3 at = path.pose.position + path.rotation * Vec3(radius * c, radius * s, z);
      tangents[i] = path.rotation * Vec3(-s, c, 0.0);
      for (int k = 0; k < 3; ++k) x[k * n + i] = at[k];
    }
    by.vector_potential_block(x, n, a);
    for (int i = 0; i < n; ++i) {
      const Vec3 potential(a[i], a[n + i], a[2 * n + i]);
      sum.flux += share * potential.dot(tangents[i]);
      sum.size += share * potential.norm();
    }
  }
}

// Returns the integrals of the vector potential of `by` and of its norm along the winding `on`,
// times the current of `on`. The winding is represented by circles: its length is divided into
// `parts` sections, and each section has circles at 8 Gauss points. A loop is a single circle.
Linkage linkage(const Winding& on, const RigidPose& pose, const Winding& by, int around,
                int parts) {
  const Path path{on, pose, rotation_matrix(pose.orientation)};
  const GaussRule& rule = gauss_rule(on.length > 0.0 ? 8 : 1);
  if (on.length == 0.0) parts = 1;
  Linkage sum;
  for (int part = 0; part < parts; ++part) {
    for (int node = 0; node < rule.n; ++node) {
      const double z = on.length * ((part + 0.5 * (1.0 + rule.nodes[node])) / parts - 0.5);
      const double share =
          0.5 * rule.weights[node] / parts * on.current * 2.0 * pi * on.radius / around;
      add_circle(path, z, around, share, *by.source, sum);
    }
  }
  return sum;
}

// Returns whether two loops coincide, up to rounding errors: 1e-7 of the radius for radii and
// centres, and 1e-7 rad for axes.
bool coincide(const Winding& a, const Winding& b, const RigidPose& between) {
  const double near = 1e-7 * a.radius;
  const Vec3 axis = rotation_matrix(between.orientation).col(2);
  return a.length == 0.0 && b.length == 0.0 && std::abs(a.radius - b.radius) < near &&
         between.position.norm() < near && axis.head<2>().norm() < 1e-7;
}

}  // namespace

double mutual_inductance(const MagneticBody& a, const MagneticBody& b, double tolerance) {
  const Winding wa = winding_of(a), wb = winding_of(b);
  // The potential is integrated along the shorter winding. Loops have the length 0. If both lengths
  // are equal, the potential is integrated along the winding with the smaller radius.
  const bool along_a = wa.length != wb.length ? wa.length < wb.length : wa.radius <= wb.radius;
  const MagneticBody &on = along_a ? a : b, &by = along_a ? b : a;
  const RigidPose pose = relative_pose(on.pose, by.pose);
  if (coincide(wa, wb, pose))
    throw InvalidInput(
        "the inductance of a loop of infinitely thin wire with itself is infinite; use two loops "
        "at different places, or a solenoid");
  Linkage before;
  for (int level = 0; level < finest; ++level) {
    const Linkage now =
        linkage(along_a ? wa : wb, pose, along_a ? wb : wa, 16 << level, 1 << level);
    if (level > 0 && std::abs(now.flux - before.flux) <= tolerance * now.size) return now.flux;
    before = now;
  }
  return before.flux;
}

}  // namespace loomstone
