#include "core/magnetics/fast_sums/taylor_expansion.h"

#include <algorithm>
#include <array>

#include "core/magnetics/sources/lane_math.h"

namespace loomstone {

namespace {

using Power = TaylorExpansion::Power;
using Derivative = TaylorExpansion::Derivative;
using Trace = TaylorExpansion::Trace;

constexpr int most_places = 680;  // of order 14
constexpr int most_slim = 225;

// x^k / k! of `n` places.
template <class Lanes>
LOOMSTONE_INLINE void lane_powers(const Power* powers, int n, const Lanes3<Lanes>& x, Lanes* out) {
  const Lanes components[3] = {x.x, x.y, x.z};
  out[0] = lanes_all<Lanes>(1.0);
  for (int i = 1; i < n; ++i)
    out[i] = out[powers[i].before] * components[powers[i].axis] * powers[i].share;
}

template <class Lanes>
LOOMSTONE_INLINE void dipole_kernel(const Power* powers, const int* const* next, int n_powers,
                                    int n_places, const double* positions, const double* dipoles,
                                    Index n, const double* centre, double* out) {
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
        powers, n_powers,
        Lanes3<Lanes>{lanes_load<Lanes>(x[0]), lanes_load<Lanes>(x[1]), lanes_load<Lanes>(x[2])},
        w);
    for (int i = 0; i < n_powers; ++i)
      for (int c = 0; c < 3; ++c) sums[next[c][i]] -= lanes_load<Lanes>(m[c]) * w[i];
  }
  for (int i = 0; i < n_places; ++i) out[i] = lanes_sum(sums[i]);
}

