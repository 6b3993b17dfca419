#include "core/magnetics/sources/flat_panels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>

#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/gauss.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

Vec3 FlatPanel::at(double u, double v) const {
  if (corners == 3)
    return corner[0] + u * (corner[1] - corner[0]) + u * v * (corner[2] - corner[1]);
  return corner[0] + u * (corner[1] - corner[0]) + v * (corner[3] - corner[0]);
}

FlatPanel make_panel(const Vec3* corners, int n) {
  FlatPanel p;
  p.corners = n;
  p.centre.setZero();
  for (int k = 0; k < n; ++k) {
    p.corner[k] = corners[k];
    p.centre += corners[k] / n;
  }
  const Vec3 area = n == 3 ? Vec3(0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]))
                           : Vec3((corners[1] - corners[0]).cross(corners[3] - corners[0]));
  p.area = area.norm();
  p.normal = area / p.area;
  for (int k = 0; k < n; ++k) p.reach = std::max(p.reach, (corners[k] - p.centre).norm());
  return p;
}

std::vector<PanelPoint> panel_points(const FlatPanel& panel, int order) {
  const GaussRule& rule = gauss_rule(order);
  std::vector<PanelPoint> points;
  for (int i = 0; i < order; ++i) {
    const double u = 0.5 * (1.0 + rule.nodes[i]);
    for (int k = 0; k < order; ++k) {
      const double v = 0.5 * (1.0 + rule.nodes[k]),
                   weight = 0.25 * rule.weights[i] * rule.weights[k];
      points.push_back({panel.at(u, v), panel.corners == 3 ? 2.0 * u * weight : weight});
    }
  }
  // Normalisation removes rounding errors, so that the shares add up to 1.
  double total = 0.0;
  for (const PanelPoint& point : points) total += point.share;
  for (PanelPoint& point : points) point.share /= total;
  return points;
}

// Grades half an edge. Returns the position s between the middle (0) and the end (1) below which a
// fraction t of the cells lies. The number of cells below s is proportional to 1 - sqrt(1 - s),
// which refines the end. `width` is the focus of cuboid_panels() in units of half the edge. If it
// is not 0, asinh(s / width) is added to 1 - sqrt(1 - s), which refines the middle.
static double graded(double t, double width) {
  const double rest = 1.0 - t;
  if (width == 0.0) return 1.0 - rest * rest;
  const double whole = 1.0 + std::asinh(1.0 / width);
  double low = 0.0, high = 1.0;
  while (high - low > 1e-15) {
    const double s = 0.5 * (low + high);
    (std::asinh(s / width) + 1.0 - std::sqrt(1.0 - s) < t * whole ? low : high) = s;
  }
  return t == 1.0 ? 1.0 : t == 0.0 ? 0.0 : 0.5 * (low + high);
}

namespace {

// Returns the number of panels within the distance d of the end of an edge, divided by the number
// for d = 1. The distance is in units of half of the shortest edge. Up to d = 1, panels are refined
// towards the end. Beyond d = 1, the width of panels is constant or grows in proportion to
// 1 + growth (d - 1).
double panels_from_end(double d, double growth) {
  if (d <= 1.0) return std::sqrt(d);
  return 1.0 + (growth > 0.0 ? 0.5 * std::log1p(growth * (d - 1.0)) / growth : 0.5 * (d - 1.0));
}

double distance_from_end(double panels, double growth) {  // inverse of panels_from_end()
  if (panels <= 1.0) return panels * panels;
  const double more = 2.0 * (panels - 1.0);
  return 1.0 + (growth > 0.0 ? std::expm1(growth * more) / growth : more);
}

// Panels on half of an edge of a cuboid.
struct HalfEdge {
  double length = 1.0;  // in units of half of the shortest edge
  int multiple = 1;     // number of panels, divided by the number on half of the shortest edge
  double growth = 0.0;  // growth of the panel widths towards the middle; see panels_from_end()

