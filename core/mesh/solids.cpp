// Closed surfaces, facing outward. Spheres subdivide an icosahedron; everything else is rings of vertices joined row by
// row, with each ring turned by half a segment so that triangles stay near equilateral.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/generators.h"

namespace loomstone {
namespace {

void require_positive(double value, const char* name) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InvalidInput(std::string(name) + " must be > 0 and finite [m], got " + std::to_string(value) +
                       "; give a length in metres");
  }
}

void require_between(Index count, Index low, Index high, const char* name) {
  if (count < low || count > high) {
    throw InvalidInput(std::string(name) + " must be " + std::to_string(low) + " to " + std::to_string(high) + ", got " +
                       std::to_string(count) + "; choose another number");
  }
}

// Growing arrays of a mesh under construction.
struct Builder {
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 3>> triangles;

  Index add(const Vec3& vertex) {
    vertices.push_back(vertex);
    return static_cast<Index>(vertices.size()) - 1;
  }
  void add(Index a, Index b, Index c) { triangles.push_back({a, b, c}); }

  TriangleMesh mesh() const {
    Points points(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t i = 0; i < vertices.size(); ++i) points.row(static_cast<Eigen::Index>(i)) = vertices[i].transpose();
    Triangles faces(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      faces.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
    }
    return TriangleMesh(std::move(points), std::move(faces));
  }
};

// Joins two rings of n vertices, the second turned by half a segment if `turned`, else the first. Faces look outward when
// the rings run counter-clockwise seen from the side the second one lies on.
void join_rings(Builder& builder, Index first, Index second, Index n, bool turned) {
  for (Index k = 0; k < n; ++k) {
    const Index next = (k + 1) % n;
    if (turned) {
      builder.add(first + k, first + next, second + k);
      builder.add(first + next, second + next, second + k);
    } else {
      builder.add(first + k, second + next, second + k);
      builder.add(first + k, first + next, second + next);
    }
  }
}

// A profile point of a surface of revolution about z.
struct ProfilePoint {
  double radius, z;
};

// One ring of vertices, alternate rings turned by half a segment.
Index add_ring(Builder& builder, const ProfilePoint& point, Index n, bool turned) {
  const Index first = static_cast<Index>(builder.vertices.size());
  for (Index k = 0; k < n; ++k) {
    const double angle = 2.0 * M_PI * (k + (turned ? 0.5 : 0.0)) / n;
    builder.add(Vec3(point.radius * std::cos(angle), point.radius * std::sin(angle), point.z));
  }
  return first;
}

// Adds the points from the profile's end to `to` in steps of about `step`, `to` included.
void line_to(std::vector<ProfilePoint>& profile, const ProfilePoint& to, double step) {
  const ProfilePoint from = profile.back();
  const int n = std::max(1, static_cast<int>(std::round(std::hypot(to.radius - from.radius, to.z - from.z) / step)));
  for (int i = 1; i <= n; ++i) {
    const double s = static_cast<double>(i) / n;
    profile.push_back({(1.0 - s) * from.radius + s * to.radius, (1.0 - s) * from.z + s * to.z});
  }
}

// Adds an arc about `centre` from angle `from` to `to` (angle 0 along +radius, a quarter turn along +z), end included.
void arc_to(std::vector<ProfilePoint>& profile, const ProfilePoint& centre, double radius, double from, double to, int n) {
  for (int i = 1; i <= n; ++i) {
    const double angle = from + (to - from) * i / n;
    profile.push_back({centre.radius + radius * std::cos(angle), centre.z + radius * std::sin(angle)});
  }
}

}  // namespace

TriangleMesh icosphere(double radius, int subdivisions) {
  require_positive(radius, "radius");
  require_between(subdivisions, 0, 8, "subdivisions");
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  Builder builder;
  for (const Vec3& v : {Vec3(-1, g, 0), Vec3(1, g, 0), Vec3(-1, -g, 0), Vec3(1, -g, 0), Vec3(0, -1, g), Vec3(0, 1, g),
                        Vec3(0, -1, -g), Vec3(0, 1, -g), Vec3(g, 0, -1), Vec3(g, 0, 1), Vec3(-g, 0, -1), Vec3(-g, 0, 1)}) {
    builder.add(Vec3(v.normalized()));
  }
  builder.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                       {3, 8, 9},  {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<Index>(builder.vertices.size()));
      if (fresh) {
        builder.add(Vec3((builder.vertices[static_cast<std::size_t>(a)] + builder.vertices[static_cast<std::size_t>(b)])
                             .normalized()));
      }
      return entry->second;
    };
    const std::vector<std::array<Index, 3>> coarse = std::exchange(builder.triangles, {});
    for (const auto& [a, b, c] : coarse) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      builder.add(a, ab, ca);
      builder.add(b, bc, ab);
      builder.add(c, ca, bc);
      builder.add(ab, bc, ca);
    }
  }
  for (Vec3& vertex : builder.vertices) vertex *= radius;
  return builder.mesh();
}

