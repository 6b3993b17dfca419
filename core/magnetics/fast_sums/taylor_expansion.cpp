#include "core/magnetics/fast_sums/taylor_expansion.h"

#include <algorithm>

#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

using Power = TaylorTables::Power;
using Derivative = TaylorTables::Derivative;
using Trace = TaylorTables::Trace;
using Shift = TaylorTables::Shift;

constexpr int most_places = 680;  // number of multi-indices up to degree 14
constexpr int most_slim = 225;    // number of multi-indices up to degree 14 with z exponent 0 or 1

// Computes x^k / k! for the first `n` multi-indices k in the order of TaylorTables.
template <class Lanes>
LOOMSTONE_INLINE void lane_powers(const Power* powers, int n, const Lanes3<Lanes>& x, Lanes* out) {
  const Lanes components[3] = {x.x, x.y, x.z};
  out[0] = lanes_all<Lanes>(1.0);
  for (int i = 1; i < n; ++i)
    out[i] = out[powers[i].before] * components[powers[i].axis] * powers[i].share;
}

struct PowerTables {
  const Power* powers;
  const int* next[3];
  int n_powers[2];  // numbers of multi-indices up to degrees order - 1 and order - 2
  int n_places;
};

PowerTables power_tables(const TaylorTables& t) {
  return {t.powers.data(),
          {t.next[0].data(), t.next[1].data(), t.next[2].data()},
          {t.n_powers[0], t.n_powers[1]},
          static_cast<int>(t.powers.size())};
}

// Strengths of charges (n) or dipoles (n x 3) at positions (n x 3).
struct Sources {
  const double *positions, *strengths;
  Index n;
};

template <class Lanes>
LOOMSTONE_INLINE void dipole_kernel(PowerTables t, Sources by, const double* centre, double* out) {
  const auto [powers, next, n_powers, n_places] = t;
  const auto [positions, dipoles, n] = by;
  Lanes sums[most_places], w[most_places];
  for (int i = 0; i < n_places; ++i) sums[i] = Lanes{};
  for (Index begin = 0; begin < n; begin += n_lanes) {
    double x[3][n_lanes], m[3][n_lanes];
    for (int lane = 0; lane < n_lanes; ++lane) {
      const bool real = begin + lane < n;
      for (int c = 0; c < 3; ++c) {
        x[c][lane] = real ? centre[c] - positions[3 * (begin + lane) + c] : 0.0;
        m[c][lane] = real ? dipoles[3 * (begin + lane) + c] : 0.0;
      }
    }
    lane_powers(
        powers, n_powers[0],
        Lanes3<Lanes>{lanes_load<Lanes>(x[0]), lanes_load<Lanes>(x[1]), lanes_load<Lanes>(x[2])},
        w);
    for (int i = 0; i < n_powers[0]; ++i)
      for (int c = 0; c < 3; ++c) sums[next[c][i]] -= lanes_load<Lanes>(m[c]) * w[i];
  }
  for (int i = 0; i < n_places; ++i) out[i] = lanes_sum(sums[i]);
}

template <class Lanes>
LOOMSTONE_INLINE void charge_kernel(PowerTables t, Sources by, const double* centre, double* out) {
  const auto [powers, next, n_powers, n_places] = t;
  const auto [positions, charges, n] = by;
  Lanes sums[most_places], w[most_places];
  for (int i = 0; i < n_places; ++i) sums[i] = Lanes{};
  for (Index begin = 0; begin < n; begin += n_lanes) {
    double x[3][n_lanes], q[n_lanes];
    for (int lane = 0; lane < n_lanes; ++lane) {
      const bool real = begin + lane < n;
      for (int c = 0; c < 3; ++c)
        x[c][lane] = real ? centre[c] - positions[3 * (begin + lane) + c] : 0.0;
      q[lane] = real ? charges[begin + lane] : 0.0;
    }
    lane_powers(
        powers, n_places,
        Lanes3<Lanes>{lanes_load<Lanes>(x[0]), lanes_load<Lanes>(x[1]), lanes_load<Lanes>(x[2])},
        w);
    for (int i = 0; i < n_places; ++i) sums[i] += lanes_load<Lanes>(q) * w[i];
  }
  for (int i = 0; i < n_places; ++i) out[i] = lanes_sum(sums[i]);
}

