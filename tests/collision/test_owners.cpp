// Tests of the search for contacts and impacts, which ranks divide among themselves. The results
// have the same bits, whichever rank computes them.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "core/collision/broad_phase/neighbour_lists.h"
#include "core/collision/collision_stage.h"
#include "core/collision/response/contacts.h"
#include "tests/collision/collision_scenes.h"
#include "tests/support/thread_ranks.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;
using test::on_ranks;

namespace {

// Two sheets and a table. If `cells` is small and there are seven ranks, some ranks have no
// neighbour list.
TestScene sheets_on_table(Index cells) {
  return make_scene(
      {{grid_cells(0.2, 0.2, cells, cells), Kind::Cloth, 4e-3},
       {jittered_grid(0.2, 0.2, cells - 1, cells - 1, 0.2, 3).moved(Vec3(4e-3, 1e-3, 5e-3)),
        Kind::Cloth, 4e-3},
       {grid_cells(0.3, 0.3, 4, 4).moved(Vec3(0, 0, -3e-3)), Kind::Script, 4e-3}});
}

// `numbers` has the contacts of all steps; results() also adds the end positions and the results of
// approach(). `contacts` and `impacts` are the numbers of contacts and impacts in all steps.
struct Results {
  std::vector<double> numbers;
  std::int64_t contacts = 0, impacts = 0;
  bool operator==(const Results&) const = default;

  void add(const std::vector<Contact>& found) {
    contacts += static_cast<std::int64_t>(found.size());
    for (const Contact& c : found) {
      numbers.insert(numbers.end(), {static_cast<double>(c.kind), 1.0 * c.a, 1.0 * c.b});
      numbers.insert(numbers.end(), c.weights.begin(), c.weights.end());
      numbers.insert(numbers.end(), c.normal.begin(), c.normal.end());
      numbers.push_back(c.distance);
    }
  }
};

// Returns the results of eight steps of random motion. Six steps are calm. In the other two, the
// coordinates of the sheets change by up to 30 mm, far more than a neighbour list allows.
Results results(const TestScene& scene, std::shared_ptr<const Communicator> ranks) {
  CollisionStage stage(scene.model, Decomposition::Predicted, std::move(ranks));
  Points x = scene.x;
  Results all;
  FreeBodies none;
  for (int step = 0; step < 8; ++step) {
    all.add(stage.proximity(Team{}, x, {}));
    Points x1 = x;
    const Index n = scene.model.surfaces[0].n_vertices + scene.model.surfaces[1].n_vertices;
    x1.topRows(n) = shaken(x.topRows(n), step % 3 == 2 ? 0.03 : 1e-3, 5 + step);
    const CertifyReport report = stage.certify(Team{}, {x, scene.inverse_mass, {}}, x1, none);
    all.impacts += report.impacts;
    x = x1;
    all.numbers.insert(all.numbers.end(), x.data(), x.data() + x.size());
    const ExpectedMotion motion{x, x1, 1e-3};
    const Approach approach = stage.approach(Team{}, motion, {});
    all.numbers.push_back(static_cast<double>(approach.candidates));
    for (const ApproachingPair& pair : approach.pairs)
      all.numbers.push_back(static_cast<double>(pair.key % 1000003));
  }
  return all;
}

// Returns the contacts and the number of impacts of calm steps. After every fourth step, some
// vertices of one sheet jump over the other sheet.
Results results_with_jumps(const TestScene& scene, std::shared_ptr<const Communicator> ranks) {
  CollisionStage stage(scene.model, Decomposition::Predicted, std::move(ranks));
  Points x = scene.x;
  Results all;
  FreeBodies none;
  for (int step = 0; step < 16; ++step) {
    all.add(stage.proximity(Team{}, x, {}));
    Points x1 = shaken(x, 1e-6, step);
    all.impacts += stage.certify(Team{}, {x, scene.inverse_mass, {}}, x1, none).impacts;
    x = x1;
    if (step % 4 == 3)
      x.middleRows(30 * (step / 4), 20).rowwise() += Eigen::RowVector3d(0.05, 0.03, 8e-3);
  }
  return all;
}

// Sets an environment variable for the lifetime of the object.
struct Setting {
  const char* name;
  explicit Setting(const char* variable) : name(variable) { setenv(name, "1", 1); }
  ~Setting() { unsetenv(name); }
};

}  // namespace

TEST_CASE("contacts, impacts and end positions have the same bits on any number of ranks") {
  for (const Index cells : {3, 12}) {
    const TestScene scene = sheets_on_table(cells);
    const Results alone = results(scene, single_communicator());
    CHECK(alone.contacts > 100);
    CHECK(alone.impacts > 100);
    for (const int n : {2, 3, 4, 7}) {
      std::vector<Results> found(n);
      on_ranks(n, [&](const auto& ranks) { found[ranks->rank()] = results(scene, ranks); });
      for (const Results& each : found) CHECK(each == alone);
    }
  }
}

TEST_CASE("ranks find all contacts of vertices that have moved since the last certification") {
  const TestScene scene = sheets_on_table(12);
  const Results alone = results_with_jumps(scene, single_communicator());
  CHECK(alone.contacts > 100);
  for (const int n : {2, 5}) {
    std::vector<Results> found(n);
    on_ranks(n,
             [&](const auto& ranks) { found[ranks->rank()] = results_with_jumps(scene, ranks); });
    for (const Results& each : found) CHECK(each == alone);
  }
}

