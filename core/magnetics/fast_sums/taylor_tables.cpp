#include "core/magnetics/fast_sums/taylor_tables.h"

#include <algorithm>

namespace loomstone {

namespace {

struct Exponents {
  int n[3];
  int degree() const { return n[0] + n[1] + n[2]; }
};

// All multi-indices up to a degree, in the order of their places.
class MultiIndices {
 public:
  explicit MultiIndices(int order) : side_(order + 3), place_of_(side_ * side_ * side_, -1) {}

  void add(int x, int y, int z) {
    place_of_[(x * side_ + y) * side_ + z] = size();
    all_.push_back({{x, y, z}});
  }
  int size() const { return static_cast<int>(all_.size()); }
  const Exponents& operator[](int place) const { return all_[place]; }
  int place(int x, int y, int z) const { return place_of_[(x * side_ + y) * side_ + z]; }
  int sum(int a, int b) const {
    const Exponents &first = all_[a], &second = all_[b];
    return place(first.n[0] + second.n[0], first.n[1] + second.n[1], first.n[2] + second.n[2]);
  }
  // Lowers the exponent of `axis` in the multi-index at place `at` by `by`. Returns the place of
  // the result, or 0 if the exponent would be negative.
  int less(int at, int axis, int by) const {
    int n[3] = {all_[at].n[0], all_[at].n[1], all_[at].n[2]};
    n[axis] -= by;
    return n[axis] < 0 ? 0 : place(n[0], n[1], n[2]);
  }

 private:
  int side_;
  std::vector<int> place_of_;
  std::vector<Exponents> all_;
};

MultiIndices add_places(TaylorTables& t) {
  MultiIndices indices(t.order);
  for (int degree = 0; degree <= t.order; ++degree) {
    for (int z = 0; z <= degree; ++z) {
      for (int x = degree - z; x >= 0; --x) {
        if (z <= 1) t.slim.push_back(indices.size());
        indices.add(x, degree - z - x, z);
      }
    }
    t.slim_ends.push_back(static_cast<int>(t.slim.size()));
    if (degree >= t.order - 2 && degree < t.order)
      t.n_powers[t.order - 1 - degree] = indices.size();
  }
  for (int y = 0; y <= t.order; ++y)
    for (int z = 0; y + z <= t.order; ++z)
      for (int x = 0; x + y + z <= t.order; ++x) t.rows.push_back(indices.place(x, y, z));
  return indices;
}

// Returns the recurrence for D_n = d^n (1/r) at the point x, where n is the multi-index at place
// `at`, k = |n|, r = |x|, and e_i is the unit multi-index of axis i:
//   k r^2 D_n + (2 k - 1) sum n_i x_i D_{n - e_i} + (k - 1) sum n_i (n_i - 1) D_{n - 2 e_i} = 0
TaylorTables::Derivative derivative(const MultiIndices& indices, int at) {
  const int degree = indices[at].degree();
  TaylorTables::Derivative d{at, {}, {}, {}, {}};
  for (int c = 0; c < 3 && degree > 0; ++c) {
    const int count = indices[at].n[c];
    d.first[c] = -(2.0 * degree - 1.0) / degree * count;
    d.first_place[c] = indices.less(at, c, 1);
    if (c == 2) continue;
    d.second[c] = -(degree - 1.0) / degree * count * (count - 1);
    d.second_place[c] = indices.less(at, c, 2);
  }
  return d;
}

void add_recurrences(const MultiIndices& indices, TaylorTables& t) {
  for (int i = 0; i < indices.size(); ++i) {
    const int x = indices[i].n[0], y = indices[i].n[1], z = indices[i].n[2];
    const int axis = x > 0 ? 0 : y > 0 ? 1 : 2, largest = indices[i].n[axis];
    t.powers.push_back({indices.less(i, axis, 1), axis, largest > 0 ? 1.0 / largest : 1.0});
    t.next[0].push_back(indices.place(x + 1, y, z));
    t.next[1].push_back(indices.place(x, y + 1, z));
    t.next[2].push_back(indices.place(x, y, z + 1));
    if (z >= 2) {
      const TaylorTables::Trace trace{i, indices.place(x + 2, y, z - 2),
                                      indices.place(x, y + 2, z - 2)};
      t.traces.push_back(trace);
      if (z == 2) t.derivative_traces.push_back(trace);
    } else {
      t.derivatives.push_back(derivative(indices, i));
    }
  }
  std::stable_sort(t.traces.begin(), t.traces.end(),
                   [&](const TaylorTables::Trace& a, const TaylorTables::Trace& b) {
                     return indices[a.target].n[2] < indices[b.target].n[2];
                   });
}

void add_products(const MultiIndices& indices, TaylorTables& t) {
  for (int degree = 1; degree < t.order; ++degree)
    for (int i = t.slim_ends[degree - 1]; i < t.slim_ends[degree]; ++i)
      for (int k = 1; k < t.slim_ends[t.order - degree]; ++k)
        t.products.push_back(static_cast<std::uint16_t>(indices.sum(t.slim[i], t.slim[k])));
}

void add_shifts(const MultiIndices& indices, TaylorTables& t) {
  for (int i = 0; i < static_cast<int>(t.slim.size()); ++i) {
    const int degree = indices[t.slim[i]].degree();
    for (int k = 0; k < indices.size(); ++k) {
      if (degree + indices[k].degree() > t.order) break;
      t.moment_shifts.push_back({indices.sum(t.slim[i], k), i, k});
      if (degree > 0) t.local_shifts.push_back({t.slim[i], indices.sum(t.slim[i], k), k});
    }
  }
}

}  // namespace

TaylorTables::TaylorTables(int given) : order(given) {
  const MultiIndices indices = add_places(*this);
  add_recurrences(indices, *this);
  add_products(indices, *this);
  add_shifts(indices, *this);
}

}  // namespace loomstone