struct FarTables {
  const Derivative* steps;
  int n_steps;
  const Trace* traces;
  int n_traces;
  const std::uint16_t* products;
  const int *slim, *ends;
  int order;
};

template <class Lanes>
LOOMSTONE_INLINE void lane_derivatives(FarTables t, const Lanes* r, Lanes* d) {
  const Lanes inverse = 1.0 / (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  const Lanes x = r[0] * inverse, y = r[1] * inverse, z = r[2] * inverse;
  d[0] = lanes_sqrt(inverse);
  for (int i = 1; i < t.n_steps; ++i) {
    const Derivative& s = t.steps[i];
    d[s.target] =
        (s.first[0] * (x * d[s.first_place[0]]) + s.first[1] * (y * d[s.first_place[1]])) +
        (s.first[2] * (z * d[s.first_place[2]]) +
         inverse * (s.second[0] * d[s.second_place[0]] + s.second[1] * d[s.second_place[1]]));
  }
  for (int i = 0; i < t.n_traces; ++i)
    d[t.traces[i].target] = -d[t.traces[i].first] - d[t.traces[i].second];
}

// Returns the sum of m[k] d[place[k - 1]] over k = 1 ... last - 1, where m are moments and d are
// derivatives. The sum is accumulated in four partial sums.
template <class Lanes>
LOOMSTONE_INLINE Lanes lane_products(const Lanes* m, int last, const Lanes* d,
                                     const std::uint16_t* place) {
  Lanes part[4];
  for (Lanes& p : part) p = Lanes{};
  int k = 1;
  for (; k + 4 <= last; k += 4, place += 4)
    for (int j = 0; j < 4; ++j) part[j] += m[k + j] * d[place[j]];
  for (; k < last; ++k, ++place) part[0] += m[k] * d[*place];
  return (part[0] + part[1]) + (part[2] + part[3]);
}

// Adds the potentials of n far cells to `local`, as add_far() does. Processes eight far cells at a
// time and sums over the lanes once at the end.
template <class Lanes>
LOOMSTONE_INLINE void far_kernel(FarTables t, const TaylorExpansion::Far* far, Index n,
                                 double* local) {
  const int *slim = t.slim, *ends = t.ends;
  const int order = t.order;
  Lanes d[most_places], m[most_slim], sums[most_slim];
  const int n_slim = ends[order - 1];
  for (int i = 0; i < n_slim; ++i) sums[i] = Lanes{};
  static constexpr double none[most_slim] = {};
  for (Index begin = 0; begin < n; begin += n_lanes) {
    double arms[3][n_lanes];
    const double* moments[n_lanes];
    for (int lane = 0; lane < n_lanes; ++lane) {
      const bool real = begin + lane < n;
      moments[lane] = real ? far[begin + lane].moments : none;
      for (int c = 0; c < 3; ++c) arms[c][lane] = far[real ? begin + lane : begin].arm[c];
    }
    const Lanes r[3] = {lanes_load<Lanes>(arms[0]), lanes_load<Lanes>(arms[1]),
                        lanes_load<Lanes>(arms[2])};
    for (int i = 0; i < n_slim; ++i)
      m[i] = lanes_of<Lanes>([&](int lane) LOOMSTONE_INLINE_LAMBDA { return moments[lane][i]; });
    lane_derivatives(t, r, d);
    const std::uint16_t* place = t.products;
    int i = 1;
    for (int degree = 1; degree < order; ++degree) {
      const int last = ends[order - degree];
      for (; i < ends[degree]; ++i) {
        sums[i] += lane_products(m, last, d, place);
        place += last - 1;
        sums[i] += m[0] * d[slim[i]];
      }
    }
  }
  for (int i = 1; i < n_slim; ++i) local[slim[i]] += lanes_sum(sums[i]);
}

struct Local {
  const double *coefficients, *centre;
};

template <class Lanes>
LOOMSTONE_INLINE void evaluate_kernel(PowerTables t, Local at, const double* points, Index n,
                                      double* field, double* gradient) {
  const auto [powers, next, n_powers, n_places] = t;
  const auto [local, centre] = at;
  Lanes w[most_places];
  for (Index i = 0; i < n; i += n_lanes) {
    const Lanes3<Lanes> x{lanes_load<Lanes>(points + i) - centre[0],
                          lanes_load<Lanes>(points + n + i) - centre[1],
                          lanes_load<Lanes>(points + 2 * n + i) - centre[2]};
    lane_powers(powers, n_powers[0], x, w);
    Lanes b[3], g[6];
    for (Lanes& s : b) s = Lanes{};
    for (Lanes& s : g) s = Lanes{};
    for (int k = 0; k < n_powers[0]; ++k)
      for (int c = 0; c < 3; ++c) b[c] -= local[next[c][k]] * w[k];
    for (int k = 0; k < n_powers[1]; ++k) {
      const int to[3] = {next[0][k], next[1][k], next[2][k]};
      g[0] -= local[next[0][to[0]]] * w[k];
      g[1] -= local[next[1][to[0]]] * w[k];
      g[2] -= local[next[2][to[0]]] * w[k];
      g[3] -= local[next[1][to[1]]] * w[k];
      g[4] -= local[next[2][to[1]]] * w[k];
      g[5] -= local[next[2][to[2]]] * w[k];
    }
    for (int c = 0; c < 3; ++c) lanes_store(field + c * n + i, b[c]);
    for (int c = 0; c < 6; ++c) lanes_store(gradient + c * n + i, g[c]);
  }
}

}  // namespace

