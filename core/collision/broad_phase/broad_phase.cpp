#include "core/collision/broad_phase/broad_phase.h"

#include <algorithm>
#include <limits>

#include "core/collision/broad_phase/pair_search.h"
#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

namespace {

// Pairs of nodes are expanded from the roots until there are at least this many pairs, or only
// pairs of leaves. Each of these pairs is a task. The value does not depend on the number of
// threads. A search therefore has the same tasks, with the same indices, for any number of threads.
constexpr std::size_t enough_tasks = 256;

// Maximum number of pairs in a batch that is passed to the sink.
constexpr std::size_t batch_size = 1024;

constexpr IndexRange all_clusters{0, std::numeric_limits<Index>::max()};

// Collects feature pairs. The filter is called for each batch and removes unwanted pairs from it.
template <class Filter>
class Kept : public PairSink {
 public:
  explicit Kept(Filter filter) : filter_(std::move(filter)) {}

  void prepare(Index n_tasks) override { tasks_.assign(n_tasks, {}); }
  void take(Index task, Index pair, ContactKind kind, std::vector<PairKey>& keys) override {
    filter_(pair, kind, keys);
    Task& own = tasks_[task];
    own.pair = pair;
    std::vector<PairKey>& kept =
        kind == ContactKind::VertexFace ? own.found.vertex_face : own.found.edge_edge;
    kept.insert(kept.end(), keys.begin(), keys.end());
  }

  // Writes the sorted feature pairs of each surface pair in `which` to `found`.
  void into(const std::vector<Index>& which, std::size_t n_pairs,
            std::vector<FeaturePairs>& found) const {
    found.resize(n_pairs);
    for (const Index pair : which) found[pair] = {};
    for (const Task& task : tasks_) {
      FeaturePairs& all = found[task.pair];
      all.vertex_face.insert(all.vertex_face.end(), task.found.vertex_face.begin(),
                             task.found.vertex_face.end());
      all.edge_edge.insert(all.edge_edge.end(), task.found.edge_edge.begin(),
                           task.found.edge_edge.end());
    }
    for (const Index pair : which) {
      std::sort(found[pair].vertex_face.begin(), found[pair].vertex_face.end());
      std::sort(found[pair].edge_edge.begin(), found[pair].edge_edge.end());
    }
  }

 private:
  struct Task {
    Index pair = 0;
    FeaturePairs found;
  };
  Filter filter_;
  std::vector<Task> tasks_;
};

}  // namespace

BroadPhase::BroadPhase(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                       TaskShare share)
    : model_(model), pairs_(pairs), vertex_boxes_(model.n_vertices), share_(share) {
  for (std::size_t s = 0; s < model.surfaces.size(); ++s)
    trees_.emplace_back(model, static_cast<Index>(s));
}

// Returns whether this object performs all tasks and `which` includes self-collisions of a surface.
// Such a search compares each cluster of the surface at least with itself, so it needs all features
// of the surface.
bool BroadPhase::compares_all(const std::vector<Index>& which) const {
  return share_.size == 1 && std::any_of(which.begin(), which.end(), [&](Index pair) {
           return pairs_[pair].a == pairs_[pair].b;
         });
}

// Refits a tree. If `features` is false, refits only its nodes, because the search then refits the
// features that it compares.
void BroadPhase::refit(const Team& team, Index s, const Sweep& sweep, bool features) {
  const CollisionSurface& surface = model_.surfaces[s];
  vertex_boxes_.add(surface.first_vertex, surface.n_vertices);
  parallel_for(
      team, surface.n_vertices,
      [&](Index i) {
        const std::size_t v = surface.first_vertex + i;
        vertex_boxes_[static_cast<Index>(v)] =
            packed(slabs_of(sweep.x0.data() + 3 * v, sweep.x1.data() + 3 * v, sweep.inflation));
      },
      2048);
  if (features)
    trees_[s].refit(team, sweep.x0, vertex_boxes_, sweep.inflation, sweep.may_rebuild);
  else
    trees_[s].refit_nodes(team, sweep.x0, vertex_boxes_, sweep.inflation, sweep.may_rebuild);
}

bool BroadPhase::attached(ContactKind kind, PairKey key) const {
  return !model_.attached.empty() &&
         attached_distance(model_, kind, pair_vertices(model_, kind, key)) == 0.0;
}

