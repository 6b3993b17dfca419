#include <algorithm>
#include <cmath>
#include <map>

#include "core/collision/narrow_phase/exact_predicates.h"
#include "core/collision/tangle/tangle.h"

namespace loomstone {

namespace {

// Width, as a number of edges, of the zone around a contour and around the parts that have passed
// through another surface. In this zone, pairs of a feature of such a part and a feature of another
// part are ignored.
constexpr int rounds_around = 2;
// If a part of a surface has passed through another surface, the whole surface is retracted only if
// all of these hold:
//   the contour is at least `least_length` times as long as the square root of the surface's area;
//   the part has at least the fraction `least_share` of this area;
//   the mean of Piercing::way_out over the piercings at which an edge leads into the part, weighted
//   by Piercing::segment, is longer than `least_agreement`.
// Otherwise, only the part moves back.
constexpr double least_length = 0.5, least_share = 0.02, least_agreement = 0.5;

// Returns for each vertex a third of the total area of its triangles [m^2].
std::vector<double> vertex_areas(const Points& x, const Triangles& triangles) {
  std::vector<double> area(x.rows(), 0.0);
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = point(x, triangles(t, 0));
    const double third =
        (point(x, triangles(t, 1)) - a).cross(point(x, triangles(t, 2)) - a).norm() / 6.0;
    for (int k = 0; k < 3; ++k) area[triangles(t, k)] += third;
  }
  return area;
}

bool separates_nothing(std::span<Piercing* const> contour, const std::vector<int>& part) {
  return std::all_of(contour.begin(), contour.end(), [&](const Piercing* p) {
    return part[p->vertices[0]] == part[p->vertices[1]];
  });
}

// Returns whether each edge of the contour has a different label from the triangle that it pierces.
// `label` has one entry for each vertex; the first vertices of edge and triangle are compared.
bool are_disjoint(std::span<Piercing* const> contour, const std::vector<int>& label) {
  return std::none_of(contour.begin(), contour.end(), [&](const Piercing* p) {
    return label[p->vertices[0]] == label[p->vertices[2]];
  });
}

}  // namespace

// Finds the parts into which contours divide surfaces, and the retractions. The smaller of the two
// parts at a contour is assumed to have passed through the other surface. If split_by_side() has
// made the parts, this is assumed only of the smallest part of both surfaces.
void TangleFinder::cut_off(const Points& x, Tangle& tangle) const {
  tangle.contour_of_vertex.assign(model_.n_vertices, -1);
  tangle.part.assign(model_.n_vertices, -1);
  tangle.came_through.assign(model_.n_vertices, 0);
  const std::vector<double> area = vertex_areas(x, model_.triangles);
  std::vector<Piercing*> order;
  for (Piercing& p : tangle.piercings) order.push_back(&p);
  std::stable_sort(order.begin(), order.end(),
                   [](const Piercing* a, const Piercing* b) { return a->contour < b->contour; });
  Cut cut{std::vector<std::uint8_t>(topology_.edges.rows(), 0),
          std::vector<int>(model_.n_vertices),
          {}};
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && order[end]->contour == order[begin]->contour) ++end;
    const std::span<Piercing* const> contour(order.data() + begin, end - begin);
    for (const Piercing* const p : contour) cut.through[p->edge] ^= 1;
    std::fill(cut.part.begin(), cut.part.end(), -1);
    cut.size.clear();
    cut_along(x, contour, area, cut, tangle);
    for (const Piercing* const p : contour) cut.through[p->edge] = 0;
  }
  drop_opposed(tangle);
}

// Removes retractions of the same two surfaces in opposite directions, because together they would
// not move the surfaces apart. An example is a cloth with a board through its middle. Sets
// Piercing::way_out to zero on the contours of the removed retractions.
void TangleFinder::drop_opposed(Tangle& tangle) {
  const auto opposed = [](const Retraction& a, const Retraction& b) {
    const double along = a.direction.dot(b.direction);
    return (a.inner == b.inner && a.outer == b.outer && along < 0.0) ||
           (a.inner == b.outer && a.outer == b.inner && along > 0.0);
  };
  const std::vector<Retraction> all = std::move(tangle.retractions);
  tangle.retractions.clear();
  for (const Retraction& each : all) {
    if (std::none_of(all.begin(), all.end(),
                     [&](const Retraction& other) { return opposed(each, other); })) {
      tangle.retractions.push_back(each);
      continue;
    }
    for (Piercing& p : tangle.piercings)
      if (p.contour == each.contour) p.way_out.setZero();
  }
}