void TaylorExpansion::add_folded(double* all, double* moments) const {
  for (auto trace = tables_.traces.rbegin(); trace != tables_.traces.rend(); ++trace) {
    all[trace->first] -= all[trace->target];
    all[trace->second] -= all[trace->target];
  }
  for (std::size_t i = 0; i < tables_.slim.size(); ++i) moments[i] += all[tables_.slim[i]];
}

void TaylorExpansion::add_dipoles(const double* positions, const double* dipoles, Index n,
                                  const Vec3& centre, double* moments) const {
  double all[most_places];
  LOOMSTONE_WIDEST(dipole_kernel)(power_tables(tables_), Sources{positions, dipoles, n},
                                  centre.data(), all);
  add_folded(all, moments);
}

void TaylorExpansion::add_charges(const double* positions, const double* charges, Index n,
                                  const Vec3& centre, double* moments) const {
  double all[most_places];
  LOOMSTONE_WIDEST(charge_kernel)(power_tables(tables_), Sources{positions, charges, n},
                                  centre.data(), all);
  add_folded(all, moments);
}

void TaylorExpansion::shift_powers(const Vec3& shift, double* powers) const {
  powers[0] = 1.0;
  for (int i = 1; i < local_size(); ++i)
    powers[i] =
        powers[tables_.powers[i].before] * shift[tables_.powers[i].axis] * tables_.powers[i].share;
}

void TaylorExpansion::add_moments(const double* child, const Vec3& shift, double* moments) const {
  double powers[most_places], all[most_places];
  shift_powers(shift, powers);
  std::fill_n(all, local_size(), 0.0);
  for (const Shift& s : tables_.moment_shifts) all[s.target] += child[s.source] * powers[s.power];
  add_folded(all, moments);
}

void TaylorExpansion::add_far(const Far* far, Index n, double* local) const {
  const FarTables t{
      tables_.derivatives.data(),       static_cast<int>(tables_.derivatives.size()),
      tables_.derivative_traces.data(), static_cast<int>(tables_.derivative_traces.size()),
      tables_.products.data(),          tables_.slim.data(),
      tables_.slim_ends.data(),         tables_.order};
  LOOMSTONE_WIDEST(far_kernel)(t, far, n, local);
}

void TaylorExpansion::complete(double* local) const {
  for (const Trace& trace : tables_.traces)
    local[trace.target] = -local[trace.first] - local[trace.second];
}

void TaylorExpansion::add_local(const double* parent, const Vec3& shift, double* local) const {
  double powers[most_places];
  shift_powers(shift, powers);
  for (const Shift& s : tables_.local_shifts) local[s.target] += parent[s.source] * powers[s.power];
}

void TaylorExpansion::evaluate(const double* local, const Vec3& centre, const double* points,
                               Index n, double* field, double* gradient) const {
  LOOMSTONE_WIDEST(evaluate_kernel)(power_tables(tables_), Local{local, centre.data()}, points, n,
                                    field, gradient);
}

}  // namespace loomstone
