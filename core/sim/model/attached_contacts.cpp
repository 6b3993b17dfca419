#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/narrow_phase/distance.h"
#include "core/collision/tangle/intersections.h"
#include "core/sim/model/build.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

// Largest contact distance between a body and a feature with an attached vertex, as a fraction of
// their distance at the start; see build_attached_contacts(). Our choice. With 1, contacts would
// push against an attachment as soon as its vertex moves towards the body.
constexpr double share_of_start = 0.75;
// Smallest contact distance that share_of_start may give, as a multiple of
// CollisionModel::gap_floor, the largest gap that certification keeps open. Features that would
// have a smaller contact distance do not collide with the body. Our choice: contacts need room to
// stop features before they reach this gap.
constexpr double least_floors = 10.0;

// Smallest distance [m] at the start between a body, given by its surface, and the features that
// contain `vertex`, which is attached to this body. Infinity: farther than the search reaches.
struct AttachedGap {
  Index vertex, surface;
  double gap = std::numeric_limits<double>::infinity();
};

// The gaps of all attached vertices, sorted by vertex and surface.
class AttachedGaps {
 public:
  AttachedGaps(const Model& model, const Points& x) : model_(model.collision), x_(x) {
    for (const AttachedVertex& each : model.attachments)
      gaps_.push_back({each.row, static_cast<Index>(model.scene.cloths.size()) + each.body});
    std::ranges::sort(gaps_, {}, key);
    find_near();
    if (model.scene.allow_initial_intersections) find_intersecting();
  }
  const std::vector<AttachedGap>& gaps() const { return gaps_; }

 private:
  static std::pair<Index, Index> key(const AttachedGap& each) {
    return {each.vertex, each.surface};
  }
  void note(Index vertex, Index surface, double gap) {
    const auto at = std::ranges::lower_bound(gaps_, std::pair(vertex, surface), {}, key);
    if (at != gaps_.end() && key(*at) == std::pair(vertex, surface))
      at->gap = std::min(at->gap, gap);
  }

  // Finds the gaps of features so close to the body at the start that their contact distance
  // changes.
  void find_near() {
    std::vector<std::uint8_t> attached(model_.surfaces.size(), 0);
    for (const AttachedGap& each : gaps_)
      attached[each.surface] = attached[model_.surface_of_vertex(each.vertex)] = 1;
    const std::vector<SurfacePair> pairs = surface_pairs(model_);
    std::vector<Index> which;
    std::vector<double> reach(pairs.size(), 0.0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto& [a, b, thickness, friction] = pairs[i];
      if (a == b || !attached[a] || !attached[b]) continue;
      which.push_back(static_cast<Index>(i));
      reach[i] = thickness / share_of_start;
    }
    std::vector<FeaturePairs> near(pairs.size());
    BroadPhase(model_, pairs).near_pairs({}, x_, which, reach, near);
    for (const Index i : which) {
      for (const PairKey key : near[i].vertex_face) look(pairs[i].b, ContactKind::VertexFace, key);
      for (const PairKey key : near[i].edge_edge) look(pairs[i].b, ContactKind::EdgeEdge, key);
    }
  }
  void look(Index surface, ContactKind kind, PairKey key) {
    const std::array<Index, 4> vertices = pair_vertices(model_, kind, key);
    FourPoints p;
    for (int k = 0; k < 4; ++k) p[k] = x_.row(vertices[k]).transpose();
    const bool face = kind == ContactKind::VertexFace;
    const double gap = (face ? closest_vertex_face(p) : closest_edge_edge(p)).distance;
    for (const Index vertex : vertices) note(vertex, surface, gap);
  }
  void find_intersecting() {
    for (const auto& [first, second] : cloth_intersections(model_, x_))
      for (int k = 0; k < 3; ++k) {
        note(model_.triangles(first, k), model_.surface_of_triangle(second), 0.0);
        note(model_.triangles(second, k), model_.surface_of_triangle(first), 0.0);
      }
  }

  const CollisionModel& model_;
  const Points& x_;
  std::vector<AttachedGap> gaps_;
};

}  // namespace

// Reduces contact distances between features of cloth and the body to which one of their vertices
// is attached. If such a feature is close to the body at the start, its contact distance is reduced
// to a fraction of its distance at the start (share_of_start), because the contact would otherwise
// push against the attachment. If this contact distance would be too small (least_floors), the
// feature does not collide with the body. If a vertex is attached to several bodies, these rules
// apply only to the one whose contact distance they reduce most.
void build_attached_contacts(const State& state, Model& model) {
  if (model.attachments.empty() || !model.scene.collisions) return;
  CollisionModel& collision = model.collision;
  Points x;
  collision_vertices(model, state, x);
  std::vector<AttachedTo> attached(collision.n_vertices);
  // Smallest ratio of AttachedGap::gap and the usual contact distance [1].
  std::vector<double> least(collision.n_vertices, std::numeric_limits<double>::infinity());
  const AttachedGaps found(model, x);
  for (const AttachedGap& each : found.gaps()) {
    AttachedTo& of_vertex = attached[each.vertex];
    const double usual =
        0.5 * (collision.surfaces[each.surface].thickness +
               collision.surfaces[collision.surface_of_vertex(each.vertex)].thickness);
    const double distance = share_of_start * each.gap, ratio = each.gap / usual;
    if (of_vertex.surface >= 0 && least[each.vertex] <= ratio) continue;
    of_vertex = {each.surface,
                 distance < least_floors * collision.gap_floor ? 0.0 : std::min(distance, usual)};
    least[each.vertex] = ratio;
  }
  collision.attached = std::move(attached);
}

}  // namespace loomstone
