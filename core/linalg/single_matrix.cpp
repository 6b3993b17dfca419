#include "core/linalg/single_matrix.h"

#include "core/linalg/quad.h"
#include "core/linalg/system.h"

namespace loomstone {

void SingleMatrix::resize(const LinearSystem& system) {
  const Index n_rows = system.layout->n_rows(), n_cloth = n_cloth_rows(system);
  row_start_.resize(n_rows + 1);
  if (n_cloth > 0) std::copy(system.matrix->row_start().begin(), system.matrix->row_start().end(), row_start_.begin());
  if (n_cloth == 0) row_start_[0] = 0;
  for (Index row = n_cloth; row < n_rows; ++row) row_start_[row + 1] = row_start_[row] + 1;
  columns_.resize(row_start_.back());
  values_.resize(9 * static_cast<std::size_t>(row_start_.back()) + 3);
}

// R_i takes the place of the diagonal block, as minus the coupling to the ground.
void SingleMatrix::set_row(const LinearSystem& system, Index row) {
  const Index n_cloth = n_cloth_rows(system), ground = system.layout->n_rows();
  Mat3 sum = Mat3::Zero();
  Index ground_place = row_start_[row];
  if (row >= n_cloth) {
    sum = (*system.body_blocks)[row - n_cloth];
  } else {
    const BlockMatrix& a = *system.matrix;
    ground_place = a.diagonal()[row];
    for (Index k = row_start_[row]; k < row_start_[row + 1]; ++k) {
      const double* block = a.block(k);
      float* out = values_.data() + 9 * static_cast<std::size_t>(k);
      for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(block[i]), sum.data()[i] += block[i];
      columns_[k] = a.columns()[k];
    }
  }
  float* out = values_.data() + 9 * static_cast<std::size_t>(ground_place);
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(-sum.data()[i]);
  columns_[ground_place] = ground;
}

namespace {

// As BlockMatrix::multiply, on differences.
LOOMSTONE_CLONES
void multiply_rows(Index begin, Index end, const Index* row_start, const Index* columns, const float* values,
                   const float* x, float* y) {
  Index k = row_start[begin];
  const float* a = values + 9 * static_cast<std::size_t>(k);
  for (Index row = begin; row < end; ++row) {
    const FloatQuad here = quad_load(x + 4 * static_cast<std::size_t>(row));
    FloatQuad sum0{}, sum1{}, sum2{};
    for (const Index stop = row_start[row + 1]; k < stop; ++k, a += 9) {
      const FloatQuad d = quad_load(x + 4 * static_cast<std::size_t>(columns[k])) - here;
      sum0 += quad_load(a) * d[0];
      sum1 += quad_load(a + 3) * d[1];
      sum2 += quad_load(a + 6) * d[2];
    }
    FloatQuad sum = (sum0 + sum1) + sum2;
    sum[3] = 0.0f;
    quad_store(y + 4 * static_cast<std::size_t>(row), sum);
  }
}

}  // namespace

void SingleMatrix::multiply(Index begin, Index end, const float* x, float* y) const {
  if (begin < end) multiply_rows(begin, end, row_start_.data(), columns_.data(), values_.data(), x, y);
}

}  // namespace loomstone
