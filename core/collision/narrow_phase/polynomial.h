// Computes the exact signs of a polynomial at the roots of another polynomial in [0, 1]. A
// polynomial of degree n is stored as the coefficients c_i of sum_i c_i t^i (1 - t)^(n - i). For t
// between 0 and 1, it has the sign of sum_i c_i x^i at x = t / (1 - t) > 0. Roots are isolated by
// bisection and Descartes' rule of signs in the Bernstein basis [LaneRiesenfeld1981].
#pragma once

#include <functional>
#include <vector>

#include "core/collision/narrow_phase/integer.h"

namespace loomstone {

struct Polynomial {
  std::vector<Integer> c;

  bool zero() const;
};

// In sums and differences, a and b must have the same degree.
Polynomial operator+(const Polynomial& a, const Polynomial& b);
Polynomial operator-(const Polynomial& a, const Polynomial& b);
Polynomial operator*(const Polynomial& a, const Polynomial& b);

// A time in [0, 1] at which the sign of any polynomial of degree at most 3 can be computed exactly.
class AlgebraicTime {
 public:
  static AlgebraicTime start() { return {Kind::Start, {}, {}}; }
  static AlgebraicTime end() { return {Kind::End, {}, {}}; }
  int sign_of(const Polynomial& q) const;

 private:
  friend bool any_root(const Polynomial&, const std::function<bool(const AlgebraicTime&)>&);

  // Start and End are the times 0 and 1. Middle is the midpoint of the interval to which the path
  // leads. Root is the only root of polynomial_ inside that interval. polynomial_ has no multiple
  // roots.
  enum class Kind { Start, End, Middle, Root };
  using Path = std::vector<bool>;  // bisections of [0, 1]; true: upper half

  AlgebraicTime(Kind kind, Path path, Polynomial polynomial)
      : kind_(kind), path_(std::move(path)), polynomial_(std::move(polynomial)) {}

  Kind kind_;
  Path path_;
  Polynomial polynomial_;
};

// Returns whether accept(t) is true for at least one root t of p in [0, 1], ends included. p must
// have degree at most 3 and must not be identically zero.
bool any_root(const Polynomial& p, const std::function<bool(const AlgebraicTime&)>& accept);

}  // namespace loomstone