TEST_CASE("a calm step takes one exchange for contacts and one for impacts") {
  const TestScene scene = sheets_on_table(40);
  // For each rank, the number of steps from 20 to 39 that take two collective operations.
  std::vector<int> steps(3, 0);
  on_ranks(3, [&](const auto& ranks) {
    CollisionStage stage(scene.model, Decomposition::Predicted, ranks);
    FreeBodies none;
    Points x = scene.x;
    for (int step = 0; step < 40; ++step) {
      const std::int64_t before = ranks->traffic().operations;
      stage.proximity(Team{}, x, {});
      Points x1 = shaken(scene.x, 2e-5, step);
      stage.certify(Team{}, {x, scene.inverse_mass, {}}, x1, none);
      x = x1;
      if (step >= 20) steps[ranks->rank()] += ranks->traffic().operations - before == 2;
    }
  });
  // In the other steps, the ranks distribute the lists again, at most once in eight updates.
  for (const int n : steps) CHECK(n >= 15);
}

TEST_CASE("ranks that exchange their lists in every step find the same") {
  const TestScene scene = sheets_on_table(12);
  const Results alone = results(scene, single_communicator());
  const Setting rotate("LOOMSTONE_ROTATE_OWNERS");
  for (const int n : {2, 5}) {
    std::vector<Results> found(n);
    on_ranks(n, [&](const auto& ranks) { found[ranks->rank()] = results(scene, ranks); });
    for (const Results& each : found) CHECK(each == alone);
  }
}

TEST_CASE("lists that move to another rank do not count as lists that do not last") {
  const TestScene scene =
      make_scene({{grid_cells(0.2, 0.2, 24, 24), Kind::Cloth, 0.02},
                  {grid_cells(0.2, 0.2, 23, 23).moved(Vec3(1e-3, 2e-3, 5e-3)), Kind::Cloth, 0.02}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  const Setting rotate("LOOMSTONE_ROTATE_OWNERS");
  for (const double extra : {0.0, 1e-5}) {
    std::vector<int> unlisted(3, 0);
    std::vector<std::int64_t> made(3, 0);
    on_ranks(3, [&](const auto& ranks) {
      BroadPhase broad_phase(scene.model, pairs, {ranks->rank(), ranks->size()});
      NeighbourLists lists(scene.model, pairs, broad_phase, *ranks);
      lists.widen(extra);
      for (int step = 0; step < 40; ++step) {
        lists.update(Team{}, scene.x);
        lists.make_ended(Team{});
        unlisted[ranks->rank()] += static_cast<int>(lists.unlisted().size());
      }
      made[ranks->rank()] = lists.n_made();
    });
    CHECK(unlisted == std::vector<int>(3, 0));
    for (const std::int64_t n : made) CHECK(n > 1000);
  }
}

TEST_CASE("contacts that one rank finds alone are those that all ranks find together") {
  const TestScene scene = sheets_on_table(12);
  std::vector<int> right(3, 0);
  on_ranks(3, [&](const auto& ranks) {
    CollisionStage stage(scene.model, Decomposition::Predicted, ranks);
    const Points other = shaken(scene.x, 1e-4, 9);
    Results together, alone, known;
    together.add(stage.proximity(Team{}, scene.x, {}));
    stage.proximity(Team{}, other, {});
    if (ranks->rank() == 1) alone.add(stage.proximity_alone(Team{}, scene.x, {}));
    known.add(stage.proximity(Team{}, scene.x, {}));
    right[ranks->rank()] =
        together.contacts > 100 && known == together && (ranks->rank() != 1 || alone == together);
  });
  CHECK(right == std::vector<int>(3, 1));
}

TEST_CASE("each neighbour list is on one rank, and costs are balanced after some steps") {
  const TestScene scene = sheets_on_table(40);
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  using Key = std::tuple<Index, Index, Index>;
  struct Seen {
    std::set<Key> keys;
    std::size_t n_lists = 0;
    double cost = 0.0;
  };
  // Returns the lists of a rank after a calm motion of 40 steps, and their total cost in the last
  // ten steps. Every other vertex is lifted in proportion to x^2, so the number of contacts varies
  // over the sheets.
  const auto seen_by = [&](const Communicator& ranks) {
    BroadPhase broad_phase(scene.model, pairs, {ranks.rank(), ranks.size()});
    NeighbourLists lists(scene.model, pairs, broad_phase, ranks);
    Seen seen;
    SmoothNormals normals;
    for (int step = 0; step < 40; ++step) {
      if (step == 30)
        for (NeighbourList& list : lists.lists()) seen.cost -= list.cost;
      Points x = shaken(scene.x, 2e-5, 3 + step);
      for (Index v = 0; v < x.rows(); ++v) x(v, 2) += v % 2 ? 0.0 : 0.1 * x(v, 0) * x(v, 0);
      lists.update(Team{}, x);
      find_contacts(Team{}, {scene.model, pairs, normals}, x, lists);
    }
    seen.n_lists = lists.lists().size();
    for (const NeighbourList& list : lists.lists()) {
      seen.keys.insert({list.pair, list.a, list.b});
      seen.cost += list.cost;
    }
    return seen;
  };
  std::vector<Seen> seen(4);
  on_ranks(4, [&](const auto& ranks) { seen[ranks->rank()] = seen_by(*ranks); });
  std::set<Key> all;
  std::size_t n_lists = 0;
  double most = 0.0, sum = 0.0;
  for (const Seen& each : seen) {
    n_lists += each.n_lists;
    all.insert(each.keys.begin(), each.keys.end());
    most = std::max(most, each.cost), sum += each.cost;
  }
  CHECK(all.size() == n_lists);
  CHECK(n_lists > 1000);
  CHECK(4.0 * most < 1.3 * sum);  // above 1.25 times the mean cost, lists are distributed again
}
