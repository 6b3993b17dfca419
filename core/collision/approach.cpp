#include "core/collision/approach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/collision/approach_bounds.h"
#include "core/collision/narrow_phase/crossing.h"

namespace loomstone {

namespace {

using Six = std::array<Vec3, 6>;  // three vectors at the start of the step, then at its end

// Returns true only if the volume spanned by three linearly changing vectors keeps its sign, and
// its magnitude always exceeds `margin` [m] times an upper bound on the area spanned by the last
// two. May return false although this holds, because Bernstein coefficients only bound the volume.
bool off_plane(const Six& q, double margin) {
  const auto volume = [&](int i, int k, int l) { return q[i].dot(q[1 + k].cross(q[2 + l])); };
  const double b[4] = {volume(0, 0, 0), (volume(3, 0, 0) + volume(0, 3, 0) + volume(0, 0, 3)) / 3.0,
                       (volume(3, 3, 0) + volume(3, 0, 3) + volume(0, 3, 3)) / 3.0,
                       volume(3, 3, 3)};
  const Vec3 middle = 0.5 * (q[1].cross(q[5]) + q[4].cross(q[2]));
  const double base = std::max({q[1].cross(q[2]).norm(), middle.norm(), q[4].cross(q[5]).norm()});
  const double least = *std::min_element(b, b + 4), most = *std::max_element(b, b + 4);
  return std::max(least, -most) > margin * base;
}

PackedSlabs joined(const PackedSlabs& a, const PackedSlabs& b) {
  PackedSlabs all;
  for (int k = 0; k < n_slab_packs * slab_lanes; ++k)
    all.value[k] = std::min(a.value[k], b.value[k]);
  return all;
}

bool overlapping(const PackedSlabs& a, const PackedSlabs& b) {
  bool meet = true;  // upper bounds are stored with the opposite sign
  for (int k = 0; k < n_slabs; ++k)
    meet &= a.value[k] <= -b.value[n_slabs + k] && b.value[k] <= -a.value[n_slabs + k];
  return meet;
}

double added_reach(const ExpectedMotion& motion) { return largest_loss(0.0, motion.step); }

}  // namespace

std::int8_t side_of(ContactKind kind, const FourPoints& p) {
  const double volume = kind == ContactKind::VertexFace
                            ? (p[0] - p[1]).dot((p[2] - p[1]).cross(p[3] - p[1]))
                            : (p[2] - p[0]).dot((p[1] - p[0]).cross(p[3] - p[2]));
  return static_cast<std::int8_t>((volume > 0.0) - (volume < 0.0));
}

// Decides which feature pairs may come closer than their thickness during one step.
struct ApproachSearch::PairTest {
  const CollisionModel& model;
  const std::vector<SurfacePair>& pairs;
  const ExpectedMotion& motion;
  const Tangle& tangle;
  const std::vector<PackedSlabs>& boxes;  // boxes of the motions of the vertices

