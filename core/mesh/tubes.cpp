// Surfaces built from rings of vertices: capsule, cylinder, wavy bar and funnel. Adjacent rings are
// joined along the shorter diagonals. Every other ring is rotated by half a segment to improve the
// shapes of the triangles. The rings of the cylinder are not rotated, because it is a prism.
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/message.h"
#include "core/mesh/generators.h"
#include "core/mesh/mesh_builder.h"

namespace loomstone {
namespace {

// A circle of n vertices. The vertex at angle a is centre + radius (cos a up + sin a side). The
// tube runs along the cross product of `up` and `side`.
struct Ring {
  Vec3 centre, up, side;
  double radius;  // [m]
  Index n;
};

// Adds the vertices of a ring, rotated by half a segment if `turned`. Returns the index of the
// first of these vertices.
Index add_ring(MeshBuilder& builder, const Ring& ring, bool turned) {
  const Index first = static_cast<Index>(builder.vertices.size());
  for (Index k = 0; k < ring.n; ++k) {
    const double angle = 2.0 * M_PI * (k + (turned ? 0.5 : 0.0)) / ring.n;
    builder.add(Vec3(ring.centre +
                     ring.radius * (std::cos(angle) * ring.up + std::sin(angle) * ring.side)));
  }
  return first;
}

// Joins a ring of n_a vertices to the next ring of n_b vertices; a and b are the indices of their
// first vertices. Each new triangle gets the shorter of the two possible new edges.
void join_rings(MeshBuilder& builder, Index a, Index n_a, Index b, Index n_b) {
  const auto distance = [&](Index i, Index j) {
    return (builder.vertices[static_cast<std::size_t>(a + i % n_a)] -
            builder.vertices[static_cast<std::size_t>(b + j % n_b)])
        .squaredNorm();
  };
  for (Index i = 0, j = 0; i < n_a || j < n_b;) {
    const bool step_a = j == n_b || (i < n_a && distance(i + 1, j) <= distance(i, j + 1));
    if (step_a) {
      builder.add(a + i % n_a, a + (i + 1) % n_a, b + j % n_b);
      ++i;
    } else {
      builder.add(a + i % n_a, b + (j + 1) % n_b, b + j % n_b);
      ++j;
    }
  }
}

// Height of an equilateral triangle whose side is as long as a segment of the circle.
double row_height(double radius, Index segments) {
  return std::sqrt(0.75) * 2.0 * M_PI * radius / segments;
}

// Joins consecutive rings and closes the surface with a vertex at each end.
TriangleMesh joined(const std::vector<Ring>& rings, const Vec3& start, const Vec3& end,
                    bool turning) {
  MeshBuilder builder;
  const Index low = builder.add(start);
  std::vector<Index> first;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    first.push_back(add_ring(builder, rings[r], turning && r % 2 == 1));
    if (r > 0) join_rings(builder, first[r - 1], rings[r - 1].n, first[r], rings[r].n);
  }
  const Index high = builder.add(end);
  for (Index k = 0; k < rings.front().n; ++k)
    builder.add(low, first.front() + (k + 1) % rings.front().n, first.front() + k);
  for (Index k = 0; k < rings.back().n; ++k)
    builder.add(high, first.back() + k, first.back() + (k + 1) % rings.back().n);
  return builder.mesh();
}

// Closes a tube of equal rings with hemispheres, whose rings have fewer vertices towards the poles.
TriangleMesh capped(const std::vector<Ring>& tube) {
  const double radius = tube.front().radius;
  const Index segments = tube.front().n;
  const int n_cap =
      std::max(2, static_cast<int>(std::round(0.5 * M_PI * radius / row_height(radius, segments))));
  const auto cap_ring = [&](const Ring& end, int row, double sign) {
    const double angle = 0.5 * M_PI * row / n_cap;  // angle from the pole [rad]
    Ring ring = end;
    ring.centre += sign * radius * std::cos(angle) * end.up.cross(end.side);
    ring.radius = radius * std::sin(angle);
    ring.n = std::max<Index>(5, static_cast<Index>(std::round(segments * std::sin(angle))));
    return ring;
  };
  std::vector<Ring> rings;
  for (int row = 1; row < n_cap; ++row) rings.push_back(cap_ring(tube.front(), row, -1.0));
  rings.insert(rings.end(), tube.begin(), tube.end());
  for (int row = n_cap - 1; row > 0; --row) rings.push_back(cap_ring(tube.back(), row, 1.0));

  return joined(rings, tube.front().centre - radius * tube.front().up.cross(tube.front().side),
                tube.back().centre + radius * tube.back().up.cross(tube.back().side), true);
}

// A point of the profile of a surface of revolution about z.
struct ProfilePoint {
  double radius, z;
};

// Extends the profile by a straight line to `to`, inclusive, in steps of about `step`.
void line_to(std::vector<ProfilePoint>& profile, const ProfilePoint& to, double step) {
  const ProfilePoint from = profile.back();
  const int n = std::max(
      1, static_cast<int>(std::round(std::hypot(to.radius - from.radius, to.z - from.z) / step)));
  for (int i = 1; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    profile.push_back({(1.0 - s) * from.radius + s * to.radius, (1.0 - s) * from.z + s * to.z});
  }
}

// Extends the profile by a semicircle of radius `lip` about `centre`, counter-clockwise from
// `angle` (0 along +radius, pi/2 along +z), in steps of about `step`, but in 4 to 16 steps. The
// last new point is the end of the semicircle.
void lip_to(std::vector<ProfilePoint>& profile, const ProfilePoint& centre, double lip,
            double angle, double step) {
  const int n = std::clamp(static_cast<int>(std::round(M_PI * lip / step)), 4, 16);
  for (int i = 1; i <= n; ++i) {
    const double a = angle + M_PI * i / n;
    profile.push_back({centre.radius + lip * std::cos(a), centre.z + lip * std::sin(a)});
  }
}

}  // namespace