struct BroadPhase::Task {
  Index pair;
  PairSearch search;
  PairSearch::Nodes nodes;
};

// Returns the tasks of a search: pairs of nodes that result from expanding the pairs of roots.
// `first` is a range of clusters of the first tree. Expansion omits a pair if its node of the first
// tree contains no cluster of this range.
std::vector<BroadPhase::Task> BroadPhase::deal_out(const std::vector<Index>& which,
                                                   IndexRange first) const {
  std::vector<Task> tasks, next;
  for (const Index pair : which) {
    const ClusterTree &a = trees_[pairs_[pair].a], &b = trees_[pairs_[pair].b];
    if (a.empty() || b.empty() || !overlapping(a.root(), b.root())) continue;
    const PairSearch search(a, b);
    tasks.push_back({pair, search, search.roots()});
  }
  std::vector<PairSearch::Nodes> below;
  for (bool any = true; any && tasks.size() < enough_tasks; tasks.swap(next)) {
    any = false;
    next.clear();
    for (const Task& task : tasks) {
      if (PairSearch::leaves(task.nodes)) {
        next.push_back(task);
        continue;
      }
      any = true;
      below.clear();
      task.search.expand(task.nodes, below);
      for (const PairSearch::Nodes& nodes : below)
        if (PairSearch::meets(nodes, first)) next.push_back({task.pair, task.search, nodes});
    }
  }
  return tasks;
}

std::vector<PairKey> BroadPhase::cluster_pairs(const Team& team, Index surface_pair,
                                               IndexRange first, std::size_t most) const {
  if (first.begin >= first.end) return {};
  const std::vector<Task> tasks = deal_out({surface_pair}, first);
  std::vector<std::vector<PairKey>> of_task(tasks.size());
  parallel_tasks(team, static_cast<Index>(tasks.size()), [&](Index i) {
    std::vector<PairKey>& own = of_task[i];
    tasks[i].search.clusters(tasks[i].nodes, first, [&](Index a, Index b) {
      if (own.size() <= most) own.push_back(pair_key(a, b));
    });
  });
  // Counting sort by the first cluster. std::sort then orders pairs with the same first cluster by
  // the second one.
  const Index n_clusters = first.end - first.begin;
  std::vector<Index> start(n_clusters + 1, 0);
  for (const std::vector<PairKey>& own : of_task)
    for (const PairKey key : own) ++start[first_of(key) - first.begin + 1];
  for (Index c = 0; c < n_clusters; ++c) start[c + 1] += start[c];
  std::vector<PairKey> found(start.back());
  std::vector<Index> next(start.begin(), start.end() - 1);
  for (const std::vector<PairKey>& own : of_task)
    for (const PairKey key : own) found[next[first_of(key) - first.begin]++] = key;
  parallel_for(team, n_clusters,
               [&](Index c) { std::sort(found.begin() + start[c], found.begin() + start[c + 1]); });
  return found;
}

// Returns for each task the pairs of clusters whose boxes overlap, and refits the features of these
// clusters.
std::vector<std::vector<PairKey>> BroadPhase::clusters_of(const Team& team,
                                                          const std::vector<Task>& tasks) {
  std::vector<std::vector<PairKey>> found(tasks.size());
  parallel_tasks(team, static_cast<Index>(tasks.size()), [&](Index i) {
    tasks[i].search.clusters(tasks[i].nodes, all_clusters,
                             [&](Index a, Index b) { found[i].push_back(pair_key(a, b)); });
  });
  std::vector<std::vector<std::uint8_t>> marked;
  for (const ClusterTree& tree : trees_) marked.emplace_back(tree.n_clusters(), 0);
  for (std::size_t i = 0; i < tasks.size(); ++i)
    for (const PairKey clusters : found[i]) {
      marked[pairs_[tasks[i].pair].a][first_of(clusters)] = 1;
      marked[pairs_[tasks[i].pair].b][second_of(clusters)] = 1;
    }
  for (std::size_t s = 0; s < trees_.size(); ++s)
    trees_[s].refit_features_of(team, marked[s], vertex_boxes_);
  return found;
}

