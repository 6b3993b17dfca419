// Tests of the broad phase: the engines `brute-force`, `clusters` and `embree` find the same pairs,
// which include all close pairs. The shape of the tree and the numbers of threads and ranks do not
// affect the result.
#include <catch2/catch.hpp>

#include <set>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/candidates.h"
#include "core/collision/narrow_phase/distance.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;

namespace {

// Returns the vertices of a sheet crumpled into a small volume, so that all its parts are close to
// each other. Each coordinate has a random part of up to `size` [m].
Points crumpled(const TriangleMesh& mesh, unsigned seed, double size) {
  std::mt19937 random(seed);
  Points x = mesh.vertices();
  for (Index i = 0; i < x.rows(); ++i)
    x.row(i) = Eigen::RowVector3d(std::sin(19 * x(i, 0)), std::cos(23 * x(i, 1)),
                                  std::sin(31 * (x(i, 0) + x(i, 1)))) *
                   0.05 +
               random_vector(random, size).transpose();
  return x;
}

}  // namespace

TEST_CASE("the engines find the same pairs") {
  std::size_t n_pairs = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const TriangleMesh mesh = grid_cells(0.3, 0.2, 5 + 3 * seed, 7);
    const Points x0 = crumpled(mesh, seed, 0.002 * seed),
                 x1 = crumpled(mesh, seed + 10, 0.002 * seed);
    const double inflation = seed % 2 ? 0.0 : 1e-3;
    const Candidates expected =
        candidates(Team{1}, x0, x1, mesh.triangles(), inflation, "brute-force");
    n_pairs += expected.vertex_face.size() + expected.edge_edge.size();
    for (const char* engine : {"clusters", "embree"})
      for (const int threads : {1, 3}) {
        const Candidates found =
            candidates(Team{threads}, x0, x1, mesh.triangles(), inflation, engine);
        CHECK(found.vertex_face == expected.vertex_face);
        CHECK(found.edge_edge == expected.edge_edge);
      }
  }
  CHECK(n_pairs > 10000);
}

TEST_CASE("pairs that come closer than twice the inflation are among the candidates") {
  const TriangleMesh mesh = grid_cells(0.3, 0.3, 8, 8);
  const Points x0 = crumpled(mesh, 20, 0.004), x1 = shaken(x0, 0.01, 21);
  const double inflation = 2e-3;
  const Candidates found = candidates(Team{1}, x0, x1, mesh.triangles(), inflation, "clusters");
  const std::set<std::array<Index, 2>> vertex_face(found.vertex_face.begin(),
                                                   found.vertex_face.end());
  const std::set<std::array<Index, 2>> edge_edge(found.edge_edge.begin(), found.edge_edge.end());
  const Triangles& t = mesh.triangles();
  long close = 0;
  const auto nearest = [&](const std::array<Index, 4>& v, bool face) {
    double smallest = INFINITY;
    for (int k = 0; k <= 8; ++k) {
      FourPoints p;
      for (int i = 0; i < 4; ++i)
        p[i] = ((8 - k) * x0.row(v[i]) + k * x1.row(v[i])).transpose() / 8.0;
      smallest =
          std::min(smallest, (face ? closest_vertex_face(p) : closest_edge_edge(p)).distance);
    }
    return smallest;
  };
  for (Index v = 0; v < mesh.n_vertices(); ++v)
    for (Index f = 0; f < t.rows(); ++f)
      if ((t.row(f).array() != v).all() &&
          nearest({v, t(f, 0), t(f, 1), t(f, 2)}, true) < 2.0 * inflation) {
        ++close;
        CHECK(vertex_face.count({v, f}) == 1);
      }
  const Edges& edges = found.edges;
  for (Index e = 0; e < edges.rows(); ++e)
    for (Index f = e + 1; f < edges.rows(); ++f) {
      const std::array<Index, 4> v = {edges(e, 0), edges(e, 1), edges(f, 0), edges(f, 1)};
      if (v[0] == v[2] || v[0] == v[3] || v[1] == v[2] || v[1] == v[3]) continue;
      if (nearest(v, false) < 2.0 * inflation) {
        ++close;
        CHECK(edge_edge.count({e, f}) == 1);
      }
    }
  CHECK(close > 300);
}