  // Returns the largest relative speed of two points, one on each feature [m/s].
  double relative_speed(ContactKind kind, const std::array<Index, 4>& v) const {
    const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
    double largest = 0.0;
    for (int i = 0; i < n_a; ++i)
      for (int k = n_a; k < 4; ++k)
        largest = std::max(largest, (motion.v0.row(v[k]) - motion.v0.row(v[i])).squaredNorm());
    return std::sqrt(largest);
  }
  bool boxes_meet(ContactKind kind, const std::array<Index, 4>& v) const {
    return kind == ContactKind::VertexFace
               ? overlapping(boxes[v[0]], joined(joined(boxes[v[1]], boxes[v[2]]), boxes[v[3]]))
               : overlapping(joined(boxes[v[0]], boxes[v[1]]), joined(boxes[v[2]], boxes[v[3]]));
  }
  FourPoints points(const std::array<Index, 4>& v) const {
    FourPoints p;
    for (int k = 0; k < 4; ++k) p[k] = motion.x0.row(v[k]).transpose();
    return p;
  }
  // Returns true only if the vertex stays farther than thickness + added_reach(motion) [m] from the
  // plane of the face, or the parallel planes through the two edges stay farther apart than this
  // distance, during the motion at faster_approach times the expected velocities. added_reach() is
  // the allowance for a change of velocity within the step.
  bool off_common_plane(ContactKind kind, const std::array<Index, 4>& v, double thickness) const {
    Six q;
    for (int s = 0; s < 2; ++s) {
      Vec3 p[4];
      for (int k = 0; k < 4; ++k)
        p[k] = (motion.x0.row(v[k]) + s * faster_approach * motion.step * motion.v0.row(v[k]))
                   .transpose();
      const bool vertex_face = kind == ContactKind::VertexFace;
      q[3 * s] = vertex_face ? p[0] - p[1] : p[2] - p[0];
      q[3 * s + 1] = vertex_face ? p[2] - p[1] : p[1] - p[0];
      q[3 * s + 2] = vertex_face ? p[3] - p[1] : p[3] - p[2];
    }
    return off_plane(q, thickness + added_reach(motion));
  }
  bool is_contact(const ApproachingPair& pair, const ClosestPair& closest, double thickness) const {
    const SurfacePair& surfaces = pairs[pair.pair];
    if (!(closest.distance < thickness)) return false;
    if (pair.kind == ContactKind::VertexFace) return true;
    const bool smooth = model.surfaces[surfaces.a].smooth || model.surfaces[surfaces.b].smooth;
    return !smooth && closest.interior;
  }
  // Returns the earliest time after the start of the step at which the pair may be closer than its
  // thickness [s].
  double wake(ContactKind kind, const std::array<Index, 4>& v, const ClosestPair& closest,
              double thickness) const {
    if (closest.distance <= thickness) return 0.0;
    std::array<double, 4> speeds;
    for (int k = 0; k < 4; ++k)
      speeds[k] = motion.v0.row(v[k]).dot(closest.difference.transpose()) / closest.distance;
    return time_to_close(closest.distance - thickness, largest_approach(kind, speeds));
  }
  // Call this function only if boxes_meet() returns true. Counts the pair as a candidate if its
  // distance at the start is at most its thickness plus largest_loss() at the relative speed
  // `speed` [m/s]. Adds a candidate to found.pairs unless it is culled (see ApproachSearch) or
  // ignored by the tangle. Returns the distance at the start [m].
  double look(ApproachingPair pair, const std::array<Index, 4>& v, double speed,
              Approach& found) const {
    const double thickness = contact_distance(model, pairs[pair.pair], pair.kind, v);
    const FourPoints p = points(v);
    const bool vertex_face = pair.kind == ContactKind::VertexFace;
    const ClosestPair closest = vertex_face ? closest_vertex_face(p) : closest_edge_edge(p);
    if (!(closest.distance <= thickness + largest_loss(speed, motion.step)))
      return closest.distance;
    ++found.candidates;
    pair.wake = wake(pair.kind, v, closest, thickness);
    if (!vertex_face && !closest.interior)
      pair.wake = std::max(pair.wake, time_to_close(motion_to_cross(p, thickness), speed));
    if (pair.wake > motion.step || off_common_plane(pair.kind, v, thickness) ||
        tangle.ignores(model, pair.kind, pair.key, v))
      return closest.distance;
    pair.contact = is_contact(pair, closest, thickness);
    if (closest.interior) pair.side = side_of(pair.kind, p);
    if (closest.distance > 0.0) pair.normal = closest.difference / closest.distance;
    found.pairs.push_back(pair);
    return closest.distance;
  }
  void look(const ApproachingPair& pair, Approach& found) const {
    const std::array<Index, 4> v = pair_vertices(model, pair.kind, pair.key);
    if (boxes_meet(pair.kind, v)) look(pair, v, relative_speed(pair.kind, v), found);
  }
};

// Data that a rank sends together with its pairs.
struct ApproachSearch::Note {
  NeighbourLists::Pass update, cover;
  std::int64_t candidates = 0;
};

namespace {

void append(const Approach& part, Approach& all) {
  all.candidates += part.candidates;
  all.pairs.insert(all.pairs.end(), part.pairs.begin(), part.pairs.end());
}

Approach joined(const std::vector<Approach>& parts) {
  Approach all;
  for (const Approach& part : parts) append(part, all);
  return all;
}

// Collects the pairs that test.look() finds in each task of the broad phase. The order of tasks
// does not depend on the number of threads.
template <class Test>
class CandidateSink final : public PairSink {
 public:
  explicit CandidateSink(const Test& test) : test_(test) {}
  void prepare(Index n_tasks) override { parts_.assign(n_tasks, {}); }
  void take(Index task, Index surface_pair, ContactKind kind, std::vector<PairKey>& keys) override {
    for (const PairKey key : keys) test_.look({kind, key, surface_pair, false}, parts_[task]);
  }
  const std::vector<Approach>& parts() const { return parts_; }

 private:
  const Test& test_;
  std::vector<Approach> parts_;
};

}  // namespace

ApproachSearch::ApproachSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                               BroadPhase& broad_phase, NeighbourLists& lists)
    : model_(model),
      pairs_(pairs),
      broad_phase_(broad_phase),
      lists_(lists),
      thickness_(model.surfaces.size(), 0.0),
      motion_(model.n_vertices) {
  for (const SurfacePair& pair : pairs)
    for (const Index s : {pair.a, pair.b}) thickness_[s] = std::max(thickness_[s], pair.thickness);
}

// Finds the end positions at faster_approach times the expected velocities, and the box of each
// vertex's motion to its end position.
void ApproachSearch::find_boxes(const Team& team, const ExpectedMotion& motion) {
  x1_.resize(motion.x0.rows(), 3);
  parallel_for(
      team, static_cast<Index>(motion.x0.rows()),
      [&](Index v) {
        x1_.row(v) = motion.x0.row(v) + faster_approach * motion.step * motion.v0.row(v);
        const double* const at = motion.x0.data() + 3 * static_cast<std::size_t>(v);
        const double thickness = thickness_[model_.surface_of_vertex(v)];
        motion_[v] = packed(slabs_of(at, x1_.data() + 3 * static_cast<std::size_t>(v),
                                     0.5 * (thickness + added_reach(motion))));
      },
      2048);
}