void BroadPhase::search(const Team& team, const std::vector<Index>& which, PairSink& sink) {
  std::vector<Task> tasks = deal_out(which, all_clusters);
  std::size_t n_own = 0;
  for (std::size_t i = share_.rank; i < tasks.size(); i += share_.size) tasks[n_own++] = tasks[i];
  tasks.erase(tasks.begin() + static_cast<std::ptrdiff_t>(n_own), tasks.end());
  const bool at_once = compares_all(which);  // all features have been refitted
  const std::vector<std::vector<PairKey>> clusters =
      at_once ? std::vector<std::vector<PairKey>>() : clusters_of(team, tasks);
  sink.prepare(static_cast<Index>(tasks.size()));
  parallel_tasks(team, static_cast<Index>(tasks.size()), [&](Index i) {
    const Index pair = tasks[i].pair;
    FeaturePairs batch;
    batch.vertex_face.reserve(batch_size);
    batch.edge_edge.reserve(batch_size);
    const auto send = [&](ContactKind kind, std::vector<PairKey>& keys) {
      sink.take(i, pair, kind, keys);
      keys.clear();
    };
    const auto take = [&](ContactKind kind, Index a, Index b) {
      const PairKey key = pair_key(a, b);
      if (attached(kind, key)) return;
      std::vector<PairKey>& keys =
          kind == ContactKind::VertexFace ? batch.vertex_face : batch.edge_edge;
      keys.push_back(key);
      if (keys.size() == batch_size) send(kind, keys);
    };
    PairSearch::Slots slots;
    const auto compare = [&](Index a, Index b) {
      tasks[i].search.features(a, b, 0.0, slots, take);
    };
    if (at_once)
      tasks[i].search.clusters(tasks[i].nodes, all_clusters, compare);
    else
      for (const PairKey both : clusters[i]) compare(first_of(both), second_of(both));
    if (!batch.vertex_face.empty()) send(ContactKind::VertexFace, batch.vertex_face);
    if (!batch.edge_edge.empty()) send(ContactKind::EdgeEdge, batch.edge_edge);
  });
}

std::size_t BroadPhase::bytes() const {
  std::size_t sum = bytes_of(vertex_boxes_);
  for (const ClusterTree& tree : trees_) sum += tree.bytes();
  return sum;
}

void BroadPhase::forget_trees() {
  for (ClusterTree& tree : trees_) tree.forget();
}

void BroadPhase::near_pairs(const Team& team, const Points& x, const std::vector<Index>& which,
                            const std::vector<double>& reach, std::vector<FeaturePairs>& found) {
  // Inflates the boxes of each surface by half the largest reach of its surface pairs in `which`.
  std::vector<double> inflation(trees_.size(), -1.0);
  for (const Index pair : which)
    for (const Index s : {pairs_[pair].a, pairs_[pair].b})
      inflation[s] = std::max(inflation[s], 0.5 * reach[pair]);
  vertex_boxes_.begin();
  for (std::size_t s = 0; s < trees_.size(); ++s)
    if (inflation[s] >= 0.0)
      refit(team, static_cast<Index>(s), {x, x, inflation[s]}, compares_all(which));
  Kept kept([&](Index pair, ContactKind kind, std::vector<PairKey>& keys) {
    std::erase_if(keys, [&](PairKey key) {
      const std::array<Index, 4> v = pair_vertices(model_, kind, key);
      FourPoints p;
      for (int i = 0; i < 4; ++i) p[i] = x.row(v[i]).transpose();
      return !(distance_within(kind == ContactKind::VertexFace, p, reach[pair]) <= reach[pair]);
    });
  });
  search(team, which, kept);
  kept.into(which, pairs_.size(), found);
}

void BroadPhase::swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                             PairSink& sink) {
  std::vector<std::uint8_t> needed(trees_.size(), 0);
  for (const Index pair : which) needed[pairs_[pair].a] = needed[pairs_[pair].b] = 1;
  vertex_boxes_.begin();
  for (std::size_t s = 0; s < trees_.size(); ++s)
    if (needed[s]) refit(team, static_cast<Index>(s), sweep, compares_all(which));
  search(team, which, sink);
}

void BroadPhase::swept_pairs(const Team& team, const Sweep& sweep, const std::vector<Index>& which,
                             const Keep& keep, std::vector<FeaturePairs>& found) {
  Kept kept([&](Index, ContactKind kind, std::vector<PairKey>& keys) { keep(kind, keys); });
  swept_pairs(team, sweep, which, kept);
  kept.into(which, pairs_.size(), found);
}

}  // namespace loomstone
