#include "core/collision/collision_replay.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/message.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/detector.h"
#include "core/collision/response/contacts.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

namespace {

// Throws InvalidInput unless the surfaces divide all vertices and all triangles into consecutive
// ranges, in the order of the surfaces.
void check_surfaces(const CollisionRecord& record) {
  Index vertex = 0, triangle = 0;
  for (std::size_t s = 0; s < record.surfaces.size(); ++s) {
    const CollisionSurface& surface = record.surfaces[s];
    if (surface.first_vertex != vertex || surface.first_triangle != triangle ||
        surface.n_vertices < 0 || surface.n_triangles < 0)
      fail<InvalidInput>(
          "surface {} must begin with vertex {} and triangle {}, after the preceding surfaces, got "
          "{} vertices from vertex {} and {} triangles from triangle {}",
          s, vertex, triangle, surface.n_vertices, surface.first_vertex, surface.n_triangles,
          surface.first_triangle);
    vertex += surface.n_vertices, triangle += surface.n_triangles;
  }
  if (vertex != record.x0.rows() || triangle != record.triangles.rows())
    fail<InvalidInput>(
        "the surfaces must contain all {} vertices and {} triangles of the record, got {} and {}",
        record.x0.rows(), record.triangles.rows(), vertex, triangle);
}

CollisionModel model_of(const CollisionRecord& record) {
  check_motion(record.x0, record.x1, record.gap_floor, "gap_floor");
  for (const Points& x : record.earlier) check_motion(record.x0, x, record.gap_floor, "gap_floor");
  check_triangles(record.triangles, static_cast<Index>(record.x0.rows()));
  check_surfaces(record);
  CollisionModel model;
  model.n_vertices = static_cast<Index>(record.x0.rows());
  model.triangles = record.triangles;
  model.edges = edge_table(model.n_vertices, record.triangles).edges;
  model.surfaces = record.surfaces;
  model.gap_floor = record.gap_floor;
  model.rows.row.assign(model.n_vertices, -1);
  model.rows.is_body.assign(model.n_vertices, 0);
  for (const CollisionSurface& surface : record.surfaces)
    if (surface.kind == CollisionSurface::Kind::Cloth)
      std::iota(model.rows.row.begin() + surface.first_vertex,
                model.rows.row.begin() + surface.first_vertex + surface.n_vertices,
                surface.first_vertex);
  return model;
}

// Returns inverse masses: 1 for cloth, 0 for other vertices. The searches only compare them with 0.
Vector movable(const CollisionModel& model) {
  Vector inverse_mass = Vector::Zero(model.n_vertices);
  for (const CollisionSurface& surface : model.surfaces)
    if (surface.kind == CollisionSurface::Kind::Cloth)
      inverse_mass.segment(surface.first_vertex, surface.n_vertices).setOnes();
  return inverse_mass;
}

// Smallest number of motions that are performed before the measured one. They give the lists the
// slack that the motion needs.
constexpr std::size_t least_earlier = 3;

void require_repetitions(int repetitions) {
  if (repetitions < 1) fail<InvalidInput>("repetitions must be at least 1, got {}", repetitions);
}

// Approximate mean number of motions between the measurement of costs and a dynamic search that
// uses them.
constexpr int motions_since_deal = 4;

// Uses neighbour lists to perform the searches of steps, on one thread.
struct ListsOfStep {
  ListsOfStep(const CollisionModel& given, const std::vector<SurfacePair>& given_pairs,
              const Vector& given_inverse_mass)
      : model(given),
        pairs(given_pairs),
        inverse_mass(given_inverse_mass),
        boxes(model, pairs),
        lists(model, pairs, boxes, *alone),
        search(model, boxes, lists) {
    for (const SurfacePair& pair : pairs)
      first.push_back(first.back() + boxes.tree(pair.a).n_clusters());
  }

  // contacts() and impacts() return the size of their results [bytes].
  std::size_t contacts(const Points& x) {
    lists.update(Team{}, x);
    return find_contacts(Team{}, {model, pairs, normals}, x, lists).contacts.size() *
           bytes_of_found_contact;
  }
  std::size_t impacts(const Points& x0, const Points& x1) {
    return search.find(Team{}, {x0, inverse_mass, {}}, x1, nullptr).size() * sizeof(StepImpact);
  }

