#include "core/collision/tangle/tangle.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/base/sort_unique.h"
#include "core/collision/broad_phase/median_tree.h"
#include "core/collision/narrow_phase/exact_predicates.h"

namespace loomstone {

namespace {

// Smallest sine of the angle between an edge and the plane of a triangle in the computation of
// Piercing::way_out. Smaller sines are replaced by it.
constexpr double least_sine = 0.2;
// At each piercing, the unit directions in which the contour segments leave it are summed. The
// piercing gets a direction that shortens the contour (Piercing::way_out) only if the length of the
// sum is at least this value. If the sum is shorter, the contour is almost straight there.
constexpr double least_bend = 0.05;

Index root(std::vector<Index>& parent, Index i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

bool share_a_vertex(const Piercing& p) {
  for (int k = 2; k < 5; ++k)
    if (p.vertices[k] == p.vertices[0] || p.vertices[k] == p.vertices[1]) return true;
  return false;
}

bool attached(const CollisionModel& model, const Piercing& p) {
  if (model.attached.empty()) return false;
  const Index of_edge = model.surface_of_edge(p.edge),
              of_triangle = model.surface_of_triangle(p.triangle);
  for (int k = 0; k < 5; ++k)
    if (model.attached[p.vertices[k]].excludes(k < 2 ? of_triangle : of_edge)) return true;
  return false;
}

// Returns whether the edge passes through the triangle. The test is exact, and ties are broken
// consistently: an edge through the common side of two triangles pierces only one of them, unless
// the triangles overlap as seen along the edge. An end point in the plane of the triangle counts as
// below the plane.
bool pierces(const Points& x, const std::array<Index, 5>& v) {
  const Vec3 p = point(x, v[0]), q = point(x, v[1]);
  const std::array<Vec3, 3> corner = {point(x, v[2]), point(x, v[3]), point(x, v[4])};
  const auto below = [&](const Vec3& end) {
    return orientation(corner[0], corner[1], corner[2], end) >= 0;
  };
  if (below(p) == below(q)) return false;
  int on_left = 0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, side = orientation(p, q, corner[k], corner[l]);
    on_left += side > 0 || (side == 0 && v[2 + k] < v[2 + l]);
  }
  return on_left == 0 || on_left == 3;
}

// Returns the weights of the common point of edge and triangle; see Piercing.
std::array<double, 5> weights_of(const Points& x, const std::array<Index, 5>& v) {
  const Vec3 p = point(x, v[0]), q = point(x, v[1]), a = point(x, v[2]), b = point(x, v[3]),
             c = point(x, v[4]);
  const Vec3 normal = (b - a).cross(c - a);
  const double above = std::abs(normal.dot(p - a)), below = std::abs(normal.dot(q - a));
  const double t = above + below > 0.0 ? above / (above + below) : 0.5;
  const Vec3 at = (1.0 - t) * p + t * q;
  std::array<double, 3> areas = {normal.dot((b - at).cross(c - at)),
                                 normal.dot((c - at).cross(a - at)),
                                 normal.dot((a - at).cross(b - at))};
  double sum = 0.0;
  for (double& area : areas) sum += area = std::max(0.0, area);
  if (!(sum > 0.0)) {
    areas = {1.0, 1.0, 1.0};
    sum = 3.0;
  }
  return {1.0 - t, t, -areas[0] / sum, -areas[1] / sum, -areas[2] / sum};
}

bool is_cloth(const CollisionModel& model, Index v) {
  return model.surfaces[model.surface_of_vertex(v)].kind == CollisionSurface::Kind::Cloth;
}

}  // namespace

Tangle TangleFinder::find(const Points& x) {
  if (topology_.edges.rows() == 0) {
    topology_ = edge_table(model_.n_vertices, model_.triangles);
    edges_of_vertex_ = edges_of_vertices(model_.n_vertices, topology_.edges);
    find_components();
  }
  Tangle tangle;
  pierce(x, tangle);
  if (tangle.empty()) return tangle;
  ignore_pairs(tangle);
  join_contours(x, tangle);
  cut_off(x, tangle);
  return tangle;
}

void TangleFinder::pierce(const Points& x, Tangle& tangle) const {
  const std::vector<Box> boxes = triangle_boxes(x, model_.triangles);
  const auto test = [&](Index of_edge, Index triangle) {
    for (const Index edge : topology_.of_triangle[of_edge]) {
      if (topology_.triangles[edge][0] != of_edge)
        continue;  // visit each edge once, with its first triangle
      Piercing p;
      p.edge = edge;
      p.triangle = triangle;
      p.vertices = {topology_.edges(edge, 0), topology_.edges(edge, 1),
                    model_.triangles(triangle, 0), model_.triangles(triangle, 1),
                    model_.triangles(triangle, 2)};
      const auto& v = p.vertices;
      if (share_a_vertex(p) || attached(model_, p) || !pierces(x, v)) continue;
      p.weights = weights_of(x, v);
      const CollisionSurface &a = model_.surfaces[model_.surface_of_edge(edge)],
                             &b = model_.surfaces[model_.surface_of_triangle(triangle)];
      p.thickness = 0.5 * (a.thickness + b.thickness);
      tangle.piercings.push_back(p);
    }
  };
  MedianTree(boxes).each_pair([&](Index i, Index j) {
    if (!kept_apart(model_, model_.surface_of_triangle(i), model_.surface_of_triangle(j))) return;
    test(i, j);
    test(j, i);
  });
  std::sort(tangle.piercings.begin(), tangle.piercings.end(),
            [](const Piercing& a, const Piercing& b) {
              return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle);
            });
}

