// Index tables of a Taylor expansion (taylor_expansion.h): the numbering of its multi-indices,
// their recurrences, and the terms of products and translations.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct TaylorTables {
  static constexpr int highest_order = 14;

  // A place is the index of a multi-index. Multi-indices are sorted by degree, then by z exponent,
  // then by descending x exponent.
  struct Power {  // x^n / n! is the value at place `before` times x_axis * share
    int before, axis;
    double share;
  };
  struct Trace {  // target = -first - second, because 1/r is harmonic
    int target, first, second;
  };
  struct Derivative {  // factors and places of the recurrence for derivatives of 1/r
    int target;
    double first[3], second[2];
    int first_place[3], second_place[2];
  };
  struct Shift {  // term of a translation: target += source * (shift^n / n! at place `power`)
    int target, source, power;
  };

  explicit TaylorTables(int order);

  int order;
  int n_powers[2];                       // numbers of places up to degrees order - 1 and order - 2
  std::vector<int> slim;                 // places with a z exponent of at most 1 (slim places)
  std::vector<int> slim_ends;            // number of slim places up to each degree
  std::vector<Power> powers;             // one for each place
  std::vector<int> next[3];              // place with the axis' exponent raised by 1, -1 if none
  std::vector<int> rows;                 // all places, sorted by powers of y, z, x
  std::vector<Derivative> derivatives;   // one for each slim place
  std::vector<Trace> derivative_traces;  // one for each place with a z exponent of 2
  std::vector<std::uint16_t> products;   // for add_far(): places of n + m for slim n, m except 0
  std::vector<Trace> traces;             // one for each non-slim place, sorted by z exponent
  std::vector<Shift> moment_shifts, local_shifts;
};

}  // namespace loomstone
