#include <catch2/catch.hpp>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <tuple>

#include "core/collision/broad_phase/shared_search.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/collision_replay.h"
#include "core/collision/collision_stage.h"
#include "core/collision/response/contacts.h"
#include "tests/collision/collision_scenes.h"
#include "tests/parallel/thread_communicator.h"

using namespace loomstone;
using testing::on_ranks;
using testing::ThreadCommunicators;
using Kind = CollisionSurface::Kind;

namespace {

// Two crumpled sheets above a body and an obstacle. A strip along a border of the first sheet is
// attached to the body.
TestScene crumpled() {
  TestScene scene = make_scene(
      {{grid_cells(0.2, 0.2, 40, 40), Kind::Cloth, 3e-3},
       {jittered_grid(0.2, 0.2, 21, 21, 0.2, 3).moved(Vec3(4e-3, 1e-3, 8e-3)), Kind::Cloth, 4e-3},
       {grid_cells(0.1, 0.1, 9, 9).moved(Vec3(0.0, 0.0, -4e-3)), Kind::Body, 3e-3},
       {grid_cells(0.3, 0.3, 5, 5).moved(Vec3(0.0, 0.0, -8e-3)), Kind::Script, 3e-3}});
  scene.model.attached.resize(scene.model.n_vertices);
  for (Index v = 0; v < 120; ++v) scene.model.attached[v].surface = 2;
  scene.x = shaken(scene.x, 2.5e-3, 5);
  return scene;
}

using Found = std::vector<std::tuple<Index, ContactKind, PairKey>>;

struct Layout {
  int ranks, threads;
  Decomposition decomposition;
  Traversal traversal = Traversal::Tasks;
};

const std::vector<Layout> layouts = {
    {1, 1, Decomposition::Static},
    {1, 2, Decomposition::Static},
    {1, 2, Decomposition::Static, Traversal::Loops},
    {1, 1, Decomposition::Dynamic},
    {1, 3, Decomposition::Dynamic},
    {3, 1, Decomposition::Static},
    {4, 1, Decomposition::Dynamic},
    {7, 1, Decomposition::Dynamic},
    {2, 2, Decomposition::Dynamic},
};

// Calls body(rank, search) on all ranks of a layout.
template <class Body>
void search_together(const TestScene& scene, const std::vector<SurfacePair>& pairs,
                     const Layout& layout, Body&& body) {
  ThreadCommunicators ranks(layout.ranks, 20e-6, 9);
  const BroadPhase broad_phase(scene.model, pairs);
  on_ranks(layout.ranks, [&](int rank) {
    SharedSearch search(scene.model, pairs, broad_phase, layout.decomposition, ranks[rank]);
    search.set_traversal(layout.traversal);
    body(rank, search);
  });
}

bool same(const Contact& a, const Contact& b) {
  return a.kind == b.kind && a.a == b.a && a.b == b.b && a.vertices == b.vertices &&
         a.weights == b.weights && a.normal == b.normal && a.distance == b.distance &&
         a.thickness == b.thickness && a.friction == b.friction;
}

bool same(const StepImpact& a, const StepImpact& b) {
  return a.kind == b.kind && a.key == b.key && a.pair == b.pair && a.vertices == b.vertices &&
         a.impact.time == b.impact.time && a.impact.weights == b.impact.weights &&
         a.impact.normal == b.impact.normal && a.impact.start_distance == b.impact.start_distance;
}

template <class Record>
bool same(const std::vector<Record>& a, const std::vector<Record>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Record& x, const Record& y) { return same(x, y); });
}

}  // namespace