void TangleFinder::ignore_pairs(Tangle& tangle) const {
  std::vector<PairKey>&vertex_face = tangle.ignored[0], &edge_edge = tangle.ignored[1];
  const auto add = [&](Index a, Index b) {
    for (int k = 0; k < 3; ++k) {
      vertex_face.push_back(pair_key(model_.triangles(a, k), b));
      vertex_face.push_back(pair_key(model_.triangles(b, k), a));
    }
    for (const Index e : topology_.of_triangle[a])
      for (const Index f : topology_.of_triangle[b])
        edge_edge.push_back(pair_key(std::min(e, f), std::max(e, f)));
  };
  for (const Piercing& p : tangle.piercings)
    for (const Index t : topology_.triangles[p.edge])
      if (t >= 0) add(t, p.triangle);
  for (auto& keys : tangle.ignored) {
    sort_unique(keys);
  }
}

void TangleFinder::join_contours(const Points& x, Tangle& tangle) const {
  std::vector<Piercing>& piercings = tangle.piercings;
  struct Of {
    PairKey triangles;
    std::size_t piercing;
  };
  std::vector<Of> all;
  for (std::size_t i = 0; i < piercings.size(); ++i)
    for (const Index t : topology_.triangles[piercings[i].edge])
      if (t >= 0) {
        const Index other = piercings[i].triangle;
        all.push_back({pair_key(std::min(t, other), std::max(t, other)), i});
      }
  std::sort(all.begin(), all.end(), [](const Of& a, const Of& b) {
    return std::tie(a.triangles, a.piercing) < std::tie(b.triangles, b.piercing);
  });
  std::vector<Index> parent(piercings.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  // Sum of the unit directions in which the contour segments leave each piercing.
  std::vector<Vec3> bend(piercings.size(), Vec3::Zero());
  const auto place = [&](const Piercing& p) {
    return Vec3(p.weights[0] * point(x, p.vertices[0]) + p.weights[1] * point(x, p.vertices[1]));
  };
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    if (all[i].triangles != all[i + 1].triangles) continue;
    const std::size_t a = all[i].piercing, b = all[i + 1].piercing;
    const Index ra = root(parent, static_cast<Index>(a)), rb = root(parent, static_cast<Index>(b));
    parent[std::max(ra, rb)] = std::min(ra, rb);
    const Vec3 along = place(piercings[b]) - place(piercings[a]);
    const double length = along.norm();
    if (!(length > 0.0)) continue;
    bend[a] += along / length;
    bend[b] -= along / length;
    piercings[a].segment += 0.5 * length;
    piercings[b].segment += 0.5 * length;
  }
  for (std::size_t i = 0; i < piercings.size(); ++i) {
    Piercing& p = piercings[i];
    p.contour = root(parent, static_cast<Index>(i));
    if (bend[i].norm() < least_bend) continue;
    // The common point moves along the edge and in the plane of the triangle. Edge and triangle
    // each perform half of the relative motion [Volino2006].
    const Vec3 a = point(x, p.vertices[2]);
    const Vec3 n = (point(x, p.vertices[3]) - a).cross(point(x, p.vertices[4]) - a).normalized();
    const Vec3 e = (point(x, p.vertices[1]) - point(x, p.vertices[0])).normalized();
    const double sine = std::copysign(std::max(least_sine, std::abs(e.dot(n))), e.dot(n));
    const Vec3 shorter = bend[i] - 2.0 * e.dot(bend[i]) / sine * n;
    if (shorter.norm() > 0.0 && shorter.allFinite()) p.way_out = shorter.normalized();
  }
}

bool Tangle::ignores(const CollisionModel& model, ContactKind kind, PairKey key,
                     const std::array<Index, 4>& vertices) const {
  const std::vector<PairKey>& keys = ignored[static_cast<int>(kind)];
  if (std::binary_search(keys.begin(), keys.end(), key)) return true;
  if (piercings.empty()) return false;
  const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
  for (int i = 0; i < n_a; ++i)
    for (int j = n_a; j < 4; ++j) {
      const Index a = vertices[i], b = vertices[j];
      const int contour = contour_of_vertex[a];
      if (contour < 0 || contour != contour_of_vertex[b] || part[a] == part[b] ||
          !(came_through[a] || came_through[b]))
        continue;
      // A pair of two cloth features is ignored only if both surfaces of the contour are cloth.
      const Piercing& any = piercings[contour];
      return !is_cloth(model, a) || !is_cloth(model, b) ||
             (is_cloth(model, any.vertices[0]) && is_cloth(model, any.vertices[2]));
    }
  return false;
}

}  // namespace loomstone