  // Returns the position, between 0 (middle of the edge) and 1 (its end), below which a fraction t
  // of the panels lies.
  double position(double t) const {
    if (t == 0.0) return 0.0;
    const double panels = (1.0 - t) * panels_from_end(length, growth);
    return 1.0 - distance_from_end(panels, growth) / length;
  }
};

// Returns the panels on half of an edge, for the edges along each axis. Multiples are integers, so
// the numbers of panels of two grids have the same ratio along all edges, as Richardson
// extrapolation requires.
std::array<HalfEdge, 3> half_edges(const Vec3& size) {
  // Largest width of panels far from the ends of an edge, unless panels grow towards the middle.
  // The unit is the width in the middle of the shortest edge, in the limit of many cells.
  // docs/experiments/magnetics.md compares values.
  constexpr double widest = 1.38;
  // Largest number of panels in an octant, in units of (cells / 2)^2, which is the number of panels
  // on a quarter of a cube's face.
  constexpr int most_panels = 19;
  std::array<HalfEdge, 3> edges;
  for (int axis = 0; axis < 3; ++axis) {
    HalfEdge& edge = edges[axis];
    edge.length = size[axis] / size.minCoeff();
    const double wanted = std::ceil(panels_from_end(edge.length, 0.0) / widest);
    edge.multiple = static_cast<int>(std::clamp<double>(wanted, 1.0, most_panels));
  }
  const auto panels = [&] {
    const int a = edges[0].multiple, b = edges[1].multiple, c = edges[2].multiple;
    return a * b + b * c + c * a;
  };
  while (panels() > most_panels) {
    const int largest = std::max({edges[0].multiple, edges[1].multiple, edges[2].multiple});
    for (HalfEdge& edge : edges)
      if (edge.multiple == largest) --edge.multiple;
  }
  for (HalfEdge& edge : edges) {
    const double most = widest * edge.multiple;
    if (panels_from_end(edge.length, 0.0) <= most) continue;
    double low = 0.0, high = 1.0;
    while (panels_from_end(edge.length, high) > most) high *= 2.0;
    while (high - low > 1e-12 * high) {
      edge.growth = 0.5 * (low + high);
      (panels_from_end(edge.length, edge.growth) > most ? low : high) = edge.growth;
    }
  }
  return edges;
}

}  // namespace

std::vector<FlatPanel> cuboid_panels(const Vec3& size, int cells, double focus) {
  std::vector<FlatPanel> eighth, all;
  const std::array<HalfEdge, 3> edges = half_edges(size);
  int halves[3];
  for (int axis = 0; axis < 3; ++axis)
    halves[axis] = cells / 2 * (focus > 0.0 ? 1 : edges[axis].multiple);
  // Returns the coordinate of grid line i along an axis. i = 0 is the middle of the edge, and
  // i = halves[axis] its end.
  const auto place = [&](int axis, int i) {
    const double t = static_cast<double>(i) / halves[axis];
    return 0.5 * size[axis] *
           (focus > 0.0 ? graded(t, 2.0 * focus / size[axis]) : edges[axis].position(t));
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int i = 0; i < halves[a]; ++i) {
      for (int k = 0; k < halves[b]; ++k) {
        Vec3 corners[4];
        for (int c = 0; c < 4; ++c) {
          corners[c][axis] = 0.5 * size[axis];
          corners[c][a] = place(a, i + (c == 1 || c == 2));
          corners[c][b] = place(b, k + (c >= 2));
        }
        eighth.push_back(make_panel(corners, 4));
      }
    }
  }
  for (int s = 0; s < 8; ++s) {
    const Vec3 mirror(s & 1 ? -1 : 1, s & 2 ? -1 : 1, s & 4 ? -1 : 1);
    const bool turned = mirror.prod() < 0.0;
    for (const FlatPanel& panel : eighth) {
      Vec3 corners[4];
      for (int c = 0; c < 4; ++c)
        corners[c] = panel.corner[turned ? 3 - c : c].cwiseProduct(mirror);
      all.push_back(make_panel(corners, 4));
    }
  }
  return all;
}

using ProfilePoint = std::array<double, 2>;

// Returns the meridian of the surface as points (radius, height) [m], counter-clockwise and refined
// towards its corners.
static std::vector<ProfilePoint> cylinder_profile(double radius, double inner_radius, double height,
                                                  int cells) {
  // The number of rows along the side grows as the square root of height / (2 radius), by a factor
  // of at most 8.
  const int slender =
      static_cast<int>(std::lround(std::clamp(std::sqrt(0.5 * height / radius), 1.0, 8.0)));
  std::vector<ProfilePoint> profile;
  const auto go_to = [&](double r, double z, int n, bool graded_at_start) {
    const ProfilePoint from = profile.back();
    for (int i = 1; i <= n; ++i) {
      const double t = static_cast<double>(i) / n, both = 2.0 * t - 1.0;
      const double share = graded_at_start
                               ? 0.5 * (1.0 + std::copysign(graded(std::abs(both), 0.0), both))
                               : graded(t, 0.0);
      profile.push_back({from[0] + share * (r - from[0]), from[1] + share * (z - from[1])});
    }
  };
  const double half = 0.5 * height;
  const bool ring = inner_radius > 0.0;
  profile.push_back({inner_radius, -half});
  go_to(radius, -half, cells / 2, ring);
  go_to(radius, half, slender * cells, true);
  if (ring) {
    go_to(inner_radius, half, cells / 2, true);
    go_to(inner_radius, -half, slender * cells, true);
  } else {
    const auto n = static_cast<std::size_t>(cells / 2);
    for (std::size_t i = n; i-- > 0;) profile.push_back({profile[i][0], half});
  }
  return profile;
}