  // Calls add(i, list) for each list. `i` is the number of the list's first cluster (list.a). First
  // clusters are numbered consecutively over all surface pairs; see ClusterOwners.
  template <class Add>
  void each_list(Add&& add) {
    for (NeighbourList& list : lists.lists()) add(first[list.pair] + list.a, list);
  }
  // Performs both searches of an earlier motion.
  void perform_earlier(const Points& x0, const Points& x1) {
    contacts(x0);
    note_search();
    note_times();
    impacts(x0, x1);
    note_search();
    note_times();
  }
  // Adds the times on lists since the last call to `since_search`. Like a simulation, forgets the
  // times on lists of surface pairs that have become unlisted.
  void note_times() {
    since_search.resize(first.back(), 0.0f);
    each_list([&](std::size_t i, NeighbourList& list) {
      since_search[i] += std::exchange(list.spent, 0.0f);
    });
    for (const Index pair : lists.unlisted())
      std::fill(since_search.begin() + first[pair], since_search.begin() + first[pair + 1], 0.0f);
  }
  // Must be called after each search. If it began with a search for cluster pairs, the ranks
  // divided the lists according to their times since the search for cluster pairs before.
  void note_search() {
    const bool searched = lists.n_searches() != n_searches;
    n_searches = lists.n_searches();
    if (searched && !since_search.empty()) divided_by = std::exchange(since_search, {});
  }
  // Returns for each first cluster the time on its lists [ns] according to which the ranks divide
  // the lists. Must be called after note_search().
  const std::vector<float>& expected() const {
    return divided_by.empty() ? since_search : divided_by;
  }
  // Stores in `work` the times spent on lists and in searches of unlisted surface pairs since the
  // last call [s]. Each list gets an equal share of the time of the passes over all lists. If a
  // time for the same work is already stored, keeps the smaller one.
  void take_work(OrderedWork& work) {
    const double pass = lists.take_pass_seconds() / static_cast<double>(lists.lists().size());
    std::vector<double> seconds(first.back(), 0.0);
    each_list([&](std::size_t i, NeighbourList& list) {
      seconds[i] += std::exchange(list.seconds, 0.0f) + pass;
    });
    const double divisible = lists.take_unlisted_seconds();
    const bool again = !work.seconds.empty();
    work.divisible = again ? std::min(work.divisible, divisible) : divisible;
    if (again)
      for (std::size_t i = 0; i < seconds.size(); ++i)
        seconds[i] = std::min(seconds[i], work.seconds[i]);
    work.seconds = std::move(seconds);
    work.first = first;
  }

  const std::shared_ptr<const Communicator> alone = single_communicator();
  const CollisionModel& model;
  const std::vector<SurfacePair>& pairs;
  const Vector& inverse_mass;
  BroadPhase boxes;
  NeighbourLists lists;
  ImpactSearch search;
  SmoothNormals normals;
  // For each first cluster, the time spent on its lists between the last two searches for cluster
  // pairs, and since the last one [ns].
  std::vector<float> divided_by, since_search;
  std::int64_t n_searches = 0;
  // (surface pairs + 1) Number of first clusters (see each_list()) in all preceding surface pairs.
  SectionStarts first = {0};
};

}  // namespace

struct CollisionReplay::Data {
  explicit Data(CollisionRecord given)
      : record(std::move(given)),
        model(model_of(record)),
        pairs(surface_pairs(model)),
        boxes(model, pairs),
        inverse_mass(movable(model)) {}

  // Returns the positions at the start of the motion that is `motions_ago` motions earlier than the
  // recorded one [m]; -1: its end.
  Points start(int motions_ago) const {
    const auto& earlier = record.earlier;
    const int n = static_cast<int>(earlier.size());
    if (motions_ago < 0) return record.x1;
    if (motions_ago == 0) return record.x0;
    if (motions_ago <= n) return earlier[n - motions_ago];
    return start(n) - (motions_ago - n) * (start(n - 1) - start(n));
  }

