#include <catch2/catch.hpp>
#include <random>

#include "core/linalg/coupling_matrix.h"

using namespace loomstone;

namespace {

constexpr Index n = 64;

// Returns a matrix that couples consecutive rows. The blocks of each row add up to the identity (a
// mass of 1 kg), with errors of at most 2e-8, below the rounding error of single precision.
BlockMatrix chain() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<std::pair<Index, Index>> couplings;
  for (Index row = 0; row + 1 < n; ++row) couplings.emplace_back(row, row + 1);
  BlockMatrix matrix(n, couplings);
  for (Index row = 0; row < n; ++row)
    matrix.block_map(matrix.find(row, row)) =
        Mat3::Identity() + 2e-8 * Mat3::NullaryExpr([&] { return uniform(random); });
  for (const auto& [i, j] : couplings) {
    const Mat3 k = Mat3::NullaryExpr([&] { return uniform(random); });
    matrix.block_map(matrix.find(i, j)) = k;
    matrix.block_map(matrix.find(j, i)) = k.transpose();
    matrix.block_map(matrix.find(i, i)) -= k;
    matrix.block_map(matrix.find(j, j)) -= k.transpose();
  }
  return matrix;
}

// Returns the product of the matrix with the vector (sin 1, sin 2, sin 3, ...). The product is in
// order of rows, with four numbers per row, of which the fourth is 0.
std::vector<float> product(const BlockMatrix& matrix) {
  SlicedEllpack slices;
  slices.set_pattern(&matrix, {n, 0, n});
  CouplingMatrix<float> couplings;
  couplings.resize(slices);
  couplings.set_slices(&matrix, nullptr, slices, 0, slices.n_slices());
  std::vector<float> x(4 * (n + 1), 0.0f), y(4 * (n + 1), 0.0f);
  for (Index i = 0; i < 3 * n; ++i) x[4 * (i / 3) + i % 3] = std::sin(1.0f + static_cast<float>(i));
  couplings.multiply_to_rows(slices, 0, slices.n_slices(), x.data(), y.data());
  return y;
}

}  // namespace

TEST_CASE("the product in a row does not depend on the other rows of its slice") {
  const BlockMatrix usual = chain();
  const std::vector<float> expected = product(usual);
  for (Index changed = 0; changed < n; ++changed) {
    BlockMatrix matrix = usual;
    matrix.block_map(matrix.find(changed, changed))(0, 1) += 0.5;
    const std::vector<float> found = product(matrix);
    Index n_different = 0;
    for (Index i = 0; i < 4 * n; ++i) n_different += i / 4 != changed && found[i] != expected[i];
    CAPTURE(changed);
    CHECK(n_different == 0);
    CHECK(found[4 * changed] != expected[4 * changed]);
  }
}

TEST_CASE("blocks of zeros do not change the product") {
  const BlockMatrix usual = chain();
  std::vector<std::pair<Index, Index>> couplings = {{0, 20}, {3, 50}, {11, 40}, {12, 40}};
  for (Index row = 0; row + 1 < n; ++row) couplings.emplace_back(row, row + 1);
  BlockMatrix matrix(n, couplings);
  matrix.set_zero();
  for (Index row = 0; row < n; ++row)
    for (Index k = usual.row_start()[row]; k < usual.row_start()[row + 1]; ++k)
      matrix.block_map(matrix.find(row, usual.columns()[k])) = usual.block_map(k);
  CHECK(product(matrix) == product(usual));
}