void ApproachSearch::find_in_list(NeighbourList& list, const PairTest& test,
                                  Approach& found) const {
  // Skips a list whose pairs are all too far apart at the start. list.change bounds the relative
  // displacement of the two features of any of these pairs in the motion to x1_. list.used bounds
  // the change of their distances since the list was made.
  const double thickness = pairs_[list.pair].thickness,
               farthest = thickness + added_reach(test.motion) + list.change + list.used;
  list.cost += ListCosts::list;
  if (farthest < list.nearest) return;
  list.nearest = std::numeric_limits<double>::infinity();
  std::size_t n_looks = 0;
  const std::int64_t n_before = found.candidates;
  for (std::size_t i = 0; i < list.near.size(); ++i) {
    NearPair& near = list.near[i];
    if (near.distance <= farthest) {
      const ApproachingPair pair{list.kind(i), near.key, list.pair, false};
      const std::array<Index, 4> v = pair_vertices(model_, pair.kind, pair.key);
      const double speed = test.relative_speed(pair.kind, v);
      const double reach = thickness + largest_loss(speed, test.motion.step);
      if (near.distance <= reach * 1.0000001 + list.used && test.boxes_meet(pair.kind, v)) {
        near.distance = test.look(pair, v, speed, found) + list.used;
        ++n_looks;
      }
    }
    list.nearest = std::min(list.nearest, near.distance);
  }
  list.cost += ListCosts::pair * static_cast<float>(list.near.size()) +
               ListCosts::distance * static_cast<float>(n_looks) +
               ListCosts::contact * static_cast<float>(found.candidates - n_before);
}

// Tests the pairs in the lists of this rank.
Approach ApproachSearch::find_listed(const Team& team, const PairTest& test) {
  lists_.make_ended(team);
  std::vector<Approach> of_range(lists_.n_ranges());
  lists_.each_list(
      team, [&](NeighbourList& list, Index range) { find_in_list(list, test, of_range[range]); });
  return joined(of_range);
}

// Tests feature pairs of the surface pairs `which`: those that this rank finds in its tasks of the
// broad phase.
Approach ApproachSearch::find_unlisted(const Team& team, const PairTest& test,
                                       const std::vector<Index>& which) {
  if (which.empty()) return {};
  const WorkTimer<double> timing = lists_.unlisted_timer();
  const double thickness = *std::max_element(thickness_.begin(), thickness_.end());
  const double margin = 0.5 * (thickness + added_reach(test.motion));  // added to each box [m]
  CandidateSink<PairTest> candidates(test);
  broad_phase_.swept_pairs(team, {test.motion.x0, x1_, margin}, which, candidates);
  return joined(candidates.parts());
}

Approach ApproachSearch::find(const Team& team, const ExpectedMotion& motion, const Tangle& tangle,
                              bool in_lists) {
  find_boxes(team, motion);
  if (in_lists) {
    lists_.widen(added_reach(motion));
    if (!lists_.updated_at(motion.x0)) lists_.begin_update(team, motion.x0);
    lists_.begin_cover(team, x1_, NeighbourLists::Cover::Reach);
  }
  const PairTest test{model_, pairs_, motion, tangle, motion_};
  std::vector<Index> all_pairs(pairs_.size());
  std::iota(all_pairs.begin(), all_pairs.end(), Index{0});
  const auto find = [&](Note& note) {
    Approach own;
    if (in_lists) {
      note.update = lists_.pass_at_x(team);
      if (!note.update.unexpected) note.cover = lists_.pass_to(team, x1_);
      if (note.update.unexpected || note.cover.unexpected) return own.pairs;
      own = find_listed(team, test);
    }
    append(find_unlisted(team, test, in_lists ? lists_.unlisted() : all_pairs), own);
    note.candidates = own.candidates;
    return std::move(own.pairs);
  };
  for (;;) {
    auto found = gather_again<ApproachingPair, Note>(lists_.ranks(), room_, find);
    std::vector<NeighbourLists::Pass> updates, covers;
    Approach all;
    for (const Note& note : found.notes) {
      updates.push_back(note.update);
      covers.push_back(note.cover);
      all.candidates += note.candidates;
    }
    if (in_lists && !(lists_.end_update(team, updates) && lists_.end_cover(team, x1_, covers)))
      continue;
    all.pairs = std::move(found.gathered.elements);
    std::sort(all.pairs.begin(), all.pairs.end(), [](const auto& a, const auto& b) {
      return std::tie(a.kind, a.key) < std::tie(b.kind, b.key);
    });
    return all;
  }
}

}  // namespace loomstone
