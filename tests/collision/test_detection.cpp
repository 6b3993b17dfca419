#include <catch2/catch.hpp>

#include <set>
#include <tuple>

#include "core/collision/certify/impact_search.h"
#include "core/collision/collision_stage.h"
#include "core/collision/response/contacts.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;
using Key = std::tuple<int, Index, Index>;

namespace {

// Calls visit(kind, a, b, vertices) for all pairs of features that the model allows to collide.
template <class Visit>
void all_pairs(const CollisionModel& model, Visit&& visit) {
  const auto allowed = [&](Index s, Index t) {
    if (s == t) return model.surfaces[s].kind == Kind::Cloth && model.surfaces[s].self_collision;
    return model.surfaces[s].kind == Kind::Cloth || model.surfaces[t].kind == Kind::Cloth;
  };
  const auto distinct = [](const std::array<Index, 4>& v, int n_a) {
    for (int i = 0; i < n_a; ++i)
      for (int j = n_a; j < 4; ++j)
        if (v[i] == v[j]) return false;
    return true;
  };
  for (Index a = 0; a < model.n_vertices; ++a)
    for (Index b = 0; b < model.triangles.rows(); ++b) {
      const auto v = pair_vertices(model, ContactKind::VertexFace, pair_key(a, b));
      if (allowed(model.surface_of_vertex(a), model.surface_of_triangle(b)) && distinct(v, 1))
        visit(ContactKind::VertexFace, a, b, v);
    }
  for (Index a = 0; a < model.edges.rows(); ++a)
    for (Index b = a + 1; b < model.edges.rows(); ++b) {
      const auto v = pair_vertices(model, ContactKind::EdgeEdge, pair_key(a, b));
      if (allowed(model.surface_of_edge(a), model.surface_of_edge(b)) && distinct(v, 2))
        visit(ContactKind::EdgeEdge, a, b, v);
    }
}

FourPoints gather(const Points& x, const std::array<Index, 4>& v) {
  FourPoints p;
  for (int i = 0; i < 4; ++i) p[i] = x.row(v[i]).transpose();
  return p;
}

TestScene crowd() {
  Part quiet{grid_cells(0.1, 0.1, 5, 5).moved(Vec3(0.02, 0, 0.004))};
  TestScene scene =
      make_scene({{grid_cells(0.2, 0.2, 10, 10), Kind::Cloth, 4e-3},
                  quiet,
                  {icosphere(0.03, 1).moved(Vec3(0, 0, 0.034)), Kind::Body, 2e-3},
                  {icosphere(0.03, 1).moved(Vec3(0, 0, 0.09)), Kind::Script, 2e-3},
                  {floor_square(0.4, 2).moved(Vec3(0, 0, -0.006)), Kind::Script, 6e-3}});
  scene.model.surfaces[1].self_collision = false;
  return scene;
}

}  // namespace

TEST_CASE("contacts agree with a test of all pairs in every step, for any number of threads") {
  const TestScene scene = crowd();
  const CollisionModel& model = scene.model;
  std::vector<std::unique_ptr<CollisionStage>> stages;
  for (int i = 0; i < 4; ++i) stages.push_back(std::make_unique<CollisionStage>(model));
  Points x = shaken(scene.x, 3e-3, 6);
  std::size_t n_contacts = 0;
  for (int step = 0; step < 12; ++step) {
    // Small steps allow neighbour lists to remain valid. The jump in step 6 makes them invalid. The
    // spherical obstacle moves down in every step.
    x = shaken(x, step == 6 ? 8e-3 : 2e-4, 7 + step);
    const CollisionSurface& sphere = model.surfaces[3];
    x.middleRows(sphere.first_vertex, sphere.n_vertices).col(2).array() -= 4e-3;
    std::set<Key> expected;
    all_pairs(model, [&](ContactKind kind, Index a, Index b, const std::array<Index, 4>& v) {
      const ClosestPair c = kind == ContactKind::VertexFace ? closest_vertex_face(gather(x, v))
                                                            : closest_edge_edge(gather(x, v));
      const Index s = model.surface_of_vertex(v[0]), t = model.surface_of_vertex(v[3]);
      const double thickness = 0.5 * (model.surfaces[s].thickness + model.surfaces[t].thickness);
      if (c.distance < thickness && (kind == ContactKind::VertexFace || c.interior))
        expected.insert({int(kind), a, b});
    });
    int i = 0;
    for (const int threads : {1, 2, 3, 7}) {
      // A stage without earlier steps must give the same contacts as the others.
      if (step % 3 == 2 && threads == 3) stages[i] = std::make_unique<CollisionStage>(model);
      const std::vector<Contact> contacts = stages[i++]->proximity(Team{threads}, x, {});
      std::vector<Key> found;
      for (const Contact& c : contacts) found.push_back({int(c.kind), c.a, c.b});
      CHECK(found == std::vector<Key>(expected.begin(), expected.end()));
      n_contacts += contacts.size();
    }
  }
  CHECK(n_contacts > 4000);
}

