#include "core/collision/collision_replay.h"

#include <utility>

#include "core/base/message.h"
#include "core/collision/certify/impact_search.h"
#include "core/collision/detector.h"
#include "core/collision/response/contacts.h"
#include "core/mesh/adjacency.h"

namespace loomstone {

namespace {

void check_surface(const CollisionRecord& record, std::size_t s) {
  const CollisionSurface& surface = record.surfaces[s];
  const Index n_vertices = static_cast<Index>(record.x0.rows()),
              n_triangles = static_cast<Index>(record.triangles.rows());
  const auto within = [](Index first, Index n, Index all) {
    return first >= 0 && n >= 0 && first <= all - n;
  };
  if (!within(surface.first_vertex, surface.n_vertices, n_vertices) ||
      !within(surface.first_triangle, surface.n_triangles, n_triangles))
    fail<InvalidInput>(
        "surface {} must have some of the {} vertices and {} triangles, got vertices {} to {} and "
        "triangles {} to {}",
        s, n_vertices, n_triangles, surface.first_vertex,
        surface.first_vertex + surface.n_vertices - 1, surface.first_triangle,
        surface.first_triangle + surface.n_triangles - 1);
}

CollisionModel model_of(const CollisionRecord& record) {
  check_motion(record.x0, record.x1, record.gap_floor);
  check_triangles(record.triangles, static_cast<Index>(record.x0.rows()));
  CollisionModel model;
  model.n_vertices = static_cast<Index>(record.x0.rows());
  model.triangles = record.triangles;
  model.edges = edge_table(model.n_vertices, record.triangles).edges;
  model.surfaces = record.surfaces;
  model.gap_floor = record.gap_floor;
  model.surface_of_vertex.assign(model.n_vertices, 0);
  model.surface_of_triangle.assign(record.triangles.rows(), 0);
  for (std::size_t s = 0; s < record.surfaces.size(); ++s) {
    check_surface(record, s);
    const CollisionSurface& surface = record.surfaces[s];
    std::fill_n(model.surface_of_vertex.begin() + surface.first_vertex, surface.n_vertices,
                static_cast<Index>(s));
    std::fill_n(model.surface_of_triangle.begin() + surface.first_triangle, surface.n_triangles,
                static_cast<Index>(s));
  }
  for (Index e = 0; e < model.edges.rows(); ++e)
    model.surface_of_edge.push_back(model.surface_of_vertex[model.edges(e, 0)]);
  return model;
}

// Every vertex of cloth can move, whatever its mass.
Vector movable(const CollisionModel& model) {
  Vector inverse_mass = Vector::Zero(model.n_vertices);
  for (const CollisionSurface& surface : model.surfaces)
    if (surface.kind == CollisionSurface::Kind::Cloth)
      inverse_mass.segment(surface.first_vertex, surface.n_vertices).setOnes();
  return inverse_mass;
}

}  // namespace

struct CollisionReplay::Data {
  explicit Data(CollisionRecord given)
      : record(std::move(given)),
        model(model_of(record)),
        pairs(surface_pairs(model)),
        boxes(model, pairs),
        inverse_mass(movable(model)) {}

  CollisionRecord record;
  const CollisionModel model;
  const std::vector<SurfacePair> pairs;
  BroadPhase boxes;
  const Vector inverse_mass;
};

CollisionReplay::CollisionReplay(CollisionRecord record)
    : data_(std::make_unique<Data>(std::move(record))) {}
CollisionReplay::~CollisionReplay() = default;

// Performs a search and returns the size of its results [bytes].
std::size_t CollisionReplay::find(Search search, const Team& team, SharedSearch& shared) const {
  Data& d = *data_;
  if (search == Search::Contacts) {
    find_contacts(team, d.model, d.pairs, d.record.x0, shared);
    return shared.result_bytes();
  }
  const std::shared_ptr<const Communicator> alone = single_communicator();
  NeighbourLists unused(d.model, d.pairs, d.boxes, *alone);
  ImpactSearch impacts(d.model, d.boxes, unused);
  impacts.share(&shared);
  impacts.find(team, {d.record.x0, d.inverse_mass, {}}, d.record.x1, nullptr);
  return shared.result_bytes();
}

RecordedTests CollisionReplay::measure(Search search, int n_ranks, int repetitions) const {
  if (n_ranks < 1) fail<InvalidInput>("ranks must be at least 1, got {}", n_ranks);
  if (repetitions < 1) fail<InvalidInput>("repetitions must be at least 1, got {}", repetitions);
  const Data& d = *data_;
  RecordedTests tests;
  SharedSearch shared(d.model, d.pairs, d.boxes, Decomposition::Static, single_communicator(),
                      n_ranks);
  shared.record(&tests);
  for (int i = 0; i < repetitions; ++i) tests.result_bytes = find(search, Team{}, shared);
  return tests;
}

std::vector<double> CollisionReplay::perform(Search search, const Execution& execution,
                                             int repetitions) const {
  if (execution.decomposition == Decomposition::Predicted)
    fail<Unsupported>("the decomposition must be static or dynamic, got predicted");
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