TriangleMesh box(double x, double y, double z, Index cells_per_side) {
  require_positive(x, "x");
  require_positive(y, "y");
  require_positive(z, "z");
  require_between(cells_per_side, 1, 1000, "cells_per_side");
  const Index n = cells_per_side;
  Builder builder;
  std::map<std::array<Index, 3>, Index> known;  // lattice point -> vertex: sides share those on edges
  const auto vertex = [&](const std::array<Index, 3>& at) {
    const auto [entry, fresh] = known.try_emplace(at, static_cast<Index>(builder.vertices.size()));
    if (fresh) {
      builder.add(Vec3(x * (static_cast<double>(at[0]) / n - 0.5), y * (static_cast<double>(at[1]) / n - 0.5),
                       z * (static_cast<double>(at[2]) / n - 0.5)));
    }
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (int top = 0; top < 2; ++top) {
      // On the top side (axis, first, second) is right-handed; below, the two are exchanged.
      const int first = (axis + (top ? 1 : 2)) % 3, second = (axis + (top ? 2 : 1)) % 3;
      for (Index j = 0; j < n; ++j) {
        for (Index i = 0; i < n; ++i) {
          const auto corner = [&](Index di, Index dj) {
            std::array<Index, 3> at{};
            at[static_cast<std::size_t>(axis)] = top ? n : 0;
            at[static_cast<std::size_t>(first)] = i + di;
            at[static_cast<std::size_t>(second)] = j + dj;
            return vertex(at);
          };
          const Index a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          if ((i + j) % 2 == 0) {
            builder.add(a, b, c);
            builder.add(a, c, d);
          } else {
            builder.add(a, b, d);
            builder.add(b, c, d);
          }
        }
      }
    }
  }
  return builder.mesh();
}

TriangleMesh capsule(double radius, double length, Index segments) {
  require_positive(radius, "radius");
  require_positive(length, "length");
  require_between(segments, 6, 4096, "segments");
  // Caps are halves of a sphere made of rings; towards a pole a ring has fewer vertices, so triangles keep their shape.
  const double side = 2.0 * M_PI * radius / segments, row = side * std::sqrt(0.75);
  const int n_cap = std::max(2, static_cast<int>(std::round(0.5 * M_PI * radius / row)));
  const int n_tube = std::max(1, static_cast<int>(std::round(length / row)));
  struct Ring {
    ProfilePoint point;
    Index n;
  };
  std::vector<Ring> rings;
  const auto on_ring = [&](double r) { return std::max<Index>(5, static_cast<Index>(std::round(segments * r / radius))); };
  for (int i = 1; i < n_cap; ++i) {
    const double angle = 0.5 * M_PI * i / n_cap;
    rings.push_back({{radius * std::sin(angle), -0.5 * length - radius * std::cos(angle)}, on_ring(radius * std::sin(angle))});
  }
  for (int i = 0; i <= n_tube; ++i) rings.push_back({{radius, length * (static_cast<double>(i) / n_tube - 0.5)}, segments});
  for (int i = n_cap - 1; i > 0; --i) {
    const double angle = 0.5 * M_PI * i / n_cap;
    rings.push_back({{radius * std::sin(angle), 0.5 * length + radius * std::cos(angle)}, on_ring(radius * std::sin(angle))});
  }
  Builder builder;
  const Index bottom = builder.add(Vec3(0.0, 0.0, -0.5 * length - radius));
  Index previous = 0;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Index n = rings[r].n;
    const Index first = add_ring(builder, rings[r].point, n, r % 2 == 1);
    if (r == 0) {
      for (Index k = 0; k < n; ++k) builder.add(bottom, first + (k + 1) % n, first + k);
    } else if (rings[r - 1].n == n) {
      join_rings(builder, previous, first, n, r % 2 == 1);
    } else {
      // Walk both rings by angle, always stepping where the next vertex comes first.
      const Index m = rings[r - 1].n;
      const double turn_low = r % 2 == 0 ? 0.5 : 0.0, turn_high = r % 2 == 1 ? 0.5 : 0.0;
      for (Index low = 0, high = 0; low < m || high < n;) {
        const double next_low = (low + 1 + turn_low) / m, next_high = (high + 1 + turn_high) / n;
        if (high == n || (low < m && next_low <= next_high)) {
          builder.add(previous + low % m, previous + (low + 1) % m, first + high % n);
          ++low;
        } else {
          builder.add(previous + low % m, first + (high + 1) % n, first + high % n);
          ++high;
        }
      }
    }
    previous = first;
  }
  const Index top = builder.add(Vec3(0.0, 0.0, 0.5 * length + radius));
  const Index n = rings.back().n;
  for (Index k = 0; k < n; ++k) builder.add(previous + k, previous + (k + 1) % n, top);
  return builder.mesh();
}