TEST_CASE(
    "neighbour lists of a swinging sheet last for many steps and give the contacts of a full "
    "search") {
  const TestScene scene = make_scene(
      {{grid_cells(0.2, 0.2, 24, 24), Kind::Cloth, 1e-3},
       {grid_cells(0.2, 0.2, 23, 23).moved(Vec3(1e-3, 2e-3, 1.2e-3)), Kind::Cloth, 1e-3}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  BroadPhase broad_phase(scene.model, pairs), other(scene.model, pairs);
  const Communicator& alone = *single_communicator();
  NeighbourLists lists(scene.model, pairs, broad_phase, alone),
      nothing_listed(scene.model, pairs, other, alone, 0);
  const auto place = [&](int step) {
    const Eigen::AngleAxisd turn(0.01 * step, Vec3(1.0, 0.4, 0.2).normalized());
    Points x = scene.x * turn.toRotationMatrix().transpose();
    const Index n = scene.model.surfaces[0].n_vertices;
    x.topRows(n).col(2).array() += 1e-4 * step;  // moves one sheet through the other
    x.col(0).array() += 3e-3 * step;
    return x;
  };
  SmoothNormals normals;
  std::size_t n_contacts = 0;
  for (int step = 0; step < 24; ++step) {
    const Points x = place(step);
    lists.update(Team{2}, x);
    nothing_listed.update(Team{1}, x);
    REQUIRE(nothing_listed.unlisted().size() == pairs.size());
    const std::vector<Contact> found =
        find_contacts(Team{2}, {scene.model, pairs, normals}, x, lists).contacts;
    const std::vector<Contact> expected =
        find_contacts(Team{1}, {scene.model, pairs, normals}, x, nothing_listed).contacts;
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      CHECK((found[i].kind == expected[i].kind && found[i].a == expected[i].a &&
             found[i].b == expected[i].b));
      CHECK((found[i].distance == expected[i].distance && found[i].normal == expected[i].normal));
    }
    n_contacts += found.size();
    lists.cover(Team{2}, place(step + 1));
  }
  CHECK(n_contacts > 5000);
  CHECK(lists.n_searches() <= 12);
  CHECK(lists.n_made() <= 6 * static_cast<std::int64_t>(lists.lists().size()));
}

TEST_CASE("a surface pair is unlisted while its lists do not last, and then listed again") {
  const TestScene scene = make_scene(
      {{grid_cells(0.2, 0.2, 24, 24), Kind::Cloth, 1e-3},
       {grid_cells(0.2, 0.2, 23, 23).moved(Vec3(1e-3, 2e-3, 0.9e-3)), Kind::Cloth, 1e-3}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  BroadPhase broad_phase(scene.model, pairs), other(scene.model, pairs);
  const Communicator& alone = *single_communicator();
  NeighbourLists lists(scene.model, pairs, broad_phase, alone),
      nothing_listed(scene.model, pairs, other, alone, 0);
  const double extra = GENERATE(0.0, 1e-5);
  lists.widen(extra);
  // In the first 30 steps, one of the two sheets moves to and fro, so that lists between them
  // last for at most two steps. Lists within either sheet stay valid.
  const auto place = [&](int step) {
    Points x = scene.x;
    if (step < 30 && step % 2 == 1)
      x.topRows(scene.model.surfaces[0].n_vertices).col(0).array() += 3e-3;
    return x;
  };
  SmoothNormals normals;
  int n_listed = 0, last_listed = -1;
  std::int64_t n_made_before = 0;
  for (int step = 0; step < 120; ++step) {
    const Points x = place(step);
    lists.update(Team{1}, x);
    nothing_listed.update(Team{1}, x);
    const std::size_t n_contacts =
        find_contacts(Team{1}, {scene.model, pairs, normals}, x, lists).contacts.size();
    CHECK(n_contacts > 500);
    CHECK(n_contacts ==
          find_contacts(Team{1}, {scene.model, pairs, normals}, x, nothing_listed).contacts.size());
    lists.cover(Team{1}, place(step + 1));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const bool listed = lists.listed(static_cast<Index>(i));
      if (pairs[i].a == pairs[i].b) CHECK(listed);
      if (pairs[i].a == pairs[i].b || !listed) continue;
      ++n_listed;
      last_listed = step;
    }
    if (step == 15) n_made_before = lists.n_made();
    if (step == 29) CHECK(lists.n_made() == n_made_before);
  }
  CHECK(n_listed > 8);
  CHECK(n_listed < 80);
  CHECK(last_listed == 119);
}

TEST_CASE(
    "a sheet that falls freely in steps of 10 ms needs a search in at most every other step") {
  const TestScene scene =
      make_scene({{grid_cells(0.5, 0.5, 40, 40).moved(Vec3(0, 0, 1)), Kind::Cloth, 1.2e-3},
                  {grid_cells(1.0, 1.0, 1, 1), Kind::Script, 1.2e-3}});
  const std::vector<SurfacePair> pairs = surface_pairs(scene.model);
  BroadPhase broad_phase(scene.model, pairs);
  NeighbourLists lists(scene.model, pairs, broad_phase, *single_communicator());
  const Index n = scene.model.surfaces[0].n_vertices;
  const auto place = [&](int step) {
    Points x = scene.x;
    x.topRows(n).col(2).array() -= 0.5 * 9.81 * 1e-4 * step * step;
    return x;
  };
  constexpr int steps = 40;
  for (int step = 0; step < steps; ++step) {
    lists.update(Team{1}, place(step));
    lists.cover(Team{1}, place(step + 1));
  }
  CHECK(lists.n_searches() <= steps / 2);
}

TEST_CASE("impacts agree with a test of all pairs, with lists and without") {
  const TestScene scene = crowd();
  const CollisionModel& model = scene.model;
  const std::vector<SurfacePair> pairs = surface_pairs(model);
  BroadPhase broad_phase(model, pairs);
  const std::size_t most_per_cluster = GENERATE(64, 0);  // 0 disables the lists
  NeighbourLists lists(model, pairs, broad_phase, *single_communicator(), most_per_cluster);
  ImpactSearch search(model, broad_phase, lists);
  const Points x0 = shaken(scene.x, 3e-3, 8);
  int n_impacts = 0;
  for (const double travel : {3e-4, 3e-3, 3e-2}) {
    const Points x1 = shaken(x0, travel, 9);
    std::set<Key> expected;
    all_pairs(model, [&](ContactKind kind, Index a, Index b, const std::array<Index, 4>& v) {
      if (!(scene.inverse_mass[v[0]] > 0 || scene.inverse_mass[v[3]] > 0)) return;
      MovingPoints q;
      for (int i = 0; i < 4; ++i) {
        q[i] = x0.row(v[i]).transpose();
        q[4 + i] = x1.row(v[i]).transpose();
      }
      const Impact impact = kind == ContactKind::VertexFace
                                ? continuous_vertex_face_above_gap(q, model.gap_floor)
                                : continuous_edge_edge_above_gap(q, model.gap_floor);
      if (impact.hit && !impact.touching) expected.insert({int(kind), a, b});
    });
    for (const bool with_lists : {false, true})
      for (const int threads : {1, 3}) {
        if (with_lists) {
          lists.update(Team{threads}, x0);
          SmoothNormals normals;
          find_contacts(Team{1}, {model, pairs, normals}, x0, lists);  // makes the lists
        } else {
          // The search must update lists that were last updated at other positions.
          lists.update(Team{1}, x0 + Points::Constant(x0.rows(), 3, 1e-3));
        }
        std::vector<Key> found;
        for (const StepImpact& each :
             search.find(Team{threads}, {x0, scene.inverse_mass, {}}, x1, nullptr))
          found.push_back({int(each.kind), first_of(each.key), second_of(each.key)});
        CHECK(found == std::vector<Key>(expected.begin(), expected.end()));
        n_impacts += found.size();
      }
  }
  CHECK(n_impacts > 1000);
}

TEST_CASE("a surface that a vertex is attached to does not collide with its faces and edges") {
  TestScene scene =
      make_scene({{grid_cells(0.1, 0.1, 4, 4), Kind::Cloth, 4e-3},
                  {floor_square(0.4, 2).moved(Vec3(0, 0, -0.001)), Kind::Body, 4e-3}});
  const auto all = CollisionStage(scene.model).proximity(Team{1}, scene.x, {});
  scene.model.attached.resize(scene.model.n_vertices);
  scene.model.attached[0].surface = 1;
  const auto rest = CollisionStage(scene.model).proximity(Team{1}, scene.x, {});
  CHECK(rest.size() < all.size());
  for (const Contact& contact : rest)
    for (const Index v : contact.vertices) CHECK(v != 0);
}