  CollisionRecord record;
  const CollisionModel model;
  const std::vector<SurfacePair> pairs;
  BroadPhase boxes;
  const Vector inverse_mass;
};

CollisionReplay::CollisionReplay(CollisionRecord record)
    : data_(std::make_unique<Data>(std::move(record))) {}
CollisionReplay::~CollisionReplay() = default;

// Performs a search of the recorded motion, or of the motion that is `motions_ago` motions earlier.
// Returns the size of its results [bytes].
std::size_t CollisionReplay::find(Search search, const Team& team, SharedSearch& shared,
                                  int motions_ago) const {
  Data& d = *data_;
  const Points x0 = d.start(motions_ago);
  if (search == Search::Contacts) {
    SmoothNormals normals;
    find_contacts(team, {d.model, d.pairs, normals}, x0, shared);
    return shared.result_bytes();
  }
  const std::shared_ptr<const Communicator> alone = single_communicator();
  NeighbourLists unused(d.model, d.pairs, d.boxes, *alone);
  ImpactSearch impacts(d.model, d.boxes, unused);
  impacts.share(&shared);
  impacts.find(team, {x0, d.inverse_mass, {}}, d.start(motions_ago - 1), nullptr);
  return shared.result_bytes();
}

RecordedTests CollisionReplay::measure(Search search, int n_ranks, Decomposition decomposition,
                                       int repetitions) const {
  if (n_ranks < 1) fail<InvalidInput>("ranks must be at least 1, got {}", n_ranks);
  require_repetitions(repetitions);
  if (decomposition == Decomposition::Predicted)
    fail<Unsupported>("the decomposition must be static or dynamic, got predicted");
  const Data& d = *data_;
  RecordedTests tests;
  SharedSearch shared(d.model, d.pairs, d.boxes, decomposition, single_communicator(), n_ranks);
  // This search of an earlier motion measures the costs according to which the tests of the
  // recorded motion are dealt to the ranks.
  if (decomposition == Decomposition::Dynamic) find(search, Team{}, shared, motions_since_deal);
  shared.record(&tests);
  for (int i = 0; i < repetitions; ++i) tests.result_bytes = find(search, Team{}, shared);
  return tests;
}

CollisionReplay::Lists CollisionReplay::measure_lists(int repetitions) const {
  require_repetitions(repetitions);
  const Data& d = *data_;
  const int n_earlier = static_cast<int>(std::max(least_earlier, d.record.earlier.size()));
  const double clock = clock_seconds();
  Lists all;
  for (int i = 0; i < repetitions; ++i) {
    ListsOfStep step(d.model, d.pairs, d.inverse_mass);
    for (int ago = n_earlier; ago > 0; --ago) step.perform_earlier(d.start(ago), d.start(ago - 1));
    step.lists.time_work(clock);
    all.contacts.result_bytes = step.contacts(d.record.x0);
    step.note_search();
    all.contacts.expected = all.impacts.expected = step.expected();
    step.take_work(all.contacts);
    all.impacts.result_bytes = step.impacts(d.record.x0, d.record.x1);
    step.take_work(all.impacts);
  }
  return all;
}

std::vector<double> CollisionReplay::perform(Search search, const Execution& execution,
                                             int repetitions) const {
  if (execution.decomposition == Decomposition::Predicted)
    fail<Unsupported>("the decomposition must be static or dynamic, got predicted");
  require_repetitions(repetitions);
  const Data& d = *data_;
  SharedSearch shared(d.model, d.pairs, d.boxes, execution.decomposition, execution.communicator);
  shared.set_traversal(execution.traversal);
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    execution.communicator->barrier();
    find(search, execution.team, shared);
    constexpr double nanosecond = 1e-9;
    const auto count = static_cast<std::int64_t>(shared.seconds() / nanosecond);
    seconds.push_back(nanosecond * static_cast<double>(execution.communicator->maximum(count)));
  }
  return seconds;
}

}  // namespace loomstone