TEST_CASE("a tree built at other positions finds the same pairs") {
  const TestScene scene = make_scene(
      {{grid_cells(0.3, 0.3, 20, 20)}, {grid_cells(0.2, 0.2, 9, 9).moved(Vec3(0.05, 0, 0.002))}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const std::vector<Index> all = {0, 1, 2};
  const auto keep = [](ContactKind, std::vector<PairKey>&) {};  // keeps all pairs
  BroadPhase lasting(scene.model, pairs);
  std::vector<FeaturePairs> old_tree, new_tree;
  // Builds the trees of `lasting` at positions that differ from those tested below.
  lasting.swept_pairs(Team{1}, {shaken(scene.x, 0.1, 30), scene.x, 0.0}, all, keep, old_tree);
  for (const unsigned seed : {31u, 32u}) {
    const Points x0 = shaken(scene.x, 0.02, seed), x1 = shaken(x0, 0.01, seed + 5);
    lasting.swept_pairs(Team{3}, {x0, x1, 1e-4}, all, keep, old_tree);
    BroadPhase(scene.model, pairs).swept_pairs(Team{1}, {x0, x1, 1e-4}, all, keep, new_tree);
    for (const Index i : all) {
      CHECK(old_tree[i].vertex_face == new_tree[i].vertex_face);
      CHECK(old_tree[i].edge_edge == new_tree[i].edge_edge);
      CHECK(new_tree[i].vertex_face.size() + new_tree[i].edge_edge.size() > 100);
    }
  }
}

TEST_CASE("ranks that share a search find each pair once, and refit only what they compare") {
  const TestScene scene = make_scene(
      {{grid_cells(0.3, 0.3, 40, 40)}, {grid_cells(0.2, 0.2, 30, 30).moved(Vec3(0.05, 0, 0.002))}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const Points x0 = shaken(scene.x, 0.005, 41), x1 = shaken(x0, 0.002, 42);
  const auto keep = [](ContactKind, std::vector<PairKey>&) {};  // keeps all pairs
  BroadPhase whole(scene.model, pairs);
  // Searches all surface pairs, and then only the pairs of different surfaces.
  for (const bool self : {true, false}) {
    std::vector<Index> which;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (self || pairs[i].a != pairs[i].b) which.push_back(static_cast<Index>(i));
    std::vector<FeaturePairs> all, part, joined(pairs.size());
    whole.swept_pairs(Team{1}, {x0, x1, 1e-4}, which, keep, all);
    const int n_ranks = 7;
    for (int rank = 0; rank < n_ranks; ++rank) {
      BroadPhase own(scene.model, pairs, {rank, n_ranks});
      own.swept_pairs(Team{2}, {x0, x1, 1e-4}, which, keep, part);
      if (self) CHECK(own.bytes() < whole.bytes());
      for (const Index i : which) {
        joined[i].vertex_face.insert(joined[i].vertex_face.end(), part[i].vertex_face.begin(),
                                     part[i].vertex_face.end());
        joined[i].edge_edge.insert(joined[i].edge_edge.end(), part[i].edge_edge.begin(),
                                   part[i].edge_edge.end());
      }
    }
    for (const Index i : which) {
      std::sort(joined[i].vertex_face.begin(), joined[i].vertex_face.end());
      std::sort(joined[i].edge_edge.begin(), joined[i].edge_edge.end());
      CHECK(joined[i].vertex_face == all[i].vertex_face);
      CHECK(joined[i].edge_edge == all[i].edge_edge);
      CHECK(all[i].vertex_face.size() + all[i].edge_edge.size() > 1000);
    }
  }
}
