#include "core/collision/approach.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/collision/narrow_phase/distance.h"

namespace loomstone {

namespace {

using Six = std::array<Vec3, 6>;  // three vectors at the start, then the same vectors at the end

// Returns true if the volume spanned by three linearly changing vectors keeps its sign and if its
// magnitude always exceeds `margin` times an upper bound of the area that the last two vectors
// span. The volume is bounded by its Bernstein coefficients.
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

struct PairTest {
  const CollisionModel& model;
  const ExpectedMotion& motion;
  const Tangle& tangle;

  // Returns a bound on the relative displacement of two points, one of each feature [m].
  double travel(ContactKind kind, const std::array<Index, 4>& v) const {
    const int n_a = kind == ContactKind::VertexFace ? 1 : 2;
    double largest = 0.0;
    for (int i = 0; i < n_a; ++i)
      for (int k = n_a; k < 4; ++k)
        largest = std::max(largest, (motion.v0.row(v[k]) - motion.v0.row(v[i])).squaredNorm());
    return (faster_approach * std::sqrt(largest) + added_approach) * motion.step;
  }
  bool close(ContactKind kind, const std::array<Index, 4>& v, double thickness) const {
    FourPoints points;
    for (int k = 0; k < 4; ++k) points[k] = motion.x0.row(v[k]).transpose();
    const double reach = thickness + travel(kind, v);
    return distance_within(kind == ContactKind::VertexFace, points, reach) <= reach;
  }
  bool culled(ContactKind kind, const std::array<Index, 4>& v, double thickness) const {
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
    return off_plane(q, thickness + added_approach * motion.step);
  }
};

// Counts the pair as a candidate. Adds it if it may come close, is not culled, and is not ignored
// because of a tangle.
void add(const PairTest& test, const ApproachingPair& pair, double thickness, Approach& found) {
  const std::array<Index, 4> v = pair_vertices(test.model, pair.kind, pair.key);
  ++found.candidates;
  if (!test.close(pair.kind, v, thickness) || test.culled(pair.kind, v, thickness)) return;
  if (!test.tangle.ignores(test.model, pair.kind, pair.key, v)) found.pairs.push_back(pair);
}

// Tests the pairs of each task of the broad phase. The order of tasks does not depend on threads.
class Candidates final : public PairSink {
 public:
  Candidates(const std::vector<SurfacePair>& pairs, const PairTest& test)
      : pairs_(pairs), test_(test) {}
  void prepare(Index n_tasks) override { parts_.assign(n_tasks, {}); }
  void take(Index task, Index surface_pair, ContactKind kind, std::vector<PairKey>& keys) override {
    for (const PairKey key : keys)
      add(test_, {kind, key, surface_pair}, pairs_[surface_pair].thickness, parts_[task]);
  }
  Approach take_all() const {
    Approach all;
    for (const Approach& part : parts_) {
      all.candidates += part.candidates;
      all.pairs.insert(all.pairs.end(), part.pairs.begin(), part.pairs.end());
    }
    return all;
  }

 private:
  const std::vector<SurfacePair>& pairs_;
  const PairTest& test_;
  std::vector<Approach> parts_;
};

}  // namespace

Approach find_approach(const Team& team, const PairSource& source, const ExpectedMotion& motion,
                       const Tangle& tangle) {
  const std::vector<SurfacePair>& pairs = source.pairs;
  const PairTest test{source.model, motion, tangle};
  const Points x1 = motion.x0 + faster_approach * motion.step * motion.v0;
  double thickness = 0.0;
  std::vector<Index> which(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    which[i] = static_cast<Index>(i);
    thickness = std::max(thickness, pairs[i].thickness);
  }
  Candidates candidates(pairs, test);
  const double margin = 0.5 * (thickness + added_approach * motion.step);  // around features [m]
  Approach all;
  all.pairs = gather_from_ranks(source.ranks, [&] {
                source.broad_phase.swept_pairs(team, {motion.x0, x1, margin}, which, candidates);
                Approach own = candidates.take_all();
                all.candidates = own.candidates;
                return std::move(own.pairs);
              }).elements;
  const std::vector<std::int64_t> counts =
      results_of_ranks(source.ranks, [&] { return all.candidates; });
  all.candidates = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  std::sort(all.pairs.begin(), all.pairs.end(), [](const auto& a, const auto& b) {
    return std::tie(a.kind, a.key) < std::tie(b.kind, b.key);
  });
  return all;
}

}  // namespace loomstone
