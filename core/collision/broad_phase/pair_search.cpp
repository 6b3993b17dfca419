#include "core/collision/broad_phase/pair_search.h"

#include <algorithm>
#include <array>

#include "core/base/lane_bits.h"

namespace loomstone {

namespace {

// View of the slabs in one lane of a group.
struct Lane {
  const SlabGroup* group;
  int lane;

  float low(int k) const { return group->low[k][lane]; }
  float high(int k) const { return group->high[k][lane]; }
};

// Amounts by which the bounds of one of two boxes are moved outwards, so that the boxes overlap if
// their features are at most `distance` [m] apart. The directions of diagonal slabs are not
// normalised, so these slabs need a factor sqrt(2). A further factor of 1.000001 in both amounts
// and the outward rounding of slabs cover rounding errors.
struct Reach {
  float axis = 0.0f, diagonal = 0.0f;

  explicit Reach(double distance)
      : axis(static_cast<float>(distance * 1.000001)),
        diagonal(static_cast<float>(distance * 1.4142149766)) {}
  float of(int k) const { return k < n_axis_slabs ? axis : diagonal; }
};

// Factors and summands for widened(), which widens a packed box by a Reach and restores the sign of
// its negated upper bounds.
struct Widening {
  PackedSlabs sign = {}, change = {};

  explicit Widening(const Reach& reach) {
    for (int k = 0; k < n_slabs; ++k) {
      sign.value[k] = 1.0f, sign.value[n_slabs + k] = -1.0f;
      change.value[k] = -reach.of(k), change.value[n_slabs + k] = reach.of(k);
    }
  }
};

// Bounds of one box: nine lower bounds, nine upper bounds, then zeros.
struct alignas(32) Bounds {
  float value[n_slab_packs * slab_lanes];

  float low(int k) const { return value[k]; }
  float high(int k) const { return value[n_slabs + k]; }
};

template <class Floats>
LOOMSTONE_INLINE Bounds widened(const PackedSlabs& box, const Widening& widening) {
  Bounds bounds;
  for (int i = 0; i < n_slab_packs * slab_lanes; i += slab_lanes)
    lanes_store(bounds.value + i,
                lanes_load<Floats>(box.value + i) * lanes_load<Floats>(widening.sign.value + i) +
                    lanes_load<Floats>(widening.change.value + i));
  return bounds;
}

template <class Floats>
LOOMSTONE_INLINE void widen(const SlabGroup& group, const Reach& reach, SlabGroup& wide) {
  for (int k = 0; k < n_slabs; ++k) {
    lanes_store(wide.low[k], lanes_load<Floats>(group.low[k]) - reach.of(k));
    lanes_store(wide.high[k], lanes_load<Floats>(group.high[k]) + reach.of(k));
  }
}

// Returns a mask of the boxes of `group` whose slab k overlaps that of `box`.
template <class Floats, class AnyBox>
LOOMSTONE_INLINE MaskOf<Floats> meeting_slab(const SlabGroup& group, const AnyBox& box, int k) {
  return (lanes_load<Floats>(group.low[k]) <= box.high(k)) &
         (lanes_load<Floats>(group.high[k]) >= box.low(k));
}

// Returns a bit mask of the lanes of `group` that overlap a box. Compares diagonal slabs only if
// some lane overlaps the box along all three axes.
template <class Floats, class AnyBox>
LOOMSTONE_INLINE unsigned overlapping_lanes(const SlabGroup& group, const AnyBox& box) {
  MaskOf<Floats> meet = meeting_slab<Floats>(group, box, 0);
  for (int k = 1; k < n_axis_slabs; ++k) meet &= meeting_slab<Floats>(group, box, k);
  if (lanes_bits(meet) == 0) return 0;
  for (int k = n_axis_slabs; k < n_slabs; ++k) meet &= meeting_slab<Floats>(group, box, k);
  return lanes_bits(meet);
}

// Groups of features of one kind that belong to one cluster. They are numbered from 0.
struct Run {
  const SlabGroup* slabs;
  const Index* corners;
  Index n;           // number of groups
  Index first_slot;  // slot of the first lane of group 0

