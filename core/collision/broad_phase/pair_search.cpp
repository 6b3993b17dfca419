#include "core/collision/broad_phase/pair_search.h"

#include <algorithm>
#include <cstring>

#include "core/base/simd.h"

namespace loomstone {

namespace {

typedef std::int32_t Ints __attribute__((vector_size(4 * slab_lanes)));
typedef std::int8_t Bytes __attribute__((vector_size(slab_lanes)));

template <class Vector, class Number>
LOOMSTONE_INLINE void load(Vector& v, const Number* p) {
  std::memcpy(&v, p, sizeof v);
}

LOOMSTONE_INLINE unsigned bits_of(const Ints& lanes) {
  const Bytes bytes = __builtin_convertvector(lanes, Bytes);
  std::uint64_t all;
  std::memcpy(&all, &bytes, sizeof all);
  // Bit i of byte i, then all bytes added in the highest.
  return static_cast<unsigned>(((all & 0x8040201008040201u) * 0x0101010101010101u) >> 56);
}

LOOMSTONE_INLINE void meet_slab(Ints& meet, const SlabGroup& group, float own_low, float own_high,
                                int k) {
  SlabLanes low, high;
  load(low, group.low[k]);
  load(high, group.high[k]);
  meet &= (low <= own_high) & (high >= own_low);
}

// Slabs that need not be copied out of their group.
struct Lane {
  const SlabGroup* group;
  int lane;

  float low(int k) const { return group->low[k][lane]; }
  float high(int k) const { return group->high[k][lane]; }
};

// By how much each slab of one of two boxes is moved outwards before they are compared, so that
// points of two such boxes that come within a distance overlap. The roundings of the sum are within
// those that the slabs were rounded outwards by.
struct Reach {
  float axis = 0.0f, diagonal = 0.0f;

  explicit Reach(double distance)
      : axis(static_cast<float>(distance * 1.000001)),
        diagonal(static_cast<float>(distance * 1.4142149766)) {}
  float of(int k) const { return k < n_axis_slabs ? axis : diagonal; }
};

// Lanes of `group` that overlap a box; the diagonals are looked at only where the axes leave
// something.
LOOMSTONE_INLINE unsigned overlapping_lanes(const SlabGroup& group, const Lane& box,
                                            const Reach& reach) {
  Ints meet = ~Ints{};
  for (int k = 0; k < n_axis_slabs; ++k)
    meet_slab(meet, group, box.low(k) - reach.axis, box.high(k) + reach.axis, k);
  if (bits_of(meet) == 0) return 0;
  for (int k = n_axis_slabs; k < n_slabs; ++k)
    meet_slab(meet, group, box.low(k) - reach.diagonal, box.high(k) + reach.diagonal, k);
  return bits_of(meet);
}

// A run of groups of features of one kind.
struct Run {
  const SlabGroup* slabs;
  const Index* corners;
  Index begin, end;

  Run(const ClusterTree::Features& features, Index cluster)
      : slabs(features.slabs.data()),
        corners(features.corners.data()),
        begin(features.group[cluster]),
        end(features.group[cluster + 1]) {}
};

constexpr Index most_groups = 8;  // that are masked at once

// Pairs of slots of edges that overlap and share no vertex. Edges that miss the other cluster's box
// are masked first. `upper`: only slots of b after that of a.
template <class Pairs>
LOOMSTONE_INLINE void meeting_edges(const Run& a, const Lane& box_a, const Run& b,
                                    const Lane& box_b, const Reach& reach, bool upper, Pairs& out) {
  for (Index first = b.begin; first < b.end; first += most_groups) {
    const Index n_b = std::min<Index>(most_groups, b.end - first);
    unsigned mask_b[most_groups], any = 0;
    for (Index j = 0; j < n_b; ++j)
      any |= mask_b[j] = overlapping_lanes(b.slabs[first + j], box_a, reach);
    if (any == 0) continue;
    for (Index i = a.begin; i < a.end; ++i) {
      for (unsigned lanes = overlapping_lanes(a.slabs[i], box_b, reach); lanes != 0;
           lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const Lane own = {a.slabs + i, lane};
        for (Index j = 0; j < n_b; ++j) {
          const Index group = first + j;
          if (mask_b[j] == 0 || (upper && group < i)) continue;
          Ints meet = ~Ints{};
          for (int k = 0; k < n_slabs; ++k)
            meet_slab(meet, b.slabs[group], own.low(k) - reach.of(k), own.high(k) + reach.of(k), k);
          for (int l = 0; l < 2; ++l) {
            Ints corner;
            load(corner, b.corners + (group * 2 + l) * slab_lanes);
            for (int k = 0; k < 2; ++k)
              meet &= corner != a.corners[(i * 2 + k) * slab_lanes + lane];
          }
          unsigned found = bits_of(meet) & mask_b[j];
          if (upper && group == i) found &= ~((2u << lane) - 1u);
          for (; found != 0; found &= found - 1)
            out.emplace_back(slab_lanes * i + lane, slab_lanes * group + __builtin_ctz(found));
        }
      }
    }
  }
}

// The vertices of one cluster and where their boxes are.
struct VertexRun {
  const PackedSlabs* boxes;
  const Index* id;
  Index begin, end;  // slots; empty ones hold -1