TEST_CASE("ranks together find each pair of overlapping boxes once") {
  const TestScene scene = crumpled();
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const Points x1 = shaken(scene.x, 2e-3, 6);
  BroadPhase whole(scene.model, pairs);
  std::vector<Index> which(pairs.size());
  for (std::size_t i = 0; i < which.size(); ++i) which[i] = static_cast<Index>(i);
  std::vector<FeaturePairs> by_pair;
  whole.swept_pairs(Team{1}, {scene.x, x1, 1e-3}, which, [](ContactKind, auto&) {}, by_pair);
  Found expected;
  for (const Index i : which) {
    for (const PairKey key : by_pair[i].vertex_face)
      expected.emplace_back(i, ContactKind::VertexFace, key);
    for (const PairKey key : by_pair[i].edge_edge)
      expected.emplace_back(i, ContactKind::EdgeEdge, key);
  }
  REQUIRE(expected.size() > 10000);
  const std::vector<double> inflation(scene.model.surfaces.size(), 1e-3);
  for (const Layout& layout : layouts) {
    Found found;
    std::mutex mutex;
    search_together(scene, pairs, layout, [&](int, SharedSearch& search) {
      for (const Points& start : {Points(shaken(scene.x, 0.02, 7)), scene.x}) {
        // The first search builds the hierarchies, at other positions. Only the second one counts.
        const bool counts = start == scene.x;
        search.each_pair(Team{layout.threads}, {start, x1, inflation},
                         [&](int, Index pair, ContactKind kind, PairKey key) {
                           const std::lock_guard lock(mutex);
                           if (counts) found.emplace_back(pair, kind, key);
                         });
        search.gather(std::vector<std::vector<int>>(1));
      }
    });
    std::sort(found.begin(), found.end());
    CHECK(found == expected);
  }
}

TEST_CASE("contacts and impacts have the same bits whichever ranks find them") {
  const TestScene scene = crumpled();
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const Points x1 = shaken(scene.x, 2e-3, 6);
  std::vector<std::uint8_t> changed(scene.model.n_vertices, 0);
  std::fill_n(changed.begin(), 300, 1);
  BroadPhase broad_phase(scene.model, pairs);
  const std::shared_ptr<const Communicator> single = single_communicator();
  NeighbourLists lists(scene.model, pairs, broad_phase, *single);
  lists.update(Team{1}, scene.x);
  SmoothNormals normals;
  const std::vector<Contact> contacts =
      find_contacts(Team{1}, {scene.model, pairs, normals}, scene.x, lists).contacts;
  ImpactSearch alone(scene.model, broad_phase, lists);
  const MotionInputs inputs{scene.x, scene.inverse_mass, {}};
  const std::vector<StepImpact> impacts = alone.find(Team{1}, inputs, x1, nullptr),
                                some = alone.find(Team{1}, inputs, x1, &changed);
  REQUIRE(contacts.size() > 1000);
  REQUIRE(impacts.size() > 100);
  REQUIRE(some.size() > 10);
  REQUIRE(some.size() < impacts.size());
  for (const Layout& layout : layouts) {
    std::atomic<int> wrong{0};
    search_together(scene, pairs, layout, [&](int, SharedSearch& search) {
      const Team team{layout.threads};
      BroadPhase own_boxes(scene.model, pairs);
      NeighbourLists own_lists(scene.model, pairs, own_boxes, *single);
      ImpactSearch own(scene.model, own_boxes, own_lists);
      own.share(&search);
      SmoothNormals own_normals;
      wrong +=
          !same(find_contacts(team, {scene.model, pairs, own_normals}, scene.x, search).contacts,
                contacts);
      wrong += !same(own.find(team, inputs, x1, nullptr), impacts);
      wrong += !same(own.find(team, inputs, x1, &changed), some);
    });
    CHECK(wrong == 0);
  }
}

TEST_CASE("an error on one rank is thrown on all ranks that share a search") {
  const TestScene scene = crumpled();
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const std::vector<double> inflation(scene.model.surfaces.size(), 1e-3);
  for (const Decomposition decomposition : {Decomposition::Static, Decomposition::Dynamic}) {
    std::atomic<int> told{0};
    search_together(scene, pairs, {3, 1, decomposition}, [&](int rank, SharedSearch& search) {
      search.each_pair(Team{1}, {scene.x, scene.x, inflation},
                       [&](int, Index, ContactKind, PairKey) {
                         if (rank == 1) throw InvalidInput("pair");
                       });
      try {
        search.gather(std::vector<std::vector<int>>(1));
      } catch (const InvalidInput& error) {
        told += std::string(error.what()) == "pair";
      }
    });
    CHECK(told == 3);
  }
}