TriangleMesh funnel(double top_radius, double bottom_radius, double height, double tube_length, double wall,
                    Index segments) {
  require_positive(top_radius, "top_radius");
  require_positive(bottom_radius, "bottom_radius");
  require_positive(height, "height");
  require_positive(tube_length, "tube_length");
  require_positive(wall, "wall");
  require_between(segments, 6, 4096, "segments");
  if (!(top_radius > bottom_radius)) {
    throw InvalidInput("top_radius must be > bottom_radius = " + std::to_string(bottom_radius) + ", got " +
                       std::to_string(top_radius) + "; a funnel narrows downwards");
  }
  // Radii are those of the inner wall. The outer wall is the inner one shifted by the thickness along the normals: down and
  // out along the cone, outward along the tube; both rims are half circles.
  const double slant = std::hypot(top_radius - bottom_radius, height);
  const double nr = height / slant, nz = -(top_radius - bottom_radius) / slant;  // from inside to outside of the cone
  const double cone_turn = std::atan2(nz, nr);                                   // its angle, in (-pi/2, 0)
  // Where the outer cone meets the outer tube: the mitre of the two shifted lines.
  const double mitre = wall * std::tan(0.5 * cone_turn);
  const double step = std::sqrt(0.75) * 2.0 * M_PI * 0.5 * (top_radius + bottom_radius) / segments;
  const double lip = 0.5 * wall;
  constexpr int n_lip = 6;  // segments of a half circle
  // Once around, counter-clockwise in the (radius, z) plane seen with the material on the left: up the outer wall, over the
  // rim, down the inner wall, under the tube's end.
  std::vector<ProfilePoint> profile{{bottom_radius + wall, -tube_length}};
  line_to(profile, {bottom_radius + wall, mitre}, step);
  line_to(profile, {top_radius + wall * nr, height + wall * nz}, step);
  arc_to(profile, {top_radius + lip * nr, height + lip * nz}, lip, cone_turn, cone_turn + M_PI, n_lip);
  line_to(profile, {bottom_radius, 0.0}, step);
  line_to(profile, {bottom_radius, -tube_length}, step);
  arc_to(profile, {bottom_radius + lip, -tube_length}, lip, M_PI, 2.0 * M_PI, n_lip);
  profile.pop_back();  // the end is the beginning
  if (profile.size() % 2 == 1) {  // rings are turned alternately all the way round: an even number of them
    const ProfilePoint a = profile[0], b = profile[1];
    profile.insert(profile.begin() + 1, {0.5 * (a.radius + b.radius), 0.5 * (a.z + b.z)});
  }
  Builder builder;
  std::vector<Index> first;
  for (std::size_t r = 0; r < profile.size(); ++r) first.push_back(add_ring(builder, profile[r], segments, r % 2 == 1));
  for (std::size_t r = 0; r < profile.size(); ++r) {
    const std::size_t next = (r + 1) % profile.size();
    join_rings(builder, first[r], first[next], segments, next % 2 == 1);
  }
  return builder.mesh();
}

