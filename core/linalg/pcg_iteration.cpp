#include "core/linalg/pcg_iteration.h"

#include <cmath>
#include <type_traits>

#include "core/linalg/pcg_kernels.h"
#include "core/linalg/system.h"

namespace loomstone {

namespace {

// Computes the scaled residual r, the preconditioned residual z, and beta from PcgMemory::residual.
template <class Scalar>
void begin(PcgSolve& solve, Krylov<Scalar>& k, bool conjugate) {
  PcgMemory& m = solve.memory;
  const double scale = 1.0 / m.b_norm;
  const double square = solve.loops.sum_over_slices([&](Index first, Index last) {
    for (std::size_t i = slice_at(first); i < slice_at(last); ++i)
      k.r[i] = static_cast<Scalar>(scale * m.residual[i]);
    m.preconditioner.restrict_residual(first, last, k.r);
    return pcg::precondition(first, last, m.preconditioner.inverse<Scalar>(), k.r.data(),
                             k.z.data());
  });
  k.norm = std::sqrt(square);
  const double rz = m.preconditioner.complete(solve.loops, square, k.r, k.z);
  k.beta = conjugate ? rz / k.last_rz : 0.0;
  k.rz = rz;
  if (!conjugate) std::fill(k.p.begin(), k.p.end(), Scalar{0});
}

// Adds the last step to x (x += length p), then computes the next direction p = P^-1 r + beta p.
template <class Scalar>
void update_direction(PcgSolve& solve, Krylov<Scalar>& k, double length) {
  PcgMemory& m = solve.memory;
  solve.loops.over_blocks([&](Index, Index begin, Index end) {
    pcg::update_direction({SlicedEllpack::first_slice(begin), SlicedEllpack::last_slice(end),
                           m.slices.rows.data(), m.preconditioner.slots()},
                          {length, static_cast<Scalar>(k.beta)},
                          {k.z.data(), m.preconditioner.correction()}, k.p.data(), m.x.data());
  });
}

// Computes q = A p on rows [begin, end), where A includes the extra terms. Returns p . q.
template <class Scalar>
double multiply(const PcgSolve& solve, Index begin, Index end, Krylov<Scalar>& k) {
  const PcgMemory& m = solve.memory;
  double product = k.matrix.multiply(m.slices, SlicedEllpack::first_slice(begin),
                                     SlicedEllpack::last_slice(end), k.p.data(), k.q.data());
  if (m.terms.empty()) return product;
  m.terms.for_touched(begin, end, [&](Index row) {
    const Vec3 force = m.terms.force(row);
    Scalar* q = k.q.data() + solve.place_of(row);
    for (int d = 0; d < 3; ++d) {
      q[8 * d] += static_cast<Scalar>(force[d]);
      product += static_cast<double>(k.p[row_at(row) + d]) * force[d];
    }
  });
  return product;
}

// Returns p . A p.
template <class Scalar>
double curvature_along(PcgSolve& solve, Krylov<Scalar>& k) {
  solve.refresh(k.p.data());
  return solve.loops.sum_over_blocks(
      [&](Index begin, Index end) { return multiply(solve, begin, end, k); });
}

// Updates the residual (r -= alpha A p). Then computes its norm, the preconditioned residual z, and
// beta for the next direction.
template <class Scalar>
void take_step(PcgSolve& solve, Krylov<Scalar>& k, Scalar alpha) {
  Preconditioner& p = solve.memory.preconditioner;
  const double square = solve.loops.sum_over_slices([&](Index first, Index last) {
    const double sum = pcg::take_step(first, last, alpha, k.q.data(), p.inverse<Scalar>(),
                                      {k.r.data(), k.z.data()});
    p.restrict_residual(first, last, k.r);
    return sum;
  });
  const bool had_correction = p.has_correction();
  const double rz = p.complete(solve.loops, square, k.r, k.z);
  // If the preconditioner has changed, the iteration restarts along the preconditioned residual.
  k.beta = had_correction == p.has_correction() ? rz / k.rz : 0.0;
  k.last_rz = k.rz;
  k.rz = rz;
  k.norm = std::sqrt(square);
}

}  // namespace

template <class Scalar>
double iterate(PcgSolve& solve, Krylov<Scalar>& k, Start start, const StoppingRule& stop,
               int& iterations) {
  PcgMemory& m = solve.memory;
  if (start != Start::Resume) begin(solve, k, start == Start::Conjugate);
  double length = 0.0;  // length of the last step along p, which is added to x when p changes
  while (k.norm * m.b_norm > stop.norm && iterations < stop.max_iterations) {
    update_direction(solve, k, length);
    length = 0.0;
    const double curvature = curvature_along(solve, k);
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
    pcg::move(begin, end, length, k.p.data(), m.x.data());
  });
  return k.norm * m.b_norm;
}

template double iterate(PcgSolve&, Krylov<float>&, Start, const StoppingRule&, int&);
template double iterate(PcgSolve&, Krylov<double>&, Start, const StoppingRule&, int&);

}  // namespace loomstone
