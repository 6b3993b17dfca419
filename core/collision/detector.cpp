#include "core/collision/detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/message.h"
#include "core/base/sort_unique.h"
#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/narrow_phase/exact_continuous.h"
#include "core/collision/narrow_phase/separation.h"

namespace loomstone {

namespace {

using Pairs = std::vector<std::array<Index, 2>>;

// Returns a model that consists of one cloth with self-collision.
CollisionModel one_surface(const Triangles& triangles) {
  CollisionModel model;
  model.n_vertices = triangles.rows() > 0 ? triangles.maxCoeff() + 1 : 0;
  model.triangles = triangles;
  model.edges = unique_edges(triangles);
  CollisionSurface surface;
  surface.n_vertices = model.n_vertices;
  surface.n_triangles = static_cast<Index>(triangles.rows());
  model.surfaces.push_back(surface);
  return model;
}

// Concatenates the results of all tasks in task order.
template <class Element, class Member>
std::vector<Element> joined(const Team& team, std::size_t n_tasks, Member&& member) {
  std::vector<std::size_t> offset(n_tasks + 1, 0);
  for (std::size_t i = 0; i < n_tasks; ++i) offset[i + 1] = offset[i] + member(i).size();
  std::vector<Element> all(offset[n_tasks]);
  parallel_tasks(team, static_cast<Index>(n_tasks), [&](Index i) {
    std::copy(member(i).begin(), member(i).end(),
              all.begin() + static_cast<std::ptrdiff_t>(offset[i]));
  });
  return all;
}

// Sorts pairs lexicographically: counting sort by the first id, then std::sort of the pairs with
// the same first id.
void sort_pairs(const Team& team, Pairs& pairs, Index n_first) {
  std::vector<std::size_t> start(n_first + 1, 0);
  for (const auto& pair : pairs) ++start[pair[0] + 1];
  for (Index i = 0; i < n_first; ++i) start[i + 1] += start[i];
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  Pairs sorted(pairs.size());
  for (const auto& pair : pairs) sorted[next[pair[0]]++] = pair;
  parallel_for(team, n_first, [&](Index i) {
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(start[i]),
              sorted.begin() + static_cast<std::ptrdiff_t>(start[i + 1]));
  });
  pairs.swap(sorted);
}

class AllPairs : public PairSink {
 public:
  void prepare(Index n_tasks) override { tasks_.assign(n_tasks, {}); }
  void take(Index task, Index, ContactKind kind, std::vector<PairKey>& keys) override {
    Pairs& out =
        kind == ContactKind::VertexFace ? tasks_[task].vertex_face : tasks_[task].edge_edge;
    for (const PairKey key : keys) out.push_back({first_of(key), second_of(key)});
  }
  FeatureIds all(const Team& team) const {
    return {joined<std::array<Index, 2>>(
                team, tasks_.size(),
                [&](std::size_t i) -> const Pairs& { return tasks_[i].vertex_face; }),
            joined<std::array<Index, 2>>(team, tasks_.size(), [&](std::size_t i) -> const Pairs& {
              return tasks_[i].edge_edge;
            })};
  }

 private:
  std::vector<FeatureIds> tasks_;
};

struct Hit {
  std::array<Index, 2> pair;
  double time;
};

// Tests each batch of candidates on arrival, so that the candidates are never all stored at once.
class ExactHits : public PairSink {
 public:
  ExactHits(const CollisionModel& model, const Points& x0, const Points& x1)
      : model_(model), x0_(x0), x1_(x1) {}

  void prepare(Index n_tasks) override { tasks_.assign(n_tasks, {}); }
  void take(Index task, Index, ContactKind kind, std::vector<PairKey>& keys) override {
    const bool vertex_face = kind == ContactKind::VertexFace;
    const Index n = static_cast<Index>(keys.size());
    std::vector<std::array<Index, 4>> vertices(n);
    for (Index i = 0; i < n; ++i) vertices[i] = pair_vertices(model_, kind, keys[i]);
    const auto point = [&](Index i, int k) {
      return (k < 4 ? x0_ : x1_).data() + 3 * static_cast<std::size_t>(vertices[i][k % 4]);
    };
    std::vector<Hit>& hits = vertex_face ? tasks_[task].vertex_face : tasks_[task].edge_edge;
    without_separated(vertex_face, n, point, [&](Index i) {
      MovingPoints q;
      for (int k = 0; k < 8; ++k) q[k] = Eigen::Map<const Vec3>(point(i, k));
      const ExactImpact impact =
          vertex_face ? exact_continuous_vertex_face(q) : exact_continuous_edge_edge(q);
      if (impact.hit) hits.push_back({{first_of(keys[i]), second_of(keys[i])}, impact.time});
    });
  }
  Collisions all(const Team& team) const {
    Collisions all;
    sorted(joined<Hit>(
               team, tasks_.size(),
               [&](std::size_t i) -> const std::vector<Hit>& { return tasks_[i].vertex_face; }),
           all.pairs.vertex_face, all.vertex_face_time);
    sorted(
        joined<Hit>(team, tasks_.size(),
                    [&](std::size_t i) -> const std::vector<Hit>& { return tasks_[i].edge_edge; }),
        all.pairs.edge_edge, all.edge_edge_time);
    return all;
  }

