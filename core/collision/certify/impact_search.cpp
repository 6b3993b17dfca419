#include "core/collision/certify/impact_search.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace loomstone {

namespace {

Impact test_pair(ContactKind kind, const std::array<Index, 4>& v, const Points& x0,
                 const Points& x1, double gap_floor) {
  MovingPoints q;
  for (int i = 0; i < 4; ++i) {
    q[i] = x0.row(v[i]).transpose();
    q[4 + i] = x1.row(v[i]).transpose();
  }
  return kind == ContactKind::VertexFace ? continuous_vertex_face_above_gap(q, gap_floor)
                                         : continuous_edge_edge_above_gap(q, gap_floor);
}

void sort_impacts(std::vector<StepImpact>& impacts) {
  std::sort(impacts.begin(), impacts.end(), [](const StepImpact& x, const StepImpact& y) {
    return std::tie(x.kind, x.key) < std::tie(y.kind, y.key);
  });
}

}  // namespace

ImpactSearch::ImpactSearch(const CollisionModel& model, BroadPhase& broad_phase,
                           NeighbourLists& lists)
    : model_(model), broad_phase_(broad_phase), lists_(lists) {}

// Decides whether a feature pair has an impact that find() must return, in the motion from
// inputs.x0 to x1.
struct ImpactSearch::PairTest {
  const CollisionModel& model;
  const MotionInputs& inputs;
  const Points& x1;
  const std::vector<std::uint8_t>* changed;

  // Returns whether the pair has a movable vertex and, if `changed` is given, a changed vertex.
  bool concerned(const std::array<Index, 4>& v) const {
    if (changed && !((*changed)[v[0]] | (*changed)[v[1]] | (*changed)[v[2]] | (*changed)[v[3]]))
      return false;
    const Vector& inverse_mass = inputs.inverse_mass;
    return inverse_mass[v[0]] > 0.0 || inverse_mass[v[1]] > 0.0 || inverse_mass[v[2]] > 0.0 ||
           inverse_mass[v[3]] > 0.0;
  }

  bool hits(ContactKind kind, PairKey key, const std::array<Index, 4>& v, Impact& impact) const {
    if (!concerned(v)) return false;
    impact = test_pair(kind, v, inputs.x0, x1, model.gap_floor);
    return impact.hit && !impact.touching && !inputs.tangle.ignores(model, kind, key, v);
  }
};

std::vector<StepImpact> ImpactSearch::find(const Team& team, const MotionInputs& inputs,
                                           const Points& x1,
                                           const std::vector<std::uint8_t>* changed) {
  const PairTest test{model_, inputs, x1, changed};
  if (shared_) return find_shared(team, test);
  if (!lists_.updated_at(inputs.x0)) lists_.update(team, inputs.x0);
  lists_.begin_cover(team, x1);
  const auto find = [&](NeighbourLists::Pass& pass) {
    pass = lists_.pass_to(team, x1);
    return pass.unexpected ? std::vector<StepImpact>() : find_own(team, test);
  };
  for (;;) {
    auto all = gather_again<StepImpact, NeighbourLists::Pass>(lists_.ranks(), room_, find);
    if (!lists_.end_cover(team, x1, all.notes)) continue;
    sort_impacts(all.gathered.elements);
    return std::move(all.gathered.elements);
  }
}

std::vector<StepImpact> ImpactSearch::find_shared(const Team& team, const PairTest& test) const {
  const std::vector<double> inflation(model_.surfaces.size(), 1.01 * model_.gap_floor);
  std::vector<std::vector<StepImpact>> of_thread(std::max(1, team.threads));
  shared_->each_pair(team, {test.inputs.x0, test.x1, inflation},
                     [&](int thread, Index pair, ContactKind kind, PairKey key) {
                       const std::array<Index, 4> v = pair_vertices(model_, kind, key);
                       Impact impact;
                       if (test.hits(kind, key, v, impact))
                         of_thread[thread].push_back({kind, key, pair, v, impact});
                     });
  std::vector<StepImpact> impacts = shared_->gather(of_thread);
  sort_impacts(impacts);
  return impacts;
}

