#include <catch2/catch.hpp>

#include "core/linalg/block_matrix.h"
#include "tests/linalg/random_system.h"

using namespace loomstone;

TEST_CASE("a pattern from repeated pairs is symmetric, sorted and holds its diagonal") {
  const BlockMatrix matrix(4, {{2, 0}, {0, 2}, {3, 2}, {2, 0}});
  CHECK(matrix.row_start() == std::vector<Index>{0, 2, 3, 6, 8});
  CHECK(matrix.columns() == std::vector<Index>{0, 2, 1, 0, 2, 3, 2, 3});
  for (Index row = 0; row < 4; ++row) CHECK(matrix.columns()[matrix.diagonal()[row]] == row);
  CHECK(matrix.find(2, 3) == 5);
  CHECK(matrix.find(0, 3) == -1);
}

TEST_CASE("a matrix can store a range of its rows") {
  const std::vector<std::pair<Index, Index>> couplings = {{2, 0}, {3, 2}, {4, 3}, {0, 1}};
  const BlockMatrix whole(5, couplings), part(5, couplings, 1, 3);
  CHECK(part.n_rows() == 5);
  CHECK(part.row_start() == std::vector<Index>{0, 0, 2, 5, 5, 5});
  CHECK(part.columns() == std::vector<Index>{0, 1, 0, 2, 3});
  CHECK(part.diagonal() == std::vector<Index>{-1, 1, 3, -1, -1});
  CHECK(part.find(2, 3) == 4);
  CHECK(part.find(3, 2) == -1);
  CHECK(part.bytes() < whole.bytes());
}

TEST_CASE("the product of blocks equals the dense product") {
  const testing::RandomSystem system = testing::random_system(13, 0, 0);
  const Index rows = system.matrix.n_rows();
  const Eigen::MatrixXd dense = testing::dense_matrix(system.view());
  Vector x = Vector::Zero(4 * rows), y = Vector::Constant(4 * rows, 7.0);
  for (Index row = 0; row < rows; ++row) x.segment<3>(4 * row) = system.b.row(row).transpose();
  system.matrix.multiply(0, rows, x.data(), y.data());
  const Points flat = system.b;
  const Vector expected = dense * Eigen::Map<const Vector>(flat.data(), flat.size());
  for (Index row = 0; row < rows; ++row) {
    // A row is a sum of at most 21 products of about 10, with relative rounding errors of 1e-16.
    CHECK((y.segment<3>(4 * row) - expected.segment<3>(3 * row)).norm() < 1e-13);
    CHECK(y[4 * row + 3] == 0.0);
  }
}
