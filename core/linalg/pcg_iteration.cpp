#include "core/linalg/pcg_iteration.h"

#include <cmath>
#include <type_traits>

#include "core/linalg/pcg_kernels.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

constexpr int steps_per_sum = 16;  // number of steps between two calls of start_new_residual()

// Computes the scaled residual r, its norm, the preconditioned residual z and beta from
// PcgMemory::residual. Sets p to zero unless the first direction is to be conjugate to p.
template <class Scalar>
void begin(PcgSolve& solve, Krylov<Scalar>& k, bool conjugate) {
  PcgMemory& m = solve.memory;
  const double scale = 1.0 / m.b_norm;
  const BinnedSum square =
      solve.loops.owned_sum_over_slices(m.slices, [&](Index first, Index last) {
        for (std::size_t i = slice_at(first); i < slice_at(last); ++i)
          k.r[i] = static_cast<Scalar>(scale * m.residual[i]);
        m.preconditioner.restrict_residual(first, last, k.r);
        return pcg::precondition(first, last, m.preconditioner.inverse<Scalar>(), k.r.data(),
                                 k.z.data());
      });
  m.preconditioner.start_residual_exchange<Scalar>(solve.loops.layout());
  solve.loops.layout().communicator().finish();
  m.preconditioner.finish_exchange();
  k.steps = 0;
  const auto products = m.preconditioner.complete(solve.loops, square, k.r, k.z);
  k.norm = std::sqrt(products.diagonal);
  k.beta = conjugate ? products.whole / k.last_rz : 0.0;
  if (!conjugate) std::fill(k.p.begin(), k.p.end(), Scalar{0});
}

// Adds the last step to x (x += length p), then computes the next direction p = P^-1 r + beta p.
template <class Scalar>
void update_direction(PcgSolve& solve, Krylov<Scalar>& k, double length) {
  PcgMemory& m = solve.memory;
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    pcg::update_direction(
        {m.slices.first_slice(begin), m.slices.last_slice(end), m.slices.rows.data(),
         m.preconditioner.slots(), solve.loops.layout().begin(), solve.loops.layout().end()},
        {length, static_cast<Scalar>(k.beta)}, {k.z.data(), m.preconditioner.correction()},
        k.p.data(), m.x.data());
  });
}

// Computes q = A p on the rows [begin, end) of a block, where A includes the extra terms, and
// restricts q to the coarse levels. Returns p . q.
template <class Scalar>
double multiply(const PcgSolve& solve, Index begin, Index end, Krylov<Scalar>& k) {
  PcgMemory& m = solve.memory;
  const Index first = m.slices.first_slice(begin), last = m.slices.last_slice(end);
  double product = k.matrix.multiply(m.slices, first, last, k.p.data(), k.q.data());
  m.terms.for_touched(begin, end, [&](Index row) {
    const Vec3 force = m.terms.force(row);
    Scalar* q = k.q.data() + solve.place_of(row);
    for (int d = 0; d < 3; ++d) {
      q[8 * d] += static_cast<Scalar>(force[d]);
      product += static_cast<double>(k.p[row_at(row) + d]) * force[d];
    }
  });
  m.preconditioner.restrict_product(first, last, k.q);
  return product;
}

// Recomputes the residual of the coarse levels as sums over rows, and starts to exchange its halo.
// Between two such sums, the residual of the coarse levels is updated step by step, and rounding
// errors accumulate.
template <class Scalar>
void start_new_residual(PcgSolve& solve, Krylov<Scalar>& k) {
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    const SlicedEllpack& slices = solve.memory.slices;
    solve.memory.preconditioner.restrict_residual(slices.first_slice(begin), slices.last_slice(end),
                                                  k.r);
  });
  solve.memory.preconditioner.template start_residual_exchange<Scalar>(solve.loops.layout());
}

// Computes q = A p on the owned rows. Returns p . A p and r . P^-1 r, summed over all ranks. The
// halo of p is exchanged during the products of the inner blocks.
template <class Scalar>
Preconditioner::StepProducts multiply_all(PcgSolve& solve, Krylov<Scalar>& k) {
  PcgMemory& m = solve.memory;
  const RowLayout& layout = solve.loops.layout();
  const bool anew = k.steps > 0 && k.steps % steps_per_sum == 0;
  if (anew) start_new_residual(solve, k);
  const auto multiply_block = [&](Index begin, Index end) {
    return multiply(solve, begin, end, k);
  };
  if (!layout.single()) {
    m.halo_exchange.start(layout.communicator(), m.halo, k.p.data(), 4);
    solve.loops.set_sums(m.inner_blocks, multiply_block);
    layout.communicator().finish();
    m.halo_exchange.unpack();
  }
  if (anew) m.preconditioner.finish_exchange();
  m.terms.evaluate(solve.loops.team(), k.p.data());
  solve.loops.set_sums(m.outer_blocks, multiply_block);
  return m.preconditioner.complete_product<Scalar>(layout, solve.loops.owned_sum());
}

// Updates the residual (r -= alpha A p). Then computes its norm, the preconditioned residual z, and
// beta for the next direction.
template <class Scalar>
void take_step(PcgSolve& solve, Krylov<Scalar>& k, Scalar alpha) {
  Preconditioner& p = solve.memory.preconditioner;
  const SlicedEllpack& slices = solve.memory.slices;
  const BinnedSum square = solve.loops.owned_sum_over_slices(slices, [&](Index first, Index last) {
    return pcg::take_step(first, last, alpha, k.q.data(), p.inverse<Scalar>(),
                          {k.r.data(), k.z.data()});
  });
  p.take_step(alpha);
  const bool had_correction = p.has_correction();
  const auto products = p.complete(solve.loops, square, k.r, k.z);
  // If complete() has dropped the correction, the iteration restarts along the preconditioned
  // residual.
  k.beta = had_correction == p.has_correction() ? products.whole / k.rz : 0.0;
  k.last_rz = k.rz;
  k.norm = std::sqrt(products.diagonal);
  ++k.steps;
}

}  // namespace

template <class Scalar>
double iterate(PcgSolve& solve, Krylov<Scalar>& k, Start start, const StoppingRule& stop,
               int& iterations) {
  PcgMemory& m = solve.memory;
  if (start != Start::Resume) begin(solve, k, start == Start::Conjugate);
  // Last step along p, in multiples of p. It is added to x when p changes, or at the end.
  double length = 0.0;
  while (k.norm * m.b_norm > stop.norm && iterations < stop.max_iterations) {
    update_direction(solve, k, length);
    length = 0.0;
    const auto [curvature, rz] = multiply_all(solve, k);
    k.rz = rz;
    if (!(curvature > 0.0) || !std::isfinite(curvature)) {
      if (std::is_same_v<Scalar, double>)
        throw_indefinite(
            m.preconditioner.kind() == Preconditioner::Kind::GaussSeidel ? "gauss-seidel" : "pcg",
            iterations + 1);
      break;
    }
    const Scalar alpha = static_cast<Scalar>(k.rz / curvature);
    take_step(solve, k, alpha);
    length = m.b_norm * static_cast<double>(alpha);
    ++iterations;
  }
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    pcg::move(end - begin, length, k.p.data() + row_at(begin), solve.x_at(begin));
  });
  return k.norm * m.b_norm;
}

template double iterate(PcgSolve&, Krylov<float>&, Start, const StoppingRule&, int&);
template double iterate(PcgSolve&, Krylov<double>&, Start, const StoppingRule&, int&);

}  // namespace loomstone