void TangleFinder::cut_along(const Points& x, std::span<Piercing* const> contour,
                             const std::vector<double>& area, Cut& cut, Tangle& tangle) const {
  const int id = contour.front()->contour;
  for (const Piercing* const p : contour)
    for (const Index v : p->vertices) flood(v, area, cut);
  const bool open = separates_nothing(contour, cut.part) && are_disjoint(contour, cut.part);
  if (open) split_by_side(x, contour, area, cut);
  refine_sizes(x, contour, cut);
  // The only part that moves back, or -1 if the smaller of the two parts at each piercing moves
  // back.
  const int only = open ? smallest_part(contour, cut) : -1;
  std::vector<std::uint8_t> came_through(cut.size.size(), 0);
  for (Piercing* const p : contour) {
    for (const Index v : p->vertices) tangle.contour_of_vertex[v] = id;
    const int part = smaller_part(*p, cut);
    if (part < 0 || (only >= 0 && part != only)) continue;
    came_through[part] = 1;
    const Vec3 a = point(x, p->vertices[2]);
    const Vec3 n = (point(x, p->vertices[3]) - a).cross(point(x, p->vertices[4]) - a);
    const Vec3 out = (part == cut.part[p->vertices[1]] ? -1.0 : 1.0) *
                     (point(x, p->vertices[1]) - point(x, p->vertices[0]));
    if (n.norm() > 0.0) p->way_out = n.normalized() * std::copysign(1.0, n.dot(out));
  }
  for (Index v = 0; v < model_.n_vertices; ++v) {
    const int part = cut.part[v];
    if (part < 0 || (tangle.contour_of_vertex[v] != id && !came_through[part])) continue;
    tangle.contour_of_vertex[v] = id;
    tangle.part[v] = part;
    tangle.came_through[v] = came_through[part];
  }
  widen(cut.part, id, tangle);
  retract(x, contour, area, cut, tangle);
}

// Adds a retraction for the smallest part that the contour cuts off, if the three conditions in the
// comment on `least_length` hold and the contour lies between two surfaces that are not connected.
void TangleFinder::retract(const Points& x, std::span<Piercing* const> contour,
                           const std::vector<double>& area, const Cut& cut, Tangle& tangle) const {
  const int part = smallest_part(contour, cut);
  if (part < 0 || !are_disjoint(contour, component_)) return;
  Retraction retraction;
  Index inner = -1, outer = -1;  // indices of the two connected components to retract
  double length = 0.0, weight = 0.0;
  for (const Piercing* const p : contour) {
    length += p->segment;
    if (smaller_part(*p, cut) != part) continue;
    inner = component_[p->vertices[0]];
    outer = component_[p->vertices[2]];
    weight += p->segment;
    retraction.direction += p->segment * p->way_out;
    retraction.point += p->segment * (p->weights[0] * point(x, p->vertices[0]) +
                                      p->weights[1] * point(x, p->vertices[1]));
  }
  double whole = 0.0;
  for (Index v = 0; v < model_.n_vertices; ++v) {
    if (component_[v] == inner) {
      whole += area[v];
      retraction.inner.push_back(v);
    } else if (component_[v] == outer) {
      retraction.outer.push_back(v);
    }
  }
  if (cut.size[part] < least_share * whole || length < least_length * std::sqrt(whole) ||
      retraction.direction.norm() <= least_agreement * weight)
    return;
  retraction.contour = contour.front()->contour;
  retraction.point /= weight;
  retraction.direction.normalize();
  retraction.depth = cut.size[part] / length;
  tangle.retractions.push_back(std::move(retraction));
}

// Corrects the sizes of parts, which are sums of vertex areas and thus assume that the contour
// halves each edge that it crosses. The correction is the area of the strip between the midpoints
// of these edges and the contour.
void TangleFinder::refine_sizes(const Points& x, std::span<Piercing* const> contour, Cut& cut) {
  double length = 0.0;
  std::map<int, int> n_edges;  // number of crossed edges at each part
  for (const Piercing* const p : contour) {
    length += p->segment;
    for (int k = 0; k < 2; ++k) ++n_edges[cut.part[p->vertices[k]]];
  }
  for (const Piercing* const p : contour) {
    const int first = cut.part[p->vertices[0]], second = cut.part[p->vertices[1]];
    const double edge = (point(x, p->vertices[1]) - point(x, p->vertices[0])).norm();
    const double strip = (p->weights[1] - 0.5) * edge * length / n_edges[first];
    cut.size[first] += strip;
    cut.size[second] -= strip;
  }
}

