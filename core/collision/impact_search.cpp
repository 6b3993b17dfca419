#include "core/collision/impact_search.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace loomstone {

namespace {

Impact test_pair(ContactKind kind, const std::array<Index, 4>& v, const Points& x0, const Points& x1) {
  MovingPoints q;
  for (int i = 0; i < 4; ++i) {
    q[i] = x0.row(v[i]).transpose();
    q[4 + i] = x1.row(v[i]).transpose();
  }
  return kind == ContactKind::VertexFace ? continuous_vertex_face_above_gap(q) : continuous_edge_edge_above_gap(q);
}

}  // namespace

ImpactSearch::ImpactSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs, BroadPhase& broad_phase,
                           NearLists& lists, const Tangle& tangle)
    : model_(model), pairs_(pairs), broad_phase_(broad_phase), lists_(lists), tangle_(tangle) {}

std::vector<StepImpact> ImpactSearch::find(const Team& team, const Points& x0, const Points& x1, const Vector& inverse_mass,
                                           const std::vector<std::uint8_t>* changed) {
  constexpr Index grain = 1024;
  travel_.resize(model_.n_vertices);
  parallel_for(
      team, model_.n_vertices, [&](Index i) { travel_[i] = (x1.row(i) - x0.row(i)).norm(); }, 4096);

  // Is the pair worth testing? Lets every pair through that is not surely irrelevant.
  const auto concerned = [&](const std::array<Index, 4>& v) {
    if (changed && !((*changed)[v[0]] | (*changed)[v[1]] | (*changed)[v[2]] | (*changed)[v[3]])) return false;
    return inverse_mass[v[0]] > 0.0 || inverse_mass[v[1]] > 0.0 || inverse_mass[v[2]] > 0.0 || inverse_mass[v[3]] > 0.0;
  };
  const auto hits = [&](ContactKind kind, PairKey key, const std::array<Index, 4>& v) {
    const Impact impact = test_pair(kind, v, x0, x1);
    return impact.hit && !impact.touching && !tangle_.leaves_out(kind, key, v);
  };

  std::vector<FeaturePairs> found(pairs_.size());
  const std::vector<SurfaceMotion> motions = surface_motions(model_, x0, x1);
  const bool lists_fit = lists_.updated_at(x0);
  std::vector<Index> uncovered;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i) {
    // The floor must lie below the distance that lists are complete for.
    if (!lists_fit || !lists_.covers(i, motions) || pairs_[i].thickness < 1.01 * largest_gap_floor) {
      uncovered.push_back(i);
      continue;
    }
    const auto scan = [&](ContactKind kind, const std::vector<PairKey>& keys, const std::vector<double>& distances,
                          std::vector<PairKey>& out) {
      const Index n = static_cast<Index>(keys.size());
      const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
      std::vector<std::vector<PairKey>> of_range((n + grain - 1) / grain);
      parallel_ranges(team, n, grain, [&](Index begin, Index end) {
        for (Index e = begin; e < end; ++e) {
          const std::array<Index, 4> v = pair_vertices(model_, kind, keys[e]);
          const double travel_a = n_a == 1 ? travel_[v[0]] : std::max(travel_[v[0]], travel_[v[1]]);
          const double travel_b = std::max({travel_[v[n_a]], travel_[v[2]], travel_[v[3]]});
          // Too far apart at the start to come near (closest points have no larger travel than their corners).
          if ((travel_a + travel_b) * 1.0000001 + 1.01 * largest_gap_floor < distances[e]) continue;
          if (concerned(v) && hits(kind, keys[e], v)) of_range[begin / grain].push_back(keys[e]);
        }
      });
      for (const std::vector<PairKey>& range : of_range) out.insert(out.end(), range.begin(), range.end());
    };
    NearList& list = lists_.list(i);
    scan(ContactKind::VertexFace, list.pairs.vertex_face, list.vertex_face_distance, found[i].vertex_face);
    scan(ContactKind::EdgeEdge, list.pairs.edge_edge, list.edge_edge_distance, found[i].edge_edge);
  }
  if (!uncovered.empty())
    broad_phase_.swept_pairs(
        team, x0, x1, 1.01 * largest_gap_floor, uncovered,
        [&](ContactKind kind, std::vector<PairKey>& keys) {
          std::erase_if(keys, [&](PairKey key) {
            const std::array<Index, 4> v = pair_vertices(model_, kind, key);
            return !concerned(v) || !hits(kind, key, v);
          });
        },
        found);

  std::vector<StepImpact> impacts;
  for (Index i = 0; i < static_cast<Index>(pairs_.size()); ++i)
    for (const ContactKind kind : {ContactKind::VertexFace, ContactKind::EdgeEdge})
      for (const PairKey key : kind == ContactKind::VertexFace ? found[i].vertex_face : found[i].edge_edge)
        impacts.push_back({kind, key, i, pair_vertices(model_, kind, key), {}});
  parallel_for(
      team, static_cast<Index>(impacts.size()),
      [&](Index i) { impacts[i].impact = test_pair(impacts[i].kind, impacts[i].vertices, x0, x1); }, 512);
  std::sort(impacts.begin(), impacts.end(), [](const StepImpact& x, const StepImpact& y) {
    return std::tie(x.kind, x.key) < std::tie(y.kind, y.key);
  });
  return impacts;
}

}  // namespace loomstone
