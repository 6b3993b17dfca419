// Tests of KnownPositions, which decides whether results of elements are reused.
#include <catch2/catch.hpp>

#include <cmath>

#include "core/cloth/known_positions.h"

using namespace loomstone;

TEST_CASE("known positions are those with the same bits in the rows that elements read") {
  KnownPositions known({2, 5}, {0, 7});
  Points x = Points::Random(9, 3);
  CHECK_FALSE(known.at(x));
  known.set(x);
  CHECK(known.at(x));
  for (const Index row : {0, 2, 3, 4, 7})
    for (int axis = 0; axis < 3; ++axis) {
      Points other = x;
      other(row, axis) = std::nextafter(other(row, axis), 2.0);
      CAPTURE(row, axis);
      CHECK_FALSE(known.at(other));
    }
  for (const Index row : {1, 5, 6, 8}) {
    Points other = x;
    other.row(row).setZero();
    CAPTURE(row);
    CHECK(known.at(other));
  }
  x(3, 1) = 0.0;
  known.set(x);
  x(3, 1) = -0.0;
  CHECK_FALSE(known.at(x));
  x(3, 1) = 0.0;
  CHECK(known.at(x));
  known.forget();
  CHECK_FALSE(known.at(x));
}