// Returns the smaller of the two parts that the edge connects, or -1 if the edge lies in one part.
int TangleFinder::smaller_part(const Piercing& p, const Cut& cut) {
  const int first = cut.part[p.vertices[0]], second = cut.part[p.vertices[1]];
  if (first == second) return -1;
  if (cut.size[first] == cut.size[second]) return std::max(first, second);
  return cut.size[first] < cut.size[second] ? first : second;
}

int TangleFinder::smallest_part(std::span<Piercing* const> contour, const Cut& cut) {
  int smallest = -1;
  for (const Piercing* const p : contour) {
    const int part = smaller_part(*p, cut);
    if (part >= 0 && (smallest < 0 || cut.size[part] < cut.size[smallest])) smallest = part;
  }
  return smallest;
}

// Splits each surface that the contour enters but does not separate. A breadth-first search starts
// on both sides of the contour. A vertex belongs to the side from which the search finds it first,
// so the cut continues to the border of the surface.
void TangleFinder::split_by_side(const Points& x, std::span<Piercing* const> contour,
                                 const std::vector<double>& area, Cut& cut) const {
  // 0: on the side to which the normal of the pierced triangle points; 1: on the other side; -1:
  // not reached.
  std::vector<int> side(model_.n_vertices, -1);
  std::vector<Index> reached;
  for (const Piercing* const p : contour) {
    if (!cut.through[p->edge]) continue;
    const bool first_is_below =
        orientation(point(x, p->vertices[2]), point(x, p->vertices[3]), point(x, p->vertices[4]),
                    point(x, p->vertices[0])) >= 0;
    for (int k = 0; k < 2; ++k) {
      const Index v = p->vertices[k];
      if (side[v] >= 0) continue;
      side[v] = first_is_below == (k == 0);
      reached.push_back(v);
    }
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const Index v = reached[i];
    for (Index k = edges_of_vertex_.start[v]; k < edges_of_vertex_.start[v + 1]; ++k) {
      const Index edge = edges_of_vertex_.items[k], other = other_end(edge, v);
      if (cut.through[edge] || side[other] >= 0) continue;
      side[other] = side[v];
      reached.push_back(other);
    }
  }
  cut.size.assign(2 * cut.size.size(), 0.0);
  for (Index v = 0; v < model_.n_vertices; ++v) {
    if (cut.part[v] < 0) continue;
    cut.part[v] = 2 * cut.part[v] + (side[v] > 0);
    cut.size[cut.part[v]] += area[v];
  }
}

void TangleFinder::find_components() {
  Cut whole{std::vector<std::uint8_t>(topology_.edges.rows(), 0),
            std::vector<int>(model_.n_vertices, -1),
            {}};
  const std::vector<double> no_area(model_.n_vertices, 0.0);
  for (Index v = 0; v < model_.n_vertices; ++v) flood(v, no_area, whole);
  component_ = std::move(whole.part);
}

void TangleFinder::flood(Index start, const std::vector<double>& area, Cut& cut) const {
  if (cut.part[start] >= 0) return;
  const int id = static_cast<int>(cut.size.size());
  cut.size.push_back(0.0);
  std::vector<Index> stack = {start};
  cut.part[start] = id;
  while (!stack.empty()) {
    const Index v = stack.back();
    stack.pop_back();
    cut.size[id] += area[v];
    for (Index i = edges_of_vertex_.start[v]; i < edges_of_vertex_.start[v + 1]; ++i) {
      const Index edge = edges_of_vertex_.items[i], other = other_end(edge, v);
      if (cut.through[edge] || cut.part[other] >= 0) continue;
      cut.part[other] = id;
      stack.push_back(other);
    }
  }
}

// Widens the zone around a contour, because contours of surfaces that cross at a small angle move
// far in one step.
void TangleFinder::widen(const std::vector<int>& part, int contour, Tangle& tangle) const {
  std::vector<Index> ring;
  for (Index v = 0; v < model_.n_vertices; ++v)
    if (tangle.contour_of_vertex[v] == contour) ring.push_back(v);
  for (int round = 0; round < rounds_around; ++round) {
    std::vector<Index> next;
    for (const Index v : ring)
      for (Index i = edges_of_vertex_.start[v]; i < edges_of_vertex_.start[v + 1]; ++i) {
        const Index other = other_end(edges_of_vertex_.items[i], v);
        if (tangle.contour_of_vertex[other] >= 0) continue;
        tangle.contour_of_vertex[other] = contour;
        tangle.part[other] = part[other];
        next.push_back(other);
      }
    ring = std::move(next);
  }
}

Index TangleFinder::other_end(Index edge, Index v) const {
  return topology_.edges(edge, 0) == v ? topology_.edges(edge, 1) : topology_.edges(edge, 0);
}

}  // namespace loomstone
