#include "core/collision/pair_search.h"

#include <algorithm>
#include <cstring>

#include "core/base/simd.h"

namespace loomstone {

namespace {

typedef float Floats __attribute__((vector_size(4 * slab_lanes)));
typedef std::int32_t Ints __attribute__((vector_size(4 * slab_lanes)));

template <class Vector, class Number>
LOOMSTONE_INLINE void load(Vector& v, const Number* p) {
  std::memcpy(&v, p, sizeof v);
}

LOOMSTONE_INLINE unsigned bits_of(const Ints& lanes) {
  const Ints marked = lanes & Ints{1, 2, 4, 8, 16, 32, 64, 128};
  std::uint64_t words[4];
  std::memcpy(words, &marked, sizeof words);
  const std::uint64_t all = (words[0] | words[1]) | (words[2] | words[3]);
  return static_cast<unsigned>(all | (all >> 32)) & 0xffu;
}

LOOMSTONE_INLINE void meet_slab(Ints& meet, const SlabGroup& group, const Slabs& slabs, int k) {
  Floats low, high;
  load(low, group.low[k]);
  load(high, group.high[k]);
  meet &= (low <= slabs.high[k]) & (high >= slabs.low[k]);
}

// Lanes of `group` that overlap `slabs`; the diagonals are looked at only where the axes leave something.
LOOMSTONE_INLINE unsigned overlapping_lanes(const SlabGroup& group, const Slabs& slabs) {
  Ints meet = ~Ints{};
  for (int k = 0; k < n_axis_slabs; ++k) meet_slab(meet, group, slabs, k);
  if (bits_of(meet) == 0) return 0;
  for (int k = n_axis_slabs; k < n_slabs; ++k) meet_slab(meet, group, slabs, k);
  return bits_of(meet);
}

// A run of groups of features of one kind.
struct Run {
  const SlabGroup* slabs;
  const Index* corners;
  Index begin, end;

  Run(const ClusterTree::Features& features, Index cluster)
      : slabs(features.slabs.data()), corners(features.corners.data()), begin(features.group[cluster]), end(features.group[cluster + 1]) {}
};

constexpr Index most_groups = 8;  // that are masked at once

// Pairs of slots of a and b that overlap and share no vertex. Features that miss the other cluster's box are masked first.
// `upper`: only slots of b after that of a.
template <int corners_a, int corners_b, class Slots>
LOOMSTONE_INLINE void meeting_slots(const Run& a, const Slabs& box_a, const Run& b, const Slabs& box_b, bool upper, Slots& out) {
  for (Index first = b.begin; first < b.end; first += most_groups) {
    const Index n_b = std::min<Index>(most_groups, b.end - first);
    unsigned mask_b[most_groups], any = 0;
    for (Index j = 0; j < n_b; ++j) any |= mask_b[j] = overlapping_lanes(b.slabs[first + j], box_a);
    if (any == 0) continue;
    for (Index i = a.begin; i < a.end; ++i) {
      for (unsigned lanes = overlapping_lanes(a.slabs[i], box_b); lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        const Slabs slabs = a.slabs[i].lane(lane);
        for (Index j = 0; j < n_b; ++j) {
          const Index group = first + j;
          if (mask_b[j] == 0 || (upper && group < i)) continue;
          Ints meet = ~Ints{};
          for (int k = 0; k < n_slabs; ++k) meet_slab(meet, b.slabs[group], slabs, k);
          for (int l = 0; l < corners_b; ++l) {
            Ints corner;
            load(corner, b.corners + (group * corners_b + l) * slab_lanes);
            for (int k = 0; k < corners_a; ++k) meet &= corner != a.corners[(i * corners_a + k) * slab_lanes + lane];
          }
          unsigned found = bits_of(meet) & mask_b[j];
          if (upper && group == i) found &= ~((2u << lane) - 1u);
          for (; found != 0; found &= found - 1) out.emplace_back(slab_lanes * i + lane, slab_lanes * group + __builtin_ctz(found));
        }
      }
    }
  }
}

// For every lane of a the lanes of b that overlap it.
LOOMSTONE_CLONES void meeting_children(const SlabGroup& a, const SlabGroup& b, unsigned* meeting) {
  for (int lane = 0; lane < slab_lanes; ++lane)
    meeting[lane] = a.low[0][lane] <= a.high[0][lane] ? overlapping_lanes(b, a.lane(lane)) : 0u;
}

LOOMSTONE_CLONES unsigned meeting_lanes(const SlabGroup& group, const Slabs& box) { return overlapping_lanes(group, box); }

using SlotPairs = std::vector<std::pair<Index, Index>>;

LOOMSTONE_CLONES void meeting_vertices_faces(const Run& a, const Slabs& box_a, const Run& b, const Slabs& box_b, SlotPairs& out) {
  meeting_slots<1, 3>(a, box_a, b, box_b, false, out);
}
LOOMSTONE_CLONES void meeting_edges(const Run& a, const Slabs& box_a, const Run& b, const Slabs& box_b, bool upper, SlotPairs& out) {
  meeting_slots<2, 2>(a, box_a, b, box_b, upper, out);
}

}  // namespace

void PairSearch::expand(const Nodes& nodes, std::vector<Nodes>& out) const {
  const int level_a = nodes.level_a - 1, level_b = nodes.level_b - 1;
  // Pushed from the last lane down, so that the first pair comes off the stack first.
  if (level_a == level_b) {
    unsigned meeting[slab_lanes];
    meeting_children(a_->children(nodes.level_a, nodes.a), b_->children(nodes.level_b, nodes.b), meeting);
    const bool same = self_ && nodes.a == nodes.b;
    for (int i = slab_lanes - 1; i >= 0; --i)
      for (int j = slab_lanes - 1; j >= (same ? i : 0); --j)
        if ((meeting[i] >> j) & 1u) out.push_back({level_a, level_b, slab_lanes * nodes.a + i, slab_lanes * nodes.b + j});
  } else if (level_a > level_b) {
    const unsigned lanes = meeting_lanes(a_->children(nodes.level_a, nodes.a), b_->box(nodes.level_b, nodes.b));
    for (int i = slab_lanes - 1; i >= 0; --i)
      if ((lanes >> i) & 1u) out.push_back({level_a, nodes.level_b, slab_lanes * nodes.a + i, nodes.b});
  } else {
    const unsigned lanes = meeting_lanes(b_->children(nodes.level_b, nodes.b), a_->box(nodes.level_a, nodes.a));
    for (int j = slab_lanes - 1; j >= 0; --j)
      if ((lanes >> j) & 1u) out.push_back({nodes.level_a, level_b, nodes.a, slab_lanes * nodes.b + j});
  }
}

void PairSearch::vertex_face_slots(const Leaf& a, const Leaf& b, Slots& out) {
  meeting_vertices_faces(Run(a.tree.vertices(), a.cluster), a.box, Run(b.tree.faces(), b.cluster), b.box, out);
}

void PairSearch::edge_edge_slots(const Leaf& a, const Leaf& b, bool upper, Slots& out) {
  meeting_edges(Run(a.tree.edges(), a.cluster), a.box, Run(b.tree.edges(), b.cluster), b.box, upper, out);
}

}  // namespace loomstone
