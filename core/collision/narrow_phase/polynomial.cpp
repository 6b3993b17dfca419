#include "core/collision/narrow_phase/polynomial.h"

namespace loomstone {

namespace {

using Coefficients = std::vector<Integer>;

// Returns the Bernstein coefficients b_i of p = sum_i b_i C(n, i) t^i (1 - t)^(n - i), up to a
// common positive factor.
Coefficients bernstein(const Polynomial& p) {
  static constexpr int factor[4][4] = {
      {1}, {1, 1}, {2, 1, 2}, {3, 1, 1, 3}};  // LCM of C(n, 0), ..., C(n, n), divided by C(n, i)
  const std::size_t n = p.c.size() - 1;
  Coefficients b;
  for (std::size_t i = 0; i <= n; ++i) b.push_back(p.c[i] * Integer(factor[n][i]));
  return b;
}

// Halves the interval of a polynomial of degree n with the Bernstein coefficients b, by de
// Casteljau's algorithm. The coefficients over both halves are scaled by 2^n.
void halve(const Coefficients& b, Coefficients& lower, Coefficients& upper) {
  const std::size_t n = b.size() - 1;
  Coefficients level = b;
  lower.resize(n + 1);
  upper.resize(n + 1);
  for (std::size_t k = 0; k <= n; ++k) {
    const unsigned shift = static_cast<unsigned>(n - k);
    lower[k] = level.front().shifted(shift);
    upper[n - k] = level.back().shifted(shift);
    for (std::size_t i = 0; i + 1 < level.size(); ++i) level[i] = level[i] + level[i + 1];
    level.pop_back();
  }
}

Coefficients follow(Coefficients b, const std::vector<bool>& path) {
  Coefficients lower, upper;
  for (const bool up : path) {
    halve(b, lower, upper);
    b = up ? upper : lower;
  }
  return b;
}

// Returns the number of sign changes in the Bernstein coefficients b of a polynomial over an
// interval. It is the number of roots inside this interval, counted with multiplicity, plus a
// non-negative even number.
int variations(const Coefficients& b) {
  int count = 0, last = 0;
  for (const Integer& x : b) {
    const int sign = x.sign();
    if (sign == 0) continue;
    count += last != 0 && sign != last;
    last = sign;
  }
  return count;
}

// Removes the roots at x = 0 and at infinity from the polynomial in x = t / (1 - t).
Coefficients stripped(Coefficients c) {
  while (!c.empty() && c.back().sign() == 0) c.pop_back();
  std::size_t low = 0;
  while (low < c.size() && c[low].sign() == 0) ++low;
  c.erase(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(low));
  return c;
}

// Divides a by b up to a constant factor. Returns the quotient; a becomes the remainder.
Coefficients divide(Coefficients& a, const Coefficients& b) {
  Coefficients quotient;  // from the highest degree down, up to a common factor
  while (a.size() >= b.size()) {
    const Integer lead = a.back();
    for (Integer& x : quotient) x = x * b.back();
    quotient.push_back(lead);
    const std::size_t shift = a.size() - b.size();
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = a[i] * b.back();
      if (i >= shift) a[i] = a[i] - lead * b[i - shift];
    }
    a.pop_back();
  }
  std::reverse(quotient.begin(), quotient.end());
  return quotient;
}

Coefficients greatest_common_divisor(Coefficients a, Coefficients b) {
  a = stripped(std::move(a));
  b = stripped(std::move(b));
  while (!b.empty()) {
    divide(a, b);
    a = stripped(std::move(a));
    std::swap(a, b);
  }
  return a;
}

Polynomial without_double_roots(const Polynomial& p) {
  Coefficients c = stripped(p.c), derivative;
  for (std::size_t i = 1; i < c.size(); ++i)
    derivative.push_back(c[i] * Integer(static_cast<std::int64_t>(i)));
  const Coefficients common = greatest_common_divisor(c, derivative);
  return common.size() > 1 ? Polynomial{divide(c, common)} : Polynomial{c};
}

template <class Operation>
Polynomial combine(const Polynomial& a, const Polynomial& b, Operation&& operation) {
  Polynomial result;
  for (std::size_t i = 0; i < a.c.size(); ++i) result.c.push_back(operation(a.c[i], b.c[i]));
  return result;
}

}  // namespace

bool Polynomial::zero() const {
  return std::all_of(c.begin(), c.end(), [](const Integer& x) { return x.sign() == 0; });
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  return combine(a, b, [](const Integer& x, const Integer& y) { return x + y; });
}
Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  return combine(a, b, [](const Integer& x, const Integer& y) { return x - y; });
}
Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial result;
  result.c.resize(a.c.size() + b.c.size() - 1);
  for (std::size_t i = 0; i < a.c.size(); ++i)
    for (std::size_t j = 0; j < b.c.size(); ++j)
      result.c[i + j] = result.c[i + j] + a.c[i] * b.c[j];
  return result;
}

int AlgebraicTime::sign_of(const Polynomial& q) const {
  if (kind_ == Kind::Start) return q.c.front().sign();
  if (kind_ == Kind::End) return q.c.back().sign();
  if (q.zero()) return 0;
  Coefficients b = follow(bernstein(q), path_), lower, upper;
  if (kind_ == Kind::Middle) {
    halve(b, lower, upper);
    return upper.front().sign();
  }
  // A few bisections determine most signs. If this time is also a root of q, bisection may never
  // end. This case is therefore tested after `bisections_before_test` bisections.
  constexpr int bisections_before_test = 6;
  Coefficients p = follow(bernstein(polynomial_), path_), p_lower, p_upper;
  for (int bisections = 0; variations(b) != 0; ++bisections) {
    if (bisections == bisections_before_test) {
      const Polynomial common{greatest_common_divisor(polynomial_.c, q.c)};
      if (common.c.size() > 1 && variations(follow(bernstein(common), path_)) % 2 == 1) return 0;
    }
    halve(b, lower, upper);
    halve(p, p_lower, p_upper);
    if (p_upper.front().sign() == 0) return upper.front().sign();
    const bool in_lower = variations(p_lower) % 2 == 1;
    b = in_lower ? lower : upper;
    p = in_lower ? p_lower : p_upper;
  }
  for (const Integer& x : b)
    if (x.sign() != 0) return x.sign();
  return 0;
}

bool any_root(const Polynomial& p, const std::function<bool(const AlgebraicTime&)>& accept) {
  if (p.c.front().sign() == 0 && accept(AlgebraicTime::start())) return true;
  if (p.c.back().sign() == 0 && accept(AlgebraicTime::end())) return true;
  if (variations(bernstein(p)) == 0) return false;
  const Polynomial simple = without_double_roots(p);
  struct Interval {
    AlgebraicTime::Path path;
    Coefficients b;
  };
  std::vector<Interval> open = {{{}, bernstein(simple)}};
  while (!open.empty()) {
    const Interval interval = std::move(open.back());
    open.pop_back();
    const int count = variations(interval.b);
    if (count == 0) continue;
    if (count == 1) {
      if (accept({AlgebraicTime::Kind::Root, interval.path, simple})) return true;
      continue;
    }
    Interval lower{interval.path, {}}, upper{interval.path, {}};
    lower.path.push_back(false);
    upper.path.push_back(true);
    halve(interval.b, lower.b, upper.b);
    if (upper.b.front().sign() == 0 && accept({AlgebraicTime::Kind::Middle, interval.path, {}}))
      return true;
    open.push_back(std::move(upper));
    open.push_back(std::move(lower));
  }
  return false;
}

}  // namespace loomstone