TriangleMesh capsule(double radius, double length, Index segments) {
  require_positive(radius, "radius");
  require_positive(length, "length");
  require_between(segments, 6, 4096, "segments");
  const int n_rows =
      std::max(1, static_cast<int>(std::round(length / row_height(radius, segments))));
  std::vector<Ring> tube;
  for (int i = 0; i <= n_rows; ++i) {
    const Vec3 centre(0.0, 0.0, length * (static_cast<double>(i) / n_rows - 0.5));
    tube.push_back({centre, Vec3::UnitX(), Vec3::UnitY(), radius, segments});
  }
  return capped(tube);
}

TriangleMesh cylinder(double radius, double length, Index segments) {
  require_positive(radius, "radius");
  require_positive(length, "length");
  require_between(segments, 3, 4096, "segments");
  const double side = 2.0 * M_PI * radius / segments;
  const int n_rows = std::max(1, static_cast<int>(std::round(length / side))),
            n_cap = std::max(1, static_cast<int>(std::round(radius / side)));
  const auto ring = [&](double z, int row) {  // rows are counted from the centre of the cap
    const double share = static_cast<double>(row) / n_cap;
    return Ring{Vec3(0.0, 0.0, z), Vec3::UnitX(), Vec3::UnitY(), share * radius,
                std::max<Index>(3, static_cast<Index>(std::round(share * segments)))};
  };
  std::vector<Ring> rings;
  for (int row = 1; row < n_cap; ++row) rings.push_back(ring(-0.5 * length, row));
  for (int i = 0; i <= n_rows; ++i)
    rings.push_back(ring(length * (static_cast<double>(i) / n_rows - 0.5), n_cap));
  for (int row = n_cap - 1; row > 0; --row) rings.push_back(ring(0.5 * length, row));
  return joined(rings, Vec3(0.0, 0.0, -0.5 * length), Vec3(0.0, 0.0, 0.5 * length), false);
}