// Finds the impacts of the pairs that this rank tests.
std::vector<StepImpact> ImpactSearch::find_own(const Team& team, const PairTest& test) {
  lists_.make_ended(team);
  std::vector<StepImpact> impacts = find_listed(team, test);
  find_unlisted(team, test, impacts);
  return impacts;
}

std::vector<StepImpact> ImpactSearch::find_listed(const Team& team, const PairTest& test) {
  const Points &x0 = test.inputs.x0, &x1 = test.x1;
  const std::vector<Index>& vertices = lists_.vertices();
  travel_.resize(model_.n_vertices);
  parallel_for(
      team, static_cast<Index>(vertices.size()),
      [&](Index i) {
        const Index v = vertices[i];
        travel_[v] = (x1.row(v) - x0.row(v)).norm();
      },
      4096);
  std::vector<std::vector<StepImpact>> of_range(lists_.n_ranges());
  lists_.each_list(
      team, [&](NeighbourList& list, Index range) { find_in_list(list, test, of_range[range]); });
  std::vector<StepImpact> impacts;
  for (const std::vector<StepImpact>& range : of_range)
    impacts.insert(impacts.end(), range.begin(), range.end());
  return impacts;
}

void ImpactSearch::find_in_list(NeighbourList& list, const PairTest& test,
                                std::vector<StepImpact>& impacts) const {
  // Skips lists, and pairs in them, whose features are too far apart at the start to meet. No point
  // of a feature travels farther than the corner of this feature that travels farthest.
  const double reach = 1.01 * model_.gap_floor + list.used;
  list.cost += ListCosts::list;
  if (list.change + reach < list.nearest) return;
  std::size_t n_tests = 0;
  for (std::size_t i = 0; i < list.near.size(); ++i) {
    const NearPair& near = list.near[i];
    if (list.change + reach < near.distance) continue;
    const ContactKind kind = list.kind(i);
    const std::array<Index, 4> v = pair_vertices(model_, kind, near.key);
    const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
    const double travel_a = n_a == 1 ? travel_[v[0]] : std::max(travel_[v[0]], travel_[v[1]]);
    const double travel_b = std::max({travel_[v[n_a]], travel_[v[2]], travel_[v[3]]});
    if ((travel_a + travel_b) * 1.0000001 + reach < near.distance) continue;
    Impact impact;
    ++n_tests;
    if (test.hits(kind, near.key, v, impact))
      impacts.push_back({kind, near.key, list.pair, v, impact});
  }
  list.cost += ListCosts::pair * static_cast<float>(list.near.size()) +
               ListCosts::impact * static_cast<float>(n_tests);
}

void ImpactSearch::find_unlisted(const Team& team, const PairTest& test,
                                 std::vector<StepImpact>& impacts) {
  const std::vector<Index> unlisted = lists_.unlisted();
  if (unlisted.empty()) return;
  const WorkTimer<double> timing = lists_.unlisted_timer();
  const Points &x0 = test.inputs.x0, &x1 = test.x1;
  std::vector<FeaturePairs> found;
  broad_phase_.swept_pairs(
      team, {x0, x1, 1.01 * model_.gap_floor}, unlisted,
      [&](ContactKind kind, std::vector<PairKey>& keys) {
        std::erase_if(keys, [&](PairKey key) {
          Impact impact;
          return !test.hits(kind, key, pair_vertices(model_, kind, key), impact);
        });
      },
      found);
  for (const Index i : unlisted)
    for (const ContactKind kind : {ContactKind::VertexFace, ContactKind::EdgeEdge})
      for (const PairKey key :
           kind == ContactKind::VertexFace ? found[i].vertex_face : found[i].edge_edge) {
        const std::array<Index, 4> v = pair_vertices(model_, kind, key);
        impacts.push_back({kind, key, i, v, test_pair(kind, v, x0, x1, model_.gap_floor)});
      }
}

}  // namespace loomstone
