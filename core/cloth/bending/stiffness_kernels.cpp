#include "core/cloth/bending/stiffness_kernels.h"

#include "core/base/simd.h"

namespace loomstone::stiffness {

namespace {
typedef double Lanes4 __attribute__((vector_size(32)));

LOOMSTONE_INLINE Lanes4 load4(const double* p) {
  Lanes4 r;
  __builtin_memcpy(&r, p, sizeof(Lanes4));
  return r;
}
LOOMSTONE_INLINE void store4(double* p, const Lanes4& a) {
  __builtin_memcpy(p, &a, sizeof(Lanes4));
}
}  // namespace

template <class Lanes>
LOOMSTONE_INLINE void moment_gradients(const Tables& tables, const Index* list, Index n,
                                       double* out) {
  for (Index k = 0; k < n; ++k) {
    const Index e = list[k];
    const Index size = tables.stencil_start[e + 1] - tables.stencil_start[e];
    for (Index s = 0; s < size; ++s) store4(out + 4 * s, Lanes4{});
    for (Index p = tables.pair_start[e]; p < tables.pair_start[e + 1]; ++p) {
      const double q = tables.q[p];
      const double* u = tables.gradient + 16 * static_cast<std::size_t>(tables.pair_hinge[p]);
      const std::uint8_t* place = tables.place + 4 * static_cast<std::size_t>(p);
      for (int j = 0; j < 4; ++j) {
        double* sum = out + 4 * place[j];
        store4(sum, load4(sum) + q * load4(u + 4 * j));
      }
    }
    out += 4 * size;
  }
}
void moment_gradients(const Tables& tables, const Index* list, Index n, double* out) {
  LOOMSTONE_WIDEST(moment_gradients)(tables, list, n, out);
}

template <class Lanes>
LOOMSTONE_INLINE void add_row(const Tables& tables, const Row& row, const double* moments,
                              double scale, double* sums, double* values) {
  for (Index b = 0; b < row.n_blocks; ++b) {
    lanes_store(sums + 16 * b, Lanes{});
    sums[16 * b + 8] = 0.0;
  }
  const Index* block = row.block;
  for (Index k = 0; k < row.n_items; ++k) {
    const Index e = row.items[k] / 4, n = tables.stencil_start[e + 1] - tables.stencil_start[e];
    const double* u = tables.gradient + 4 * static_cast<std::size_t>(row.items[k]);
    const double* m = moments + 4 * static_cast<std::size_t>(row.offsets[k]);
    const Lanes rows = lanes_of<Lanes>([&](int l) LOOMSTONE_INLINE_LAMBDA { return u[l % 3]; });
    const double last = u[2];
    for (Index s = 0; s < n; ++s) {
      double* b = sums + 16 * block[s];
      const Lanes4 moment = load4(m + 4 * s);
      lanes_store(
          b, lanes_load<Lanes>(b) + rows * lanes_spread<Lanes, 0, 0, 0, 1, 1, 1, 2, 2>(moment));
      b[8] += last * m[4 * s + 2];
    }
    block += n;
  }
  for (Index b = 0; b < row.n_blocks; ++b) {
    double* v = values + 9 * b;
    lanes_store(v, lanes_load<Lanes>(v) + scale * lanes_load<Lanes>(sums + 16 * b));
    v[8] += scale * sums[16 * b + 8];
  }
}
void add_row(const Tables& tables, const Row& row, const double* moments, double scale,
             double* sums, double* values) {
  LOOMSTONE_WIDEST(add_row)(tables, row, moments, scale, sums, values);
}

}  // namespace loomstone::stiffness