 private:
  struct Task {
    std::vector<Hit> vertex_face, edge_edge;
  };

  static void sorted(std::vector<Hit> hits, Pairs& pairs, std::vector<double>& times) {
    std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.pair < b.pair; });
    for (const Hit& hit : hits) {
      pairs.push_back(hit.pair);
      times.push_back(hit.time);
    }
  }

  const CollisionModel& model_;
  const Points &x0_, &x1_;
  std::vector<Task> tasks_;
};

}  // namespace

double Collisions::time() const {
  double least = std::numeric_limits<double>::infinity();
  for (const double t : vertex_face_time) least = std::min(least, t);
  for (const double t : edge_edge_time) least = std::min(least, t);
  return least;
}

struct Detector::Data {
  explicit Data(const Triangles& triangles)
      : model(one_surface(triangles)), pairs(surface_pairs(model)), broad_phase(model, pairs) {}

  void check(const Points& x0, const Points& x1, double inflation) const {
    check_motion(x0, x1, inflation);
    if (x0.rows() < model.n_vertices)
      check_triangles(model.triangles, static_cast<Index>(x0.rows()));
  }

  const CollisionModel model;
  const std::vector<SurfacePair> pairs;
  BroadPhase broad_phase;
};

Detector::Detector(const Triangles& triangles) {
  check_triangles(triangles, std::numeric_limits<Index>::max());
  data_ = std::make_unique<Data>(triangles);
}
Detector::Detector(Detector&&) noexcept = default;
Detector::~Detector() = default;

const Edges& Detector::edges() const { return data_->model.edges; }

FeatureIds Detector::candidates(const Team& team, const Points& x0, const Points& x1,
                                double inflation, bool sorted) {
  data_->check(x0, x1, inflation);
  AllPairs found;
  data_->broad_phase.swept_pairs(team, {x0, x1, inflation, true}, {0}, found);
  FeatureIds all = found.all(team);
  if (sorted) {
    sort_pairs(team, all.vertex_face, data_->model.n_vertices);
    sort_pairs(team, all.edge_edge, static_cast<Index>(edges().rows()));
  }
  return all;
}

Collisions Detector::collisions(const Team& team, const Points& x0, const Points& x1) {
  data_->check(x0, x1, 0.0);
  ExactHits found(data_->model, x0, x1);
  data_->broad_phase.swept_pairs(team, {x0, x1, 0.0, true}, {0}, found);
  return found.all(team);
}

void Detector::forget_trees() { data_->broad_phase.forget_trees(); }
std::size_t Detector::tree_bytes() const { return data_->broad_phase.bytes(); }

Edges unique_edges(const Triangles& triangles) {
  Pairs pairs;
  pairs.reserve(3 * triangles.rows());
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles(t, k), b = triangles(t, (k + 1) % 3);
      pairs.push_back({std::min(a, b), std::max(a, b)});
    }
  sort_unique(pairs);
  Edges edges(pairs.size(), 2);
  for (std::size_t e = 0; e < pairs.size(); ++e) edges.row(e) << pairs[e][0], pairs[e][1];
  return edges;
}

void check_motion(const Points& x0, const Points& x1, double inflation, const char* name) {
  if (x1.rows() != x0.rows())
    fail<InvalidInput>("x1 must have as many rows as x0 ({}), got {}", x0.rows(), x1.rows());
  if (!(inflation >= 0.0) || !std::isfinite(inflation))
    fail<InvalidInput>("{} must be at least 0 m and finite, got {}", name, inflation);
  if (x0.allFinite() && x1.allFinite()) return;
  for (Index i = 0; i < x0.rows(); ++i)
    if (!x0.row(i).allFinite() || !x1.row(i).allFinite())
      fail<InvalidInput>("positions must be finite, but vertex {} is not", i);
}

void check_triangles(const Triangles& triangles, Index n_vertices) {
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      if (triangles(t, k) < 0 || triangles(t, k) >= n_vertices)
        fail<InvalidInput>("triangles must hold vertex indices in [0, {}), but triangle {} has {}",
                           n_vertices, t, triangles(t, k));
}

}  // namespace loomstone