TriangleMesh wave_bar(double length, double radius, double amplitude, double wavelength, Index segments) {
  require_positive(length, "length");
  require_positive(radius, "radius");
  require_positive(wavelength, "wavelength");
  require_between(segments, 6, 4096, "segments");
  if (!(amplitude >= 0.0) || !std::isfinite(amplitude)) {
    throw InvalidInput("amplitude must be >= 0 and finite [m], got " + std::to_string(amplitude) +
                       "; give half the height of the wave");
  }
  const double k = 2.0 * M_PI / wavelength;
  if (!(radius * amplitude * k * k < 1.0)) {
    throw InvalidInput("radius must be below the wave's smallest radius of curvature " +
                       std::to_string(1.0 / (amplitude * k * k)) + " [m], got " + std::to_string(radius) +
                       "; the tube would cut itself: take a longer or lower wave");
  }
  // Centre line z = amplitude cos(k y), sampled at equal arc length; rings normal to it. A hemisphere closes each end.
  const double row = std::sqrt(0.75) * 2.0 * M_PI * radius / segments;
  const int fine = 64 * std::max(1, static_cast<int>(std::ceil(length / std::min(row, wavelength))));
  std::vector<double> arc(static_cast<std::size_t>(fine) + 1, 0.0);
  const auto place = [&](int i) { return length * (static_cast<double>(i) / fine - 0.5); };
  for (int i = 0; i < fine; ++i) {
    arc[static_cast<std::size_t>(i) + 1] = arc[static_cast<std::size_t>(i)] +
        std::hypot(place(i + 1) - place(i), amplitude * (std::cos(k * place(i + 1)) - std::cos(k * place(i))));
  }
  const int n_rows = std::max(1, static_cast<int>(std::round(arc.back() / row)));
  const int n_cap = std::max(2, static_cast<int>(std::round(0.5 * M_PI * radius / row)));
  struct Section {
    double y, advance, radius;  // along the axis [m]; beyond the end along the tangent [m]
  };
  std::vector<Section> sections;
  for (int i = 1; i < n_cap; ++i) {
    const double angle = 0.5 * M_PI * i / n_cap;
    sections.push_back({-0.5 * length, -radius * std::cos(angle), radius * std::sin(angle)});
  }
  for (int i = 0; i <= n_rows; ++i) {
    const double target = arc.back() * i / n_rows;
    const std::size_t after = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(std::lower_bound(arc.begin(), arc.end(), target) - arc.begin(), 1, fine));
    const double share = (target - arc[after - 1]) / (arc[after] - arc[after - 1]);
    sections.push_back({place(static_cast<int>(after) - 1) + share * length / fine, 0.0, radius});
  }
  for (int i = n_cap - 1; i > 0; --i) {
    const double angle = 0.5 * M_PI * i / n_cap;
    sections.push_back({0.5 * length, radius * std::cos(angle), radius * std::sin(angle)});
  }
  const auto centre = [&](double y) { return Vec3(0.0, y, amplitude * std::cos(k * y)); };
  const auto tangent = [&](double y) { return Vec3(0.0, 1.0, -amplitude * k * std::sin(k * y)).normalized(); };
  Builder builder;
  const Index start = builder.add(Vec3(centre(-0.5 * length) - radius * tangent(-0.5 * length)));
  std::vector<Index> first;
  for (std::size_t r = 0; r < sections.size(); ++r) {
    const Vec3 along = tangent(sections[r].y), middle = centre(sections[r].y) + sections[r].advance * along;
    const Vec3 up = Vec3::UnitX().cross(along);  // (up, x, along) is right-handed
    first.push_back(static_cast<Index>(builder.vertices.size()));
    for (Index s = 0; s < segments; ++s) {
      const double angle = 2.0 * M_PI * (s + (r % 2 == 1 ? 0.5 : 0.0)) / segments;
      builder.add(Vec3(middle + sections[r].radius * (std::cos(angle) * up + std::sin(angle) * Vec3::UnitX())));
    }
    if (r > 0) join_rings(builder, first[r - 1], first[r], segments, r % 2 == 1);
  }
  const Index end = builder.add(Vec3(centre(0.5 * length) + radius * tangent(0.5 * length)));
  for (Index s = 0; s < segments; ++s) {
    const Index next = (s + 1) % segments;
    builder.add(start, first.front() + next, first.front() + s);
    builder.add(end, first.back() + s, first.back() + next);
  }
  return builder.mesh();
}

}  // namespace loomstone
