// Memory of solves by conjugate gradients, which the next solve may continue with: the
// arrays behind SolveMemory.
#pragma once

#include <algorithm>
#include <vector>

#include "core/linalg/coupling_matrix.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/preconditioner.h"
#include "core/linalg/row_loops.h"
#include "core/linalg/sliced_ellpack.h"
#include "core/linalg/term_rows.h"

namespace loomstone {

// Where a row begins in vectors with four numbers a row, and a slice in vectors by slices.
inline std::size_t row_at(Index row) { return 4 * static_cast<std::size_t>(row); }
inline std::size_t slice_at(Index slice) { return 24 * static_cast<std::size_t>(slice); }

// The matrix and the vectors of the iteration in one precision: r, z and q by slices, the direction
// p by rows. The last row of p stands for empty lanes and stays zero.
template <class Scalar>
struct Krylov {
  CouplingMatrix<Scalar> matrix;
  std::vector<Scalar> r, z, p, q;
  double rz = 0.0, last_rz = 0.0;  // r . z, and before the last step
  double beta = 0.0;               // of the next direction
  double norm = 0.0;               // sqrt(r . D^-1 r), D the diagonal blocks

  void resize(const SlicedEllpack& slices) {
    matrix.resize(slices);
    for (auto* v : {&r, &z, &q}) v->resize(slice_at(slices.n_slices()));
    p.resize(row_at(slices.n_rows() + 1));
    std::fill_n(p.begin() + row_at(slices.n_rows()), 4, Scalar{0});
  }
};

struct PcgMemory {
  // Pattern of the matrix; kept while it stays.
  SlicedEllpack slices;
  // Properties of the last system.
  TermRows terms;
  Halo halo;  // rows of others that a product needs
  Preconditioner preconditioner;
  Krylov<float> single;
  Krylov<double> wide;      // filled where single precision does not do
  bool has_matrix = false;  // `single.matrix` and the preconditioner are those of the last system
  // The iteration: x and product with four numbers a row (x has one more row, of empty lanes),
  // residual by slices.
  std::vector<double> x, product, residual;
  double b_norm = 0.0;  // norm of the residual where x is zero on free rows
  // The last solve stopped at a tolerance looser than the solver's: x, b_norm, terms and the
  // vectors of `single` are those of its last iteration.
  bool has_iteration = false;
  std::vector<double> matrix_times_x;  // by slices, without terms; where it has an iteration
};

// One solve: its system, the loops over the rows of this rank and the arrays it works on.
struct PcgSolve {
  const LinearSystem& system;
  RowLoops loops;
  PcgMemory& memory;

  // Refreshes rows of other ranks that the product needs, and evaluates the terms at v.
  template <class Scalar>
  void refresh(Scalar* v) const {
    loops.layout().exchange(memory.halo, v, 4);
    if (!memory.terms.empty()) memory.terms.evaluate(loops.team(), v);
  }

  // Place of the first of a row's three numbers in vectors by slices; the others follow at
  // distances of 8.
  std::size_t place_of(Index row) const {
    const Index place = memory.slices.place[row];
    return slice_at(place / 8) + static_cast<std::size_t>(place % 8);
  }
  // Writes value(place, axis) to the row of a vector by slices.
  template <class Value>
  void set_row(Index row, std::vector<double>& v, Value&& value) const {
    const std::size_t place = place_of(row);
    for (int d = 0; d < 3; ++d) v[place + 8 * d] = value(place + 8 * d, d);
  }
};

}  // namespace loomstone