  Run(const ClusterTree::Features& features, Index cluster)
      : slabs(features.slabs.data() + features.first_slab[cluster]),
        n(features.group[cluster + 1] - features.group[cluster]),
        first_slot(slab_lanes * features.group[cluster]) {
    corners = features.corners.data() + static_cast<std::ptrdiff_t>(features.first_slab[cluster]) *
                                            features.n_corners * slab_lanes;
  }
  Index slot(Index group, int lane) const { return first_slot + slab_lanes * group + lane; }
};

// The vertices of one cluster and their boxes.
struct VertexRun {
  VertexBoxes::View boxes;
  const Index* id;
  Index begin, end;  // range of slots; id is -1 in empty slots

  VertexRun(const ClusterTree& tree, Index cluster)
      : boxes(tree.vertex_boxes()),
        id(tree.vertices().corners.data()),
        begin(slab_lanes * tree.vertices().group[cluster]),
        end(slab_lanes * tree.vertices().group[cluster + 1]) {}
};

// The features of a cluster and the box around them.
struct Side {
  VertexRun vertices;
  Run faces, edges;
  const PackedSlabs& box;

  Side(const ClusterTree& tree, Index cluster)
      : vertices(tree, cluster),
        faces(tree.faces(), cluster),
        edges(tree.edges(), cluster),
        box(tree.box(cluster)) {}
};

// One edge, stored in lane `box.lane` of group `group`.
struct Edge {
  Index group;
  Lane box;
  Index slot;
  std::array<Index, 2> ends;
};

// Groups of edges, with a bit mask of the lanes to test in each group.
struct MaskedGroups {
  static constexpr Index most = 8;
  Index n = 0;
  Index group[most];
  unsigned mask[most];
};

// Returns a mask of the eight edges in `corners`. It is true for edges without a vertex in `ends`.
template <class Floats>
LOOMSTONE_INLINE MaskOf<Floats> different(const Index* corners, const std::array<Index, 2>& ends) {
  const auto first = lanes_load<MaskOf<Floats>>(corners),
             second = lanes_load<MaskOf<Floats>>(corners + slab_lanes);
  return ((first != ends[0]) & (first != ends[1])) & ((second != ends[0]) & (second != ends[1]));
}

// For each edge in `groups` that overlaps edge `own` and shares no vertex with it, appends the pair
// of the slots of both edges. If `upper` is true, tests only slots after the slot of `own`.
template <class Floats, class Pairs>
LOOMSTONE_INLINE void meeting_groups(const Edge& own, const Run& run, const MaskedGroups& groups,
                                     bool upper, Pairs& out) {
  for (Index j = 0; j < groups.n; ++j) {
    const Index group = groups.group[j];
    if (upper && group < own.group) continue;
    MaskOf<Floats> meet = different<Floats>(run.corners + group * 2 * slab_lanes, own.ends);
    for (int k = 0; k < n_slabs; ++k) meet &= meeting_slab<Floats>(run.slabs[group], own.box, k);
    unsigned found = lanes_bits(meet) & groups.mask[j];
    if (upper && group == own.group) found &= ~((2u << own.box.lane) - 1u);
    for (; found != 0; found &= found - 1)
      out.emplace_back(own.slot, run.slot(group, __builtin_ctz(found)));
  }
}

// For each edge of a and edge of b that share no vertex and whose boxes overlap if one of them is
// widened by `reach`, appends the pair of their slots. First masks out edges that lie outside the
// box of the other cluster, which is also widened. If `upper` is true, a and b must be the same
// cluster, and each edge is paired only with edges in later slots.
template <class Floats, class Pairs>
LOOMSTONE_INLINE void meeting_edges(const Side& a, const Side& b, const Reach& reach, bool upper,
                                    Pairs& out) {
  const Run own = a.edges, other = b.edges;
  const Widening widening(reach);
  const Bounds box_a = widened<Floats>(a.box, widening), box_b = widened<Floats>(b.box, widening);
  for (Index first = 0; first < other.n; first += MaskedGroups::most) {
    MaskedGroups groups;
    for (Index j = first; j < std::min(first + MaskedGroups::most, other.n); ++j) {
      groups.group[groups.n] = j;
      groups.mask[groups.n] = overlapping_lanes<Floats>(other.slabs[j], box_a);
      groups.n += groups.mask[groups.n] != 0;
    }
    if (groups.n == 0) continue;
    for (Index i = 0; i < own.n; ++i) {
      unsigned lanes = overlapping_lanes<Floats>(own.slabs[i], box_b);
      if (lanes == 0) continue;
      SlabGroup wide;
      if (reach.axis > 0.0f) widen<Floats>(own.slabs[i], reach, wide);
      const SlabGroup& boxes = reach.axis > 0.0f ? wide : own.slabs[i];
      const Index* const ends = own.corners + i * 2 * slab_lanes;
      for (; lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        meeting_groups<Floats>(
            Edge{i, {&boxes, lane}, own.slot(i, lane), {ends[lane], ends[slab_lanes + lane]}},
            other, groups, upper, out);
      }
    }
  }
}

// Returns upper bounds for the components of packed boxes. A packed box overlaps `box`, widened by
// `reach`, if none of its components exceeds the corresponding bound.
LOOMSTONE_INLINE PackedSlabs limits_of(const PackedSlabs& box, const Reach& reach) {
  PackedSlabs limit = {};
  for (int k = 0; k < n_slabs; ++k) {
    limit.value[k] = reach.of(k) - box.value[n_slabs + k];
    limit.value[n_slabs + k] = reach.of(k) - box.value[k];
  }
  return limit;
}

template <class Floats>
LOOMSTONE_INLINE bool within(const PackedSlabs& box, const PackedSlabs& limits) {
  const auto inside = [&](int i) LOOMSTONE_INLINE_LAMBDA {
    return lanes_load<Floats>(box.value + slab_lanes * i) <=
           lanes_load<Floats>(limits.value + slab_lanes * i);
  };
  return lanes_bits(inside(0) & inside(1) & inside(2)) == 0xffu;
}

// For each vertex of a and each face of b without this vertex, appends the vertex and the slot of
// the face if their boxes overlap when one of them is widened by `reach`.
template <class Floats, class Pairs>
LOOMSTONE_INLINE void meeting_vertices_faces(const VertexRun& a, const Run& b,
                                             const PackedSlabs& box_b, const Reach& reach,
                                             Pairs& out) {
  const PackedSlabs limits = limits_of(box_b, reach);
  const Widening widening(reach);
  for (Index slot = a.begin; slot < a.end && a.id[slot] >= 0; ++slot) {
    const Index vertex = a.id[slot];
    const PackedSlabs& own = a.boxes[vertex];
    if (!within<Floats>(own, limits)) continue;
    const Bounds box = widened<Floats>(own, widening);
    for (Index group = 0; group < b.n; ++group) {
      const auto corner = [&](int l) LOOMSTONE_INLINE_LAMBDA {
        return lanes_load<MaskOf<Floats>>(b.corners + (group * 3 + l) * slab_lanes);
      };
      MaskOf<Floats> meet = (corner(0) != vertex) & (corner(1) != vertex) & (corner(2) != vertex);
      for (int k = 0; k < n_slabs; ++k) meet &= meeting_slab<Floats>(b.slabs[group], box, k);
      for (unsigned found = lanes_bits(meet); found != 0; found &= found - 1)
        out.emplace_back(vertex, b.slot(group, __builtin_ctz(found)));
    }
  }
}

// For each lane of group a, computes the bit mask of the lanes of group b that overlap it.
template <class Lanes>
LOOMSTONE_INLINE void meeting_children(const SlabGroup& a, const SlabGroup& b, unsigned* meeting) {
  for (int lane = 0; lane < slab_lanes; ++lane)
    meeting[lane] = a.low[0][lane] <= a.high[0][lane]
                        ? overlapping_lanes<FloatLanes<Lanes>>(b, Lane{&a, lane})
                        : 0u;
}

template <class Lanes>
LOOMSTONE_INLINE unsigned meeting_lanes(const SlabGroup& group, const Lane& box) {
  return overlapping_lanes<FloatLanes<Lanes>>(group, box);
}

template <class Lanes>
LOOMSTONE_INLINE void meeting_features(const Side& a, const Side& b, const Reach& reach, bool same,
                                       PairSearch::Slots& out) {
  using Floats = FloatLanes<Lanes>;
  meeting_vertices_faces<Floats>(a.vertices, b.faces, b.box, reach, out.vertex_face);
  if (!same) meeting_vertices_faces<Floats>(b.vertices, a.faces, a.box, reach, out.face_vertex);
  meeting_edges<Floats>(a, b, reach, same, out.edge_edge);
}

}  // namespace

void PairSearch::expand(const Nodes& nodes, std::vector<Nodes>& out) const {
  const int level_a = nodes.level_a - 1, level_b = nodes.level_b - 1;
  // Pushes the pairs in descending order of their nodes, so that a stack returns them in ascending
  // order.
  if (level_a == level_b) {
    unsigned meeting[slab_lanes];
    LOOMSTONE_WIDEST(meeting_children)
    (a_->children(nodes.level_a, nodes.a), b_->children(nodes.level_b, nodes.b), meeting);
    const bool same = self_ && nodes.a == nodes.b;
    for (int i = slab_lanes - 1; i >= 0; --i)
      for (int j = slab_lanes - 1; j >= (same ? i : 0); --j)
        if ((meeting[i] >> j) & 1u)
          out.push_back({level_a, level_b, slab_lanes * nodes.a + i, slab_lanes * nodes.b + j});
  } else if (level_a > level_b) {
    expand_a(nodes, out);
  } else {
    expand_b(nodes, out);
  }
}

void PairSearch::expand_a(const Nodes& nodes, std::vector<Nodes>& out) const {
  const unsigned lanes = LOOMSTONE_WIDEST(meeting_lanes)(
      a_->children(nodes.level_a, nodes.a),
      Lane{&b_->boxes(nodes.level_b, nodes.b), nodes.b % slab_lanes});
  for (int i = slab_lanes - 1; i >= 0; --i)
    if ((lanes >> i) & 1u)
      out.push_back({nodes.level_a - 1, nodes.level_b, slab_lanes * nodes.a + i, nodes.b});
}

void PairSearch::expand_b(const Nodes& nodes, std::vector<Nodes>& out) const {
  const unsigned lanes = LOOMSTONE_WIDEST(meeting_lanes)(
      b_->children(nodes.level_b, nodes.b),
      Lane{&a_->boxes(nodes.level_a, nodes.a), nodes.a % slab_lanes});
  for (int j = slab_lanes - 1; j >= 0; --j)
    if ((lanes >> j) & 1u)
      out.push_back({nodes.level_a, nodes.level_b - 1, nodes.a, slab_lanes * nodes.b + j});
}

void PairSearch::expand_larger(const Nodes& nodes, std::vector<Nodes>& out) const {
  const auto volume = [](const ClusterTree& tree, int level, Index node) {
    const SlabGroup& group = tree.boxes(level, node);
    const int lane = node % slab_lanes;
    float product = 1.0f;
    for (int k = 0; k < n_axis_slabs; ++k) product *= group.high[k][lane] - group.low[k][lane];
    return product;
  };
  const bool expands_a =
      nodes.level_b == 0 || (nodes.level_a > 0 && volume(*a_, nodes.level_a, nodes.a) >=
                                                      volume(*b_, nodes.level_b, nodes.b));
  if (expands_a)
    expand_a(nodes, out);
  else
    expand_b(nodes, out);
}

void PairSearch::meeting_slots(Index a, Index b, double reach, Slots& out) const {
  LOOMSTONE_WIDEST(meeting_features)
  (Side(*a_, a), Side(*b_, b), Reach(reach), self_ && a == b, out);
}

}  // namespace loomstone
