#include "core/cloth/stiffness_kernels.h"

#include "core/base/simd.h"

namespace loomstone::stiffness {

namespace {
typedef double Lanes4 __attribute__((vector_size(32)));
typedef long long Places __attribute__((vector_size(64)));

LOOMSTONE_INLINE Lanes4 load4(const double* p) {
  Lanes4 r;
  __builtin_memcpy(&r, p, sizeof(Lanes4));
  return r;
}
LOOMSTONE_INLINE void store4(double* p, const Lanes4& a) { __builtin_memcpy(p, &a, sizeof(Lanes4)); }
}  // namespace

LOOMSTONE_CLONES
void moment_gradients(const Tables& tables, const Index* list, Index n, double* out) {
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

LOOMSTONE_CLONES
void add_products(const double* u, const double* m, const Index* block, Index n, double* blocks) {
  const Lanes rows = {u[0], u[1], u[2], u[0], u[1], u[2], u[0], u[1]};
  const double row = u[2];
  const Places columns = {0, 0, 0, 1, 1, 1, 2, 2};
  for (Index s = 0; s < n; ++s) {
    double* b = blocks + block_stride * block[s];
    const Lanes spread = __builtin_shuffle(lanes_load(m + 4 * s), columns);
    lanes_store(b, lanes_load(b) + rows * spread);
    b[8] += row * m[4 * s + 2];
  }
}

}  // namespace loomstone::stiffness
