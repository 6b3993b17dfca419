#include "core/collision/broad_phase/shared_refit.h"

#include <algorithm>
#include <numeric>

namespace loomstone {

// Smallest number of clusters of a surface for which ranks divide the clusters among themselves. If
// a surface has fewer clusters, every rank computes the boxes of all of them. Our choice.
constexpr Index worth_sharing = 128;

SharedRefit::SharedRefit(const CollisionModel& model, BroadPhase& broad_phase,
                         const Communicator& ranks)
    : broad_phase_(broad_phase),
      ranks_(ranks),
      surfaces_(model.surfaces.size()),
      set_(model.n_vertices) {}

bool SharedRefit::other_trees() const {
  for (std::size_t s = 0; s < surfaces_.size(); ++s)
    if (broad_phase_.tree(static_cast<Index>(s)).version() != surfaces_[s].version) return true;
  return false;
}

bool SharedRefit::shared(Index surface) const {
  return ranks_.size() > 1 && broad_phase_.tree(surface).n_clusters() >= worth_sharing;
}

// Returns the clusters whose boxes a rank computes.
IndexRange SharedRefit::share(Index surface, int rank) const {
  const Index n = broad_phase_.tree(surface).n_clusters();
  return shared(surface) ? even_share(n, rank, ranks_.size()) : IndexRange{0, n};
}

void SharedRefit::find_members(Index surface) {
  const ClusterTree& tree = broad_phase_.tree(surface);
  Surface& own = surfaces_[surface];
  own.members = ClusterMembers(tree);
  const IndexRange clusters = share(surface, ranks_.rank());
  set_.clear();
  for (Index c = clusters.begin; c < clusters.end; ++c)
    own.members.each(c, [&](Index v) { set_.add(v); });
  own.vertices = set_.vertices();
}

void SharedRefit::form(Index surface, const Points& x) {
  broad_phase_.tree(surface).form(x);
  find_members(surface);
}

// Collective. Sets Surface::boxes of the surfaces `which` to the boxes of all clusters. Computes
// them from the vertex boxes that `box` returns.
void SharedRefit::find_boxes(const Team& team, const std::vector<Index>& which,
                             const VertexBox& box) {
  VertexBoxes& vertices = broad_phase_.vertex_boxes();
  results_of_ranks(ranks_, [&] {
    for (const Index s : which) {
      const ClusterTree& tree = broad_phase_.tree(s);
      Surface& own = surfaces_[s];
      vertices.begin();
      vertices.add(own.vertices);
      parallel_for(
          team, static_cast<Index>(own.vertices.size()),
          [&](Index i) { vertices[own.vertices[i]] = box(s, own.vertices[i]); }, 1024);
      const IndexRange clusters = share(s, ranks_.rank());
      own.boxes.resize(tree.n_slots(), empty_packed());
      tree.find_boxes(team, vertices, clusters.begin, clusters.end, own.boxes);
    }
    return true;
  });
  std::vector<std::size_t> offsets(ranks_.size() + 1);
  for (const Index s : which) {
    if (!shared(s)) continue;
    for (int rank = 0; rank < ranks_.size(); ++rank)
      offsets[rank + 1] = sizeof(PackedSlabs) * static_cast<std::size_t>(share(s, rank).end);
    ranks_.gather_all(surfaces_[s].boxes.data(), offsets);
  }
}

std::vector<std::uint8_t> SharedRefit::refit(const Team& team, const Points& x,
                                             const VertexBox& moving, bool may_rebuild) {
  const VertexBox still = [&](Index, Index v) {
    const double* const at = x.data() + 3 * static_cast<std::size_t>(v);
    return packed(slabs_of(at, at, 0.0));
  };
  std::vector<Index> formed, grown, all;
  for (Index s = 0; s < static_cast<Index>(surfaces_.size()); ++s) {
    const ClusterTree& tree = broad_phase_.tree(s);
    if (tree.empty()) continue;
    all.push_back(s);
    if (!tree.formed())
      form(s, x), formed.push_back(s);
    else if (tree.version() != surfaces_[s].version)
      find_members(s);
  }
  if (may_rebuild) {
    find_boxes(team, all, still);
    for (const Index s : all) {
      const bool is_new = std::find(formed.begin(), formed.end(), s) != formed.end();
      if (is_new || !broad_phase_.tree(s).has_grown(surfaces_[s].boxes, 0.0)) continue;
      form(s, x), formed.push_back(s);
    }
  }
  if (!formed.empty()) {
    find_boxes(team, formed, still);
    for (const Index s : formed) broad_phase_.tree(s).set_area(surfaces_[s].boxes, 0.0);
  }
  find_boxes(team, all, moving);
  std::vector<std::uint8_t> changed(surfaces_.size(), 0);
  for (const Index s : all) {
    ClusterTree& tree = broad_phase_.tree(s);
    tree.set_nodes(team, surfaces_[s].boxes);
    surfaces_[s].boxes = std::vector<PackedSlabs>();  // frees the memory
    changed[s] = tree.version() != surfaces_[s].version;
    surfaces_[s].version = tree.version();
  }
  return changed;
}

}  // namespace loomstone