TEST_CASE("top-level tests are dealt out evenly and none twice") {
  const TestScene scene = make_scene({{grid_cells(0.2, 0.2, 40, 40), Kind::Cloth, 3e-3},
                                      {grid_cells(0.3, 0.3, 5, 5), Kind::Script, 3e-3}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  // With this inflation, all boxes overlap.
  const std::vector<double> inflation(scene.model.surfaces.size(), 1.0);
  for (const int ranks : {1, 2, 4, 5, 12}) {
    PartitionTrees trees(scene.model, pairs, ranks);
    CHECK(trees.n_hierarchies() == ranks + 1);
    trees.refit(Team{1}, {scene.x, scene.x, inflation}, false);
    std::vector<std::array<Index, 2>> all;
    std::size_t fewest = 1000, most = 0;
    for (int rank = 0; rank < ranks; ++rank) {
      const std::vector<NodeTest> tests = trees.top_level(rank, ranks);
      fewest = std::min(fewest, tests.size()), most = std::max(most, tests.size());
      for (const NodeTest& test : tests)
        all.push_back({std::min(test.hierarchy_a, test.hierarchy_b),
                       std::max(test.hierarchy_a, test.hierarchy_b)});
    }
    CHECK(most - fewest <= 1);
    std::sort(all.begin(), all.end());
    CHECK(std::adjacent_find(all.begin(), all.end()) == all.end());
    // The tests compare each partition with itself, every other partition and the obstacle.
    CHECK(all.size() == static_cast<std::size_t>(ranks * (ranks + 1) / 2 + ranks));
  }
}

// The numbers of vertices and partitions are chosen so that their product does not fit in a signed
// 32-bit integer.
TEST_CASE("meshes may be divided into more partitions than they have vertices") {
  const TestScene scene = make_scene({{grid_cells(0.2, 0.2, 200, 200), Kind::Cloth, 3e-3}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const PartitionTrees trees(scene.model, pairs, 60000);
  std::vector<std::uint8_t> first(scene.model.n_vertices, 0);
  for (Index t = 0; t < scene.model.triangles.rows(); ++t) first[scene.model.triangles(t, 0)] = 1;
  CHECK(trees.n_hierarchies() == std::count(first.begin(), first.end(), 1));
}

TEST_CASE("recorded tests form trees in which each test appears once") {
  const TestScene scene = crumpled();
  const Points x1 = shaken(scene.x, 2e-3, 6);
  const CollisionReplay replay(
      {scene.model.surfaces, scene.model.triangles, scene.model.gap_floor, scene.x, x1});
  const auto search = GENERATE(CollisionReplay::Search::Contacts, CollisionReplay::Search::Impacts);
  for (const auto division : {Decomposition::Static, Decomposition::Dynamic}) {
    const RecordedTests tests = replay.measure(search, 3, division, 2);
    REQUIRE(tests.n_ranks() == 3);
    REQUIRE(tests.size() > 1000);
    CHECK(tests.result_bytes > 1000);
    CHECK(tests.work() > 0.0);
    std::vector<int> seen(tests.size(), 0);
    for (const std::vector<Index>& roots : tests.roots) {
      CHECK(!roots.empty());
      for (const Index root : roots) ++seen[root];
    }
    for (std::size_t i = 0; i < tests.size(); ++i)
      for (Index child = 0; child < tests.n_children[i]; ++child)
        ++seen[tests.first_child[i] + child];
    CHECK(std::count(seen.begin(), seen.end(), 1) == static_cast<std::ptrdiff_t>(seen.size()));
    const CollisionReplay::Execution alone{Decomposition::Dynamic, Traversal::Tasks, Team{},
                                           single_communicator()};
    CHECK(replay.perform(search, alone, 3).size() == 3);
  }
  CHECK_THROWS_WITH(replay.measure(search, 0, Decomposition::Static),
                    Catch::Matchers::Contains("ranks must be at least 1"));
  CHECK_THROWS_WITH(replay.measure(search, 2, Decomposition::Predicted),
                    Catch::Matchers::Contains("must be static or dynamic"));
}

TEST_CASE("the expected costs of lists come from the earlier motions of the record") {
  const TestScene scene = make_scene({{grid_cells(0.2, 0.2, 20, 20), Kind::Cloth, 3e-3},
                                      {grid_cells(0.2, 0.2, 20, 20), Kind::Cloth, 3e-3}});
  const Index n = scene.model.n_vertices / 2;
  Points near = scene.x, apart = scene.x;
  near.bottomRows(n).col(2).array() += 2e-3;
  apart.bottomRows(n).col(2).array() += 1.0;
  // Returns the expected costs of the lists between the two sheets.
  const auto expected = [&](const std::vector<Points>& earlier) {
    const CollisionReplay replay(
        {scene.model.surfaces, scene.model.triangles, scene.model.gap_floor, near, near, earlier});
    const OrderedWork work = replay.measure_lists(1).contacts;
    const auto at = [&](int pair) { return work.expected.begin() + work.first[pair]; };
    return std::accumulate(at(1), at(2), 0.0);
  };
  CHECK(expected({}) > 0.0);
  CHECK(expected(std::vector<Points>(4, near)) > 0.0);
  CHECK(expected(std::vector<Points>(4, apart)) == 0.0);
  CHECK_THROWS_WITH(expected({near.topRows(3)}), Catch::Matchers::Contains("as many rows"));
}

TEST_CASE("clusters are dealt out in ranges of equal costs, which one in eight searches measures") {
  SearchDeal deal(8);
  CHECK(!deal.known());
  REQUIRE(deal.begin(2));
  // Clusters cost 4, 1, 1, 1, 1, 1, 1 and 1.5 us, 11.5 us in total. Half is 5.75 us.
  for (std::size_t c = 0; c < 8; ++c) deal.add(c % 2, c, 1e-6);
  deal.add(1, 0, 3e-6);
  deal.add(0, 7, 0.5e-6);
  deal.end(*single_communicator(), 2);
  CHECK(deal.known());
  CHECK(deal.starts() == std::vector<std::size_t>{0, 3, 8});
  for (int search = 1; search < SearchDeal::interval; ++search) CHECK(!deal.begin(2));
  // The costs of an earlier search do not count. A test that seems to take a second was probably
  // interrupted, so it counts as 20 us.
  REQUIRE(deal.begin(1));
  deal.add(0, 7, 1.0);
  deal.add(0, 1, 20e-6);
  deal.end(*single_communicator(), 2);
  CHECK(deal.starts() == std::vector<std::size_t>{0, 2, 8});
}

TEST_CASE("the first tests of all ranks cover the same clusters, whether costs are known or not") {
  const TestScene scene = crumpled();
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  PartitionTrees trees(scene.model, pairs, 4);
  const std::vector<double> inflation(scene.model.surfaces.size(), 1e-3);
  trees.refit(Team{1}, {scene.x, scene.x, inflation}, true);
  // Returns all leaves (tests of two clusters) that result from the given tests.
  const auto leaves = [&](std::vector<NodeTest> stack) {
    std::vector<std::tuple<Index, Index, Index, Index>> found;
    PartitionTrees::Scratch scratch;
    while (!stack.empty()) {
      const NodeTest test = stack.back();
      stack.pop_back();
      if (PartitionTrees::leaf(test))
        found.emplace_back(test.hierarchy_a, test.hierarchy_b, test.node_a, test.node_b);
      else
        trees.expand(test, stack, scratch);
    }
    return found;
  };
  std::vector<std::tuple<Index, Index, Index, Index>> all = leaves(trees.top_level(0, 1)), dealt;
  REQUIRE(all.size() > 1000);
  const std::vector<std::size_t> starts = {0, 5, 30, 131, trees.n_clusters()};
  for (std::size_t rank = 0; rank + 1 < starts.size(); ++rank) {
    for (const auto& leaf : leaves(trees.tests_of(starts[rank], starts[rank + 1])))
      dealt.push_back(leaf);
  }
  std::sort(all.begin(), all.end());
  std::sort(dealt.begin(), dealt.end());
  CHECK(dealt == all);
}