std::vector<FlatPanel> cylinder_panels(double radius, double inner_radius, double height,
                                       int cells) {
  const int sides = 2 * cells;
  // The factor `wider` makes the areas of polygon and circle equal.
  const double angle = 2.0 * pi / sides, wider = std::sqrt(angle / std::sin(angle));
  const std::vector<ProfilePoint> profile = cylinder_profile(radius, inner_radius, height, cells);
  const auto corner = [&](std::size_t row, int side) {
    const double phi = angle * (side % sides);
    return Vec3(wider * profile[row][0] * std::cos(phi), wider * profile[row][0] * std::sin(phi),
                profile[row][1]);
  };
  std::vector<FlatPanel> result;
  for (std::size_t row = 0; row + 1 < profile.size(); ++row) {
    for (int side = 0; side < sides; ++side) {
      const Vec3 c[4] = {corner(row, side), corner(row, side + 1), corner(row + 1, side + 1),
                         corner(row + 1, side)};
      const auto add = [&](int i, int j, int k) {
        const Vec3 corners[3] = {c[i], c[j], c[k]};
        result.push_back(make_panel(corners, 3));
      };
      // The diagonals alternate, so the panels are symmetric about z = 0 and about the vertical
      // planes through opposite edges of the prism. Corner 0 of the triangles (see panel_points())
      // alternates, too, so quadrature points are symmetric about these vertical planes.
      if (profile[row][0] == 0.0)
        add(0, 2, 3);
      else if (profile[row + 1][0] == 0.0)
        add(2, 0, 1);
      else if ((side + row) % 2 == 0)
        add(0, 1, 2), add(0, 2, 3);
      else
        add(1, 3, 0), add(1, 2, 3);
    }
  }
  return result;
}

std::vector<FlatPanel> mesh_panels(const TriangleMesh& mesh, Index panels) {
  std::vector<Vec3> vertices;
  for (Index i = 0; i < mesh.n_vertices(); ++i)
    vertices.push_back(mesh.vertices().row(i).transpose());
  std::vector<std::array<Index, 3>> faces;
  std::map<std::pair<Index, Index>, Index> face_of;  // keyed by directed edge
  const auto add = [&](Index f) {
    for (int k = 0; k < 3; ++k) face_of[{faces[f][k], faces[f][(k + 1) % 3]}] = f;
  };
  std::priority_queue<std::tuple<double, Index, Index>> longest;
  const auto push = [&](Index a, Index b) {
    longest.emplace((vertices[a] - vertices[b]).squaredNorm(), std::min(a, b), std::max(a, b));
  };
  for (Index f = 0; f < mesh.n_triangles(); ++f) {
    faces.push_back({mesh.triangles()(f, 0), mesh.triangles()(f, 1), mesh.triangles()(f, 2)});
    add(f);
    for (int k = 0; k < 3; ++k) push(faces[f][k], faces[f][(k + 1) % 3]);
  }
  while (static_cast<Index>(faces.size()) < panels) {
    const auto [length, low, high] = longest.top();
    longest.pop();
    if (!face_of.contains({low, high})) continue;  // already bisected
    const Index middle = static_cast<Index>(vertices.size());
    vertices.push_back(0.5 * (vertices[low] + vertices[high]));
    for (const auto& [from, to] : {std::pair(low, high), std::pair(high, low)}) {
      const Index f = face_of.at({from, to});
      const Index opposite = faces[f][0] + faces[f][1] + faces[f][2] - from - to;
      face_of.erase({from, to});
      faces[f] = {from, middle, opposite};
      faces.push_back({middle, to, opposite});
      add(f);
      add(static_cast<Index>(faces.size()) - 1);
      push(middle, opposite);
    }
    push(low, middle);
    push(middle, high);
  }
  std::vector<FlatPanel> result;
  for (const auto& face : faces) {
    const Vec3 corners[3] = {vertices[face[0]], vertices[face[1]], vertices[face[2]]};
    result.push_back(make_panel(corners, 3));
  }
  return result;
}

}  // namespace loomstone