template <class Lanes>
LOOMSTONE_INLINE void charge_kernel(const Power* powers, int n_places, const double* positions,
                                    const double* charges, Index n, const double* centre,
                                    double* out) {
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

template <class Lanes>
LOOMSTONE_INLINE void lane_derivatives(const Derivative* steps, int n_steps, const Trace* traces,
                                       int n_traces, const Lanes* r, Lanes* d) {
  const Lanes inverse = 1.0 / (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  const Lanes x = r[0] * inverse, y = r[1] * inverse, z = r[2] * inverse;
  d[0] = lanes_sqrt(inverse);
  for (int i = 1; i < n_steps; ++i) {
    const Derivative& s = steps[i];
    d[s.target] =
        (s.first[0] * (x * d[s.first_place[0]]) + s.first[1] * (y * d[s.first_place[1]])) +
        (s.first[2] * (z * d[s.first_place[2]]) +
         inverse * (s.second[0] * d[s.second_place[0]] + s.second[1] * d[s.second_place[1]]));
  }
  for (int i = 0; i < n_traces; ++i)
    d[traces[i].target] = -d[traces[i].first] - d[traces[i].second];
}

// Eight far cells at a time; lanes are summed once at the end.
template <class Lanes>
LOOMSTONE_INLINE void far_kernel(const Derivative* steps, int n_steps, const Trace* traces,
                                 int n_traces, const std::uint16_t* products, const int* slim,
                                 const int* ends, int order, const TaylorExpansion::Far* far,
                                 Index n, double* local) {
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
    lane_derivatives(steps, n_steps, traces, n_traces, r, d);
    const std::uint16_t* place = products;
    int i = 1;
    for (int degree = 1; degree < order; ++degree) {
      const int last = ends[order - degree];
      for (; i < ends[degree]; ++i) {
        Lanes part[4];
        for (Lanes& p : part) p = Lanes{};
        int k = 1;
        for (; k + 4 <= last; k += 4, place += 4)
          for (int j = 0; j < 4; ++j) part[j] += m[k + j] * d[place[j]];
        for (; k < last; ++k, ++place) part[0] += m[k] * d[*place];
        sums[i] += (part[0] + part[1]) + (part[2] + part[3]);
        sums[i] += m[0] * d[slim[i]];
      }
    }
  }
  for (int i = 1; i < n_slim; ++i) local[slim[i]] += lanes_sum(sums[i]);
}

template <class Lanes>
LOOMSTONE_INLINE void evaluate_kernel(const Power* powers, const int* const* next,
                                      const int* n_powers, const double* local,
                                      const double* centre, const double* points, Index n,
                                      double* field, double* gradient) {
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

TaylorExpansion::TaylorExpansion(int order) : order_(order) {
  struct Exponents {
    int n[3];
  };
  std::vector<Exponents> places;
  const int side = order + 3;
  std::vector<int> place_of(side * side * side, -1);
  const auto place = [&](int x, int y, int z) -> int& {
    return place_of[(x * side + y) * side + z];
  };
  for (int degree = 0; degree <= order; ++degree) {
    for (int z = 0; z <= degree; ++z) {
      for (int x = degree - z; x >= 0; --x) {
        place(x, degree - z - x, z) = static_cast<int>(places.size());
        if (z <= 1) slim_.push_back(static_cast<int>(places.size()));
        places.push_back({{x, degree - z - x, z}});
      }
    }
    slim_ends_.push_back(static_cast<int>(slim_.size()));
    if (degree >= order - 2 && degree < order)
      n_powers_[order - 1 - degree] = static_cast<int>(places.size());
  }
  for (int y = 0; y <= order; ++y)
    for (int z = 0; y + z <= order; ++z)
      for (int x = 0; x + y + z <= order; ++x) rows_.push_back(place(x, y, z));
  for (int i = 0; i < static_cast<int>(places.size()); ++i) {
    const int x = places[i].n[0], y = places[i].n[1], z = places[i].n[2];
    const int degree = x + y + z, axis = x > 0 ? 0 : y > 0 ? 1 : 2, largest = places[i].n[axis];
    const auto less = [&](int along, int by) {
      int n[3] = {x, y, z};
      n[along] -= by;
      return n[along] < 0 ? 0 : place(n[0], n[1], n[2]);
    };
    powers_.push_back({less(axis, 1), axis, largest > 0 ? 1.0 / largest : 1.0});
    next_[0].push_back(place(x + 1, y, z));
    next_[1].push_back(place(x, y + 1, z));
    next_[2].push_back(place(x, y, z + 1));
    if (z >= 2) {
      const Trace trace{i, place(x + 2, y, z - 2), place(x, y + 2, z - 2)};
      traces_.push_back(trace);
      if (z == 2) derivative_traces_.push_back(trace);
      continue;
    }
    // k r^2 D_n + (2 k - 1) sum n_i x_i D_{n - e_i} + (k - 1) sum n_i (n_i - 1) D_{n - 2 e_i} = 0,
    // k = |n|
    Derivative d{i, {}, {}, {}, {}};
    for (int c = 0; c < 3 && degree > 0; ++c) {
      const int count = places[i].n[c];
      d.first[c] = -(2.0 * degree - 1.0) / degree * count;
      d.first_place[c] = less(c, 1);
      if (c == 2) continue;
      d.second[c] = -(degree - 1.0) / degree * count * (count - 1);
      d.second_place[c] = less(c, 2);
    }
    derivatives_.push_back(d);
  }
  std::stable_sort(traces_.begin(), traces_.end(), [&](const Trace& a, const Trace& b) {
    return places[a.target].n[2] < places[b.target].n[2];
  });
  const auto sum = [&](int a, int b) {
    return place(places[a].n[0] + places[b].n[0], places[a].n[1] + places[b].n[1],
                 places[a].n[2] + places[b].n[2]);
  };
  for (int degree = 1; degree < order; ++degree)
    for (int i = slim_ends_[degree - 1]; i < slim_ends_[degree]; ++i)
      for (int k = 1; k < slim_ends_[order - degree]; ++k)
        products_.push_back(static_cast<std::uint16_t>(sum(slim_[i], slim_[k])));
  for (int i = 0; i < static_cast<int>(slim_.size()); ++i) {
    const auto& n = places[slim_[i]].n;
    const int degree = n[0] + n[1] + n[2];
    for (int k = 0; k < static_cast<int>(places.size()); ++k) {
      if (degree + places[k].n[0] + places[k].n[1] + places[k].n[2] > order) break;
      moment_shifts_.push_back({sum(slim_[i], k), i, k});
      if (degree > 0) local_shifts_.push_back({slim_[i], sum(slim_[i], k), k});
    }
  }
}

void TaylorExpansion::add_folded(double* all, double* moments) const {
  for (auto trace = traces_.rbegin(); trace != traces_.rend(); ++trace) {
    all[trace->first] -= all[trace->target];
    all[trace->second] -= all[trace->target];
  }
  for (std::size_t i = 0; i < slim_.size(); ++i) moments[i] += all[slim_[i]];
}

void TaylorExpansion::add_dipoles(const double* positions, const double* dipoles, Index n,
                                  const Vec3& centre, double* moments) const {
  double all[most_places];
  const int* next[3] = {next_[0].data(), next_[1].data(), next_[2].data()};
  LOOMSTONE_WIDEST(dipole_kernel)(powers_.data(), next, n_powers_[0], local_size(), positions,
                                  dipoles, n, centre.data(), all);
  add_folded(all, moments);
}

void TaylorExpansion::add_charges(const double* positions, const double* charges, Index n,
                                  const Vec3& centre, double* moments) const {
  double all[most_places];
  LOOMSTONE_WIDEST(charge_kernel)(powers_.data(), local_size(), positions, charges, n,
                                  centre.data(), all);
  add_folded(all, moments);
}

void TaylorExpansion::shift_powers(const Vec3& shift, double* powers) const {
  powers[0] = 1.0;
  for (int i = 1; i < local_size(); ++i)
    powers[i] = powers[powers_[i].before] * shift[powers_[i].axis] * powers_[i].share;
}

void TaylorExpansion::add_moments(const double* child, const Vec3& shift, double* moments) const {
  double powers[most_places], all[most_places];
  shift_powers(shift, powers);
  std::fill_n(all, local_size(), 0.0);
  for (const Shift& s : moment_shifts_) all[s.target] += child[s.source] * powers[s.power];
  add_folded(all, moments);
}

void TaylorExpansion::add_far(const Far* far, Index n, double* local) const {
  LOOMSTONE_WIDEST(far_kernel)(derivatives_.data(), static_cast<int>(derivatives_.size()),
                               derivative_traces_.data(),
                               static_cast<int>(derivative_traces_.size()), products_.data(),
                               slim_.data(), slim_ends_.data(), order_, far, n, local);
}

void TaylorExpansion::complete(double* local) const {
  for (const Trace& trace : traces_)
    local[trace.target] = -local[trace.first] - local[trace.second];
}

void TaylorExpansion::add_local(const double* parent, const Vec3& shift, double* local) const {
  double powers[most_places];
  shift_powers(shift, powers);
  for (const Shift& s : local_shifts_) local[s.target] += parent[s.source] * powers[s.power];
}

void TaylorExpansion::evaluate(const double* local, const Vec3& centre, const double* points,
                               Index n, double* field, double* gradient) const {
  const int* next[3] = {next_[0].data(), next_[1].data(), next_[2].data()};
  LOOMSTONE_WIDEST(evaluate_kernel)(powers_.data(), next, n_powers_, local, centre.data(), points,
                                    n, field, gradient);
}

}  // namespace loomstone