  VertexRun(const ClusterTree& tree, Index cluster)
      : boxes(tree.vertex_boxes()),
        id(tree.vertices().corners.data()),
        begin(slab_lanes * tree.vertices().group[cluster]),
        end(slab_lanes * tree.vertices().group[cluster + 1]) {}
};

// What a box must not exceed, lane by lane, to overlap this one.
LOOMSTONE_INLINE PackedSlabs limits_of(const Lane& box, const Reach& reach) {
  alignas(PackedSlabs) float limit[n_slab_packs * slab_lanes] = {};
  for (int k = 0; k < n_slabs; ++k) {
    limit[k] = box.high(k) + reach.of(k);
    limit[n_slabs + k] = reach.of(k) - box.low(k);
  }
  PackedSlabs result;
  std::memcpy(&result, limit, sizeof result);
  return result;
}

// Pairs of a vertex and a slot of faces that overlap and share no vertex.
template <class Pairs>
LOOMSTONE_INLINE void meeting_vertices_faces(const VertexRun& a, const Run& b, const Lane& box_b,
                                             const Reach& reach, Pairs& out) {
  const PackedSlabs limits = limits_of(box_b, reach);
  for (Index slot = a.begin; slot < a.end && a.id[slot] >= 0; ++slot) {
    const Index vertex = a.id[slot];
    const PackedSlabs& own = a.boxes[vertex];
    Ints inside = own.pack[0] <= limits.pack[0];
    for (int i = 1; i < n_slab_packs; ++i) inside &= own.pack[i] <= limits.pack[i];
    if (bits_of(inside) != 0xffu) continue;
    const float* const value = reinterpret_cast<const float*>(&own);
    for (Index group = b.begin; group < b.end; ++group) {
      Ints meet = ~Ints{};
      for (int k = 0; k < n_slabs; ++k)
        meet_slab(meet, b.slabs[group], value[k] - reach.of(k), reach.of(k) - value[n_slabs + k],
                  k);
      for (int l = 0; l < 3; ++l) {
        Ints corner;
        load(corner, b.corners + (group * 3 + l) * slab_lanes);
        meet &= corner != vertex;
      }
      for (unsigned found = bits_of(meet); found != 0; found &= found - 1)
        out.emplace_back(vertex, slab_lanes * group + __builtin_ctz(found));
    }
  }
}

// For every lane of a the lanes of b that overlap it.
LOOMSTONE_CLONES void meeting_children(const SlabGroup& a, const SlabGroup& b, unsigned* meeting) {
  for (int lane = 0; lane < slab_lanes; ++lane)
    meeting[lane] =
        a.low[0][lane] <= a.high[0][lane] ? overlapping_lanes(b, {&a, lane}, Reach(0.0)) : 0u;
}

LOOMSTONE_CLONES unsigned meeting_lanes(const SlabGroup& group, const Lane& box) {
  return overlapping_lanes(group, box, Reach(0.0));
}

LOOMSTONE_CLONES void meeting_features(const VertexRun& vertices_a, const Run& faces_a,
                                       const Run& edges_a, const Lane& box_a,
                                       const VertexRun& vertices_b, const Run& faces_b,
                                       const Run& edges_b, const Lane& box_b, const Reach& reach,
                                       bool same, PairSearch::Slots& out) {
  meeting_vertices_faces(vertices_a, faces_b, box_b, reach, out.vertex_face);
  if (!same) meeting_vertices_faces(vertices_b, faces_a, box_a, reach, out.face_vertex);
  meeting_edges(edges_a, box_a, edges_b, box_b, reach, same, out.edge_edge);
}

}  // namespace

void PairSearch::expand(const Nodes& nodes, std::vector<Nodes>& out) const {
  const int level_a = nodes.level_a - 1, level_b = nodes.level_b - 1;
  // Pushed from the last lane down, so that the first pair comes off the stack first.
  if (level_a == level_b) {
    unsigned meeting[slab_lanes];
    meeting_children(a_->children(nodes.level_a, nodes.a), b_->children(nodes.level_b, nodes.b),
                     meeting);
    const bool same = self_ && nodes.a == nodes.b;
    for (int i = slab_lanes - 1; i >= 0; --i)
      for (int j = slab_lanes - 1; j >= (same ? i : 0); --j)
        if ((meeting[i] >> j) & 1u)
          out.push_back({level_a, level_b, slab_lanes * nodes.a + i, slab_lanes * nodes.b + j});
  } else if (level_a > level_b) {
    const unsigned lanes =
        meeting_lanes(a_->children(nodes.level_a, nodes.a),
                      {&b_->boxes(nodes.level_b, nodes.b), nodes.b % slab_lanes});
    for (int i = slab_lanes - 1; i >= 0; --i)
      if ((lanes >> i) & 1u)
        out.push_back({level_a, nodes.level_b, slab_lanes * nodes.a + i, nodes.b});
  } else {
    const unsigned lanes =
        meeting_lanes(b_->children(nodes.level_b, nodes.b),
                      {&a_->boxes(nodes.level_a, nodes.a), nodes.a % slab_lanes});
    for (int j = slab_lanes - 1; j >= 0; --j)
      if ((lanes >> j) & 1u)
        out.push_back({nodes.level_a, level_b, nodes.a, slab_lanes * nodes.b + j});
  }
}

void PairSearch::meeting_slots(Index a, Index b, double reach, Slots& out) const {
  const auto box = [](const ClusterTree& tree, Index cluster) {
    return Lane{&tree.leaf_boxes(cluster), cluster % slab_lanes};
  };
  meeting_features(VertexRun(*a_, a), Run(a_->faces(), a), Run(a_->edges(), a), box(*a_, a),
                   VertexRun(*b_, b), Run(b_->faces(), b), Run(b_->edges(), b), box(*b_, b),
                   Reach(reach), self_ && a == b, out);
}

}  // namespace loomstone