TriangleMesh wave_bar(double length, double radius, double amplitude, double wavelength,
                      Index segments) {
  require_positive(length, "length");
  require_positive(radius, "radius");
  require_positive(wavelength, "wavelength");
  require_between(segments, 6, 4096, "segments");
  if (!(amplitude >= 0.0) || !std::isfinite(amplitude)) {
    fail<InvalidInput>(
        "amplitude must be >= 0 and finite [m], got {}; give half the height of the wave",
        amplitude);
  }
  const double k = 2.0 * M_PI / wavelength;
  if (!(radius * amplitude * k * k < 1.0)) {
    fail<InvalidInput>(
        "radius must be below the wave's smallest radius of curvature {:.6g} m, or the tube "
        "intersects itself; got {}; raise wavelength or lower amplitude or radius",
        1.0 / (amplitude * k * k), radius);
  }
  // The centre line is z = amplitude cos(k y). Rings are equally spaced along its arc length, which
  // is summed over small pieces.
  const int n_fine =
      64 * std::max(1, static_cast<int>(
                           std::ceil(length / std::min(row_height(radius, segments), wavelength))));
  const auto place = [&](int i) { return length * (static_cast<double>(i) / n_fine - 0.5); };
  std::vector<double> arc{0.0};
  for (int i = 0; i < n_fine; ++i) {
    const double rise = amplitude * (std::cos(k * place(i + 1)) - std::cos(k * place(i)));
    arc.push_back(arc.back() + std::hypot(place(i + 1) - place(i), rise));
  }
  const int n_rows =
      std::max(1, static_cast<int>(std::round(arc.back() / row_height(radius, segments))));
  std::vector<Ring> tube;
  for (int i = 0, fine = 1; i <= n_rows; ++i) {
    const double target = arc.back() * i / n_rows;
    while (fine < n_fine && arc[static_cast<std::size_t>(fine)] < target) ++fine;
    const double before = arc[static_cast<std::size_t>(fine) - 1],
                 after = arc[static_cast<std::size_t>(fine)];
    const double y = place(fine - 1) + (target - before) / (after - before) * length / n_fine;
    const Vec3 along = Vec3(0.0, 1.0, -amplitude * k * std::sin(k * y)).normalized();
    tube.push_back({Vec3(0.0, y, amplitude * std::cos(k * y)), Vec3::UnitX().cross(along),
                    Vec3::UnitX(), radius, segments});
  }
  return capped(tube);
}

TriangleMesh funnel(double top_radius, double bottom_radius, double height, double tube_length,
                    double wall, Index segments) {
  require_positive(top_radius, "top_radius");
  require_positive(bottom_radius, "bottom_radius");
  require_positive(height, "height");
  require_positive(tube_length, "tube_length");
  require_positive(wall, "wall");
  require_between(segments, 6, 4096, "segments");
  if (!(top_radius > bottom_radius)) {
    fail<InvalidInput>(
        "top_radius must be > bottom_radius = {} m, got {}; a funnel narrows downwards",
        bottom_radius, top_radius);
  }
  // The radii are those of the inner surface. The outer surface is the inner one shifted by the
  // wall thickness along its normal: outward and down at the cone, outward at the tube. The outer
  // surfaces of cone and tube meet in a mitre below the inner corner.
  const double slant = std::hypot(top_radius - bottom_radius, height);
  const double normal_r = height / slant, normal_z = -(top_radius - bottom_radius) / slant;
  const double turn = std::atan2(normal_z, normal_r);  // angle of the normal, in (-pi/2, 0) [rad]
  const double mitre = wall * std::tan(0.5 * turn);
  if (!(-mitre < tube_length)) {
    fail<InvalidInput>(
        "tube_length must be > {:.6g} m with this wall, got {}; raise tube_length or "
        "lower wall",
        -mitre, tube_length);
  }
  // The profile goes once around the wall, counter-clockwise in the (radius, z) plane: up the
  // outside, over the rim, down the inside and around the tube's lower end.
  const double step = row_height(0.5 * (top_radius + bottom_radius), segments), lip = 0.5 * wall;
  std::vector<ProfilePoint> profile{{bottom_radius + wall, -tube_length}};
  line_to(profile, {bottom_radius + wall, mitre}, step);
  line_to(profile, {top_radius + wall * normal_r, height + wall * normal_z}, step);
  lip_to(profile, {top_radius + lip * normal_r, height + lip * normal_z}, lip, turn, step);
  line_to(profile, {bottom_radius, 0.0}, step);
  line_to(profile, {bottom_radius, -tube_length}, step);
  lip_to(profile, {bottom_radius + lip, -tube_length}, lip, M_PI, step);
  profile.pop_back();  // the last point equals the first
  // Every other ring is rotated and the profile is closed, so the number of rings must be even.
  if (profile.size() % 2 == 1) {
    const ProfilePoint a = profile[0], b = profile[1];
    profile.insert(profile.begin() + 1, {0.5 * (a.radius + b.radius), 0.5 * (a.z + b.z)});
  }
  MeshBuilder builder;
  std::vector<Index> first;
  for (std::size_t r = 0; r < profile.size(); ++r) {
    const Ring ring{Vec3(0.0, 0.0, profile[r].z), Vec3::UnitX(), Vec3::UnitY(), profile[r].radius,
                    segments};
    first.push_back(add_ring(builder, ring, r % 2 == 1));
  }
  for (std::size_t r = 0; r < profile.size(); ++r) {
    join_rings(builder, first[r], segments, first[(r + 1) % profile.size()], segments);
  }
  return builder.mesh();
}

}  // namespace loomstone
