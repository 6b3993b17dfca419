#include "core/cloth/limits/limit_phase.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/cloth/membrane/membrane_batch.h"

namespace loomstone {

namespace {

constexpr int bound_stride = 12 * n_lanes;
constexpr Index batches_per_update = 32;

// The second phase of the membrane (limit_phase.h) begins at the distance limit_margin() inside the
// strain limit. The third phase begins at the fraction `third_begins` of the way from there to the
// limit. The fourth phase begins as far beyond the limit as the third phase begins inside it,
// because `third_begins` is 0.5. `stiffening` is the modulus added in the second phase, divided by
// that of the membrane. `steeper` and `steepest` are the total moduli added in the third and in the
// fourth phase, divided by the one added in the second phase.
//
// The third phase is for heavy loads, for example at prescribed vertices, and the fourth for bodies
// much heavier than the cloth. `stiffening` and `steeper` were tuned on scenes/swing_limits.py and
// scenes/limit_scaling.py with steps of 4 ms, and `steepest` with automatic steps on balls of 40 kg
// in cloth of 40 g: with a value of 100, strains exceed limits of 0.02 by up to 0.04, and with a
// value of 400 by up to 0.02. docs/experiments/strain_limits.md lists the results.
constexpr double stiffening = 300.0, steeper = 10.0, steepest = 400.0, third_begins = 0.5;

// In a yielding triangle (see LimitPhase::enter()), the stress that the phases add is bounded in
// one mode: the one that is farthest beyond the upper strain at which its second phase begins. At
// that strain, the bound is the fraction `yield_stress` of the stress that the phases add, without
// yielding, at the strain at which the fourth phase begins. The bound increases with the strain,
// with a slope of `hardening` times the modulus added in the second phase, so that neighbouring
// triangles yield alike. The other modes do not yield: an obstacle that is too wide along weft does
// not stretch the cloth along warp. Both values were tuned on `sleeve` in
// tests/benchmarks/extreme_scenes.py.
constexpr double yield_stress = 0.02, hardening = 0.2;

// Returns true if any mode of any lane is outside its bounds or NaN.
template <class Lanes>
LOOMSTONE_INLINE bool beyond_any(const Lanes strain[3], const double* bound) {
  const auto within = [&](int k) LOOMSTONE_INLINE_LAMBDA -> MaskOf<Lanes> {
    return (strain[k] >= lanes_load<Lanes>(bound + n_lanes * k)) &
           (strain[k] <= lanes_load<Lanes>(bound + n_lanes * (3 + k)));
  };
  return lanes_any(~(within(0) & within(1) & within(2)));
}

// Tables of the phases of all batches, and two arguments of LimitPhase::enter().
struct Phases {
  const double* bounds;
  const Index* bounds_of;
  double* table;
  std::uint8_t* entered;
  const std::uint8_t* yields;  // (vertices) may be null
  double recovery;             // see LimitPhase::enter()
};

// Returns 1 in the lanes of yielding triangles (see LimitPhase::enter()), and 0 in the others.
template <class Lanes>
LOOMSTONE_INLINE Lanes yielding_lanes(const Index* corners, const std::uint8_t* yields) {
  double lanes[n_lanes] = {};
  for (int k = 0; k < 3 * n_lanes; ++k)
    if (yields[corners[k]]) lanes[k % n_lanes] = 1.0;
  return lanes_load<Lanes>(lanes);
}

// Stress that the phases add to a mode, and the tangent with which it is linearised in the strain
// [N/m]. In the fourth phase and in yielding modes, the tangent can exceed the derivative of the
// stress, and the difference acts as a viscosity.
template <class Lanes>
struct ModeLaw {
  Lanes stress, tangent;
};

// Returns the law of mode k at strain e. `modulus` is the one added in the second phase [N/m]. In
// the fourth phase, viscosity limits the recovery of the strain: in one step, the excess decreases
// by at most about the fraction `recovery`.
template <class Lanes>
LOOMSTONE_INLINE ModeLaw<Lanes> law_of_mode(const double* bound, int k, Lanes modulus, Lanes e,
                                            double recovery) {
  const Lanes least = lanes_load<Lanes>(bound + n_lanes * k),
              most = lanes_load<Lanes>(bound + n_lanes * (3 + k));
  const Lanes far_least = lanes_load<Lanes>(bound + n_lanes * (6 + k)),
              far_most = lanes_load<Lanes>(bound + n_lanes * (9 + k));
  const MaskOf<Lanes> over = e > most, under = e < least;
  const MaskOf<Lanes> far_over = e > far_most, far_under = e < far_least;
  const Lanes beyond = lanes_select(over, e - most, lanes_select(under, e - least, Lanes{}));
  const Lanes far =
      lanes_select(far_over, e - far_most, lanes_select(far_under, e - far_least, Lanes{}));
  // Strains at which the fourth phase begins. Each limit lies half-way between the strain at which
  // the third phase begins and the one at which the fourth phase begins.
  const Lanes broken_most = far_most + 2.0 * (far_most - most),
              broken_least = far_least + 2.0 * (far_least - least);
  const MaskOf<Lanes> broken_over = e > broken_most, broken_under = e < broken_least;
  const Lanes broken = lanes_select(broken_over, e - broken_most,
                                    lanes_select(broken_under, e - broken_least, Lanes{}));
  const Lanes steepness = lanes_select(
      broken_over | broken_under, lanes_all<Lanes>(steepest / recovery),
      lanes_select(far_over | far_under, lanes_all<Lanes>(steeper), lanes_all<Lanes>(1.0)));
  return {modulus * (beyond + (steeper - 1.0) * far + (steepest - steeper) * broken),
          modulus * lanes_select(over | under, steepness, Lanes{})};
}

// Bounds the stress of mode k in the lanes in which `yields` is 1 and mode k is the mode that is
// farthest beyond the upper strain at which its second phase begins.
template <class Lanes>
LOOMSTONE_INLINE void let_yield(const double* bound, int k, Lanes modulus, const Lanes strain[3],
                                Lanes yields, ModeLaw<Lanes>& law) {
  const Lanes most = lanes_load<Lanes>(bound + n_lanes * (3 + k));
  const Lanes over = strain[k] - most;
  const Lanes margin = 2.0 * (lanes_load<Lanes>(bound + n_lanes * (9 + k)) - most);
  const Lanes largest = modulus * (yield_stress * (0.5 + steeper) * margin + hardening * over);
  MaskOf<Lanes> yielded = (over > 0.0) & (law.stress > largest) & (yields > 0.5);
  for (int other = 0; other < 3; ++other)
    yielded = yielded & (over >= strain[other] - lanes_load<Lanes>(bound + n_lanes * (3 + other)));
  law.stress = lanes_select(yielded, largest, law.stress);
  law.tangent = lanes_select(yielded, modulus, law.tangent);
}

template <class Lanes>
LOOMSTONE_INLINE void enter_batches(const membrane::Tables& tables, const Index* batches, Index n,
                                    Phases phases, const double* x) {
  for (Index i = 0; i < n; ++i) {
    const Index b = batches[i];
    const membrane::Batch<Lanes> batch = membrane::batch_of<Lanes>(tables, b);
    Lanes3<Lanes> f1, f2;
    membrane::gradient_columns(batch, x, f1, f2);
    const Lanes c11 = dot(f1, f1), c22 = dot(f2, f2), c12 = dot(f1, f2);
    // Computes U of the polar decomposition (element_limit.h), the Green strain E = (U^2 - I) / 2
    // and the diagonal of dE/dU.
    const Lanes d = lanes_sqrt(lanes_max0(c11 * c22 - c12 * c12));
    const Lanes trace = lanes_sqrt(c11 + c22 + 2.0 * d);
    const Lanes inverse = 1.0 / (trace + 1e-300);
    const Lanes u[3] = {(c11 + d) * inverse, (c22 + d) * inverse, c12 * inverse};
    const Lanes strain[3] = {u[0] - 1.0, u[1] - 1.0, u[2]};
    const Lanes green[3] = {0.5 * (c11 - 1.0), 0.5 * (c22 - 1.0), 0.5 * c12};
    const Lanes slope[3] = {u[0], u[1], 0.5 * trace};
    const double* bound =
        phases.bounds + bound_stride * static_cast<std::size_t>(phases.bounds_of[b]);
    phases.entered[b] = beyond_any(strain, bound);
    if (!phases.entered[b]) continue;
    double* o = phases.table + membrane::phase_stride * static_cast<std::size_t>(b);
    const Lanes yields =
        phases.yields ? yielding_lanes<Lanes>(batch.corners, phases.yields) : Lanes{};
    for (int k = 0; k < 3; ++k) {
      const Lanes modulus = (k == 2 ? 2.0 : 1.0) * stiffening *
                            batch.constant(k == 0   ? 1
                                           : k == 1 ? 2
                                                    : 4);
      ModeLaw<Lanes> law = law_of_mode(bound, k, modulus, strain[k], phases.recovery);
      if (phases.yields) let_yield(bound, k, modulus, strain, yields, law);
      lanes_store(o + n_lanes * k, law.tangent);
      lanes_store(o + n_lanes * (3 + k), slope[k] * law.stress - law.tangent * green[k]);
    }
  }
}

// Sets the bounds of one lane. They are infinite where a mode has no limit.
void set_bounds(const StrainLimit& limit, double* lane) {
  constexpr double free = std::numeric_limits<double>::infinity();
  const double least[3] = {limit.weft_min, limit.warp_min, limit.least_shear()},
               most[3] = {limit.weft, limit.warp, limit.shear};
  for (int k = 0; k < 3; ++k) {
    const bool compression_is_free = k < 2 && least[k] <= -1.0;
    const double below = limit_margin(least[k]), above = limit_margin(most[k]);
    lane[n_lanes * k] = compression_is_free ? -free : least[k] + below;
    lane[n_lanes * (3 + k)] = most[k] - above;
    lane[n_lanes * (6 + k)] = compression_is_free ? -free : least[k] + (1.0 - third_begins) * below;
    lane[n_lanes * (9 + k)] = most[k] - (1.0 - third_begins) * above;
  }
}

}  // namespace

LimitPhase::LimitPhase(Membrane& membrane, const std::vector<StrainLimit>& limits,
                       const std::vector<Index>& limit_of)
    : membrane_(membrane),
      bounds_of_(membrane.n_batches()),
      // A rank without triangles needs a table too, because Membrane::in_phase() compares the
      // pointer with null and must return the same value on all ranks.
      table_(std::max<std::size_t>(membrane.n_batches(), 1) * membrane::phase_stride, 0.0),
      entered_(membrane.n_batches(), 0) {
  using Rows = std::array<Index, n_lanes>;  // index into `limits` for each lane; -1: none
  std::map<Rows, Index> known;
  for (Index b = 0; b < membrane.n_batches(); ++b) {
    Rows rows;
    for (int l = 0; l < n_lanes; ++l)
      rows[l] = limit_of[std::min(membrane.batch_at(b) * n_lanes + l, membrane.n_triangles() - 1)];
    const auto [found, is_new] = known.try_emplace(rows, static_cast<Index>(known.size()));
    bounds_of_[b] = found->second;
    if (!is_new) continue;
    bounds_.resize(bounds_.size() + bound_stride);
    double* lane = bounds_.data() + bounds_.size() - bound_stride;
    for (const Index row : rows)  // edge limits are enforced after the solve
      set_bounds(row < 0 || limits[row].edge ? StrainLimit{} : limits[row], lane++);
  }
}

bool LimitPhase::enter(const Team& team, const Points& x, Index begin, Index end,
                       const std::uint8_t* yields, double recovery) {
  const std::vector<Index>& batches = membrane_.batches_of(begin, end);
  const Phases phases{bounds_.data(), bounds_of_.data(), table_.data(), entered_.data(),
                      yields,         recovery};
  parallel_ranges(team, static_cast<Index>(batches.size()), batches_per_update,
                  [&](Index first, Index last) {
                    LOOMSTONE_WIDEST(enter_batches)(membrane_.tables(), batches.data() + first,
                                                    last - first, phases, x.data());
                  });
  return std::any_of(batches.begin(), batches.end(), [&](Index b) { return entered_[b] != 0; });
}

}  // namespace loomstone
