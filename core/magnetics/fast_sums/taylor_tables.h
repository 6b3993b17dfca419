// Tables of a Taylor expansion (taylor_expansion.h): places of its multi-indices, recurrences over
// them, and the terms of its products and translations.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace loomstone {

struct TaylorTables {
  static constexpr int highest_order = 14;

  // Rows of the tables. A place is that of a multi-index, by degree, then by z.
  struct Power {  // of a product of powers over factorials: from the one before by x_axis * share
    int before, axis;
    double share;
  };
  struct Trace {  // value = - first - second
    int target, first, second;
  };
  struct Derivative {  // of 1/r: the recurrence over degrees, factors and places
    int target;
    double first[3], second[2];
    int first_place[3], second_place[2];
  };
  struct Shift {
    int target, source, power;
  };

  explicit TaylorTables(int order);

  int order;
  int n_powers[2];                       // places up to degree order - 1 and order - 2
  std::vector<int> slim;                 // places with z <= 1
  std::vector<int> slim_ends;            // how many of them up to a degree
  std::vector<Power> powers;             // of all places
  std::vector<int> next[3];              // place with one more along an axis
  std::vector<int> rows;                 // all places, by powers of y, z, x
  std::vector<Derivative> derivatives;   // z <= 1
  std::vector<Trace> derivative_traces;  // z = 2
  std::vector<std::uint16_t> products;   // for n, m of slim in turn: place of n + m
  std::vector<Trace> traces;             // z > 1, lowest z first
  std::vector<Shift> moment_shifts, local_shifts;
};

}  // namespace loomstone
