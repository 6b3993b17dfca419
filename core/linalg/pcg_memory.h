// The contents of SolveMemory: data that a solve by conjugate gradients leaves for the next solve.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/base/bytes.h"
#include "core/linalg/coupling_matrix.h"
#include "core/linalg/linear_solver.h"
#include "core/linalg/preconditioner.h"
#include "core/linalg/row_loops.h"
#include "core/linalg/sliced_ellpack.h"
#include "core/linalg/term_rows.h"

namespace loomstone {

// Offset of a row in vectors with four numbers per row, and of a slice in vectors stored by slices
// of eight rows (sliced_ellpack.h).
inline std::size_t row_at(Index row) { return 4 * static_cast<std::size_t>(row); }
inline std::size_t slice_at(Index slice) { return 24 * static_cast<std::size_t>(slice); }

// Matrix and vectors of the iteration in one precision. The scaled residual r, the preconditioned
// residual z (without the multigrid correction) and the product q = A p are stored by slices. The
// direction p is stored by rows. Its last row belongs to empty lanes and stays zero. P is the
// preconditioner (preconditioner.h).
template <class Scalar>
struct Krylov {
  CouplingMatrix<Scalar> matrix;
  std::vector<Scalar> r, z, p, q;
  // r . P^-1 r at the start of the present step, and at the start of the last completed step.
  double rz = 0.0, last_rz = 0.0;
  int steps = 0;      // number of steps since the last Start::Restart or Start::Conjugate
  double beta = 0.0;  // factor of p in the next direction
  double norm = 0.0;  // sqrt(r . D^-1 r), with D the diagonal blocks

  void resize(const SlicedEllpack& slices) {
    matrix.resize(slices);
    for (auto* v : {&r, &z, &q}) v->resize(slice_at(slices.n_slices()));
    p.resize(row_at(slices.n_rows() + 1));
    std::fill_n(p.begin() + row_at(slices.n_rows()), 4, Scalar{0});
  }
  std::size_t bytes() const { return bytes_of(matrix, r, z, p, q); }
};

struct PcgMemory {
  // Layout of the matrix, reused while the pattern is unchanged.
  SlicedEllpack slices;
  // Data of the system of the current or last solve.
  TermRows terms;
  Halo halo;  // rows that ranks exchange before a product
  HaloExchange halo_exchange;
  // An owned block of rows is outer if terms act on one of its rows or if one of its rows is
  // coupled to a row of another rank; otherwise it is inner. The halo is exchanged during the
  // products of inner blocks. On one rank, nothing is exchanged, and all blocks are stored as outer
  // blocks.
  std::vector<Index> inner_blocks, outer_blocks;
  Preconditioner preconditioner;
  Krylov<float> single;
  Krylov<double> wide;  // filled only if single precision does not suffice
  // True if the next solve with the same matrix can reuse `single.matrix` and the preconditioner.
  bool has_matrix = false;
  // Vectors of the iteration. x has the rows of this rank, with four numbers per row, and one more
  // row for empty lanes. residual is stored by slices.
  std::vector<double> x, residual;
  // The larger of least_norm() and the norm of the residual for x = 0 on free rows.
  double b_norm = 0.0;
  // True if the last solve ended in single precision, by a tolerance that is looser than the
  // solver's own. x, b_norm, terms and the vectors of `single` then have the values at the end of
  // that solve.
  bool has_iteration = false;
  std::vector<double> matrix_times_x;  // A x by slices, without terms; valid if has_iteration
};

// Data of one solve: the system, the loops over the rows of this rank, and the memory.
struct PcgSolve {
  const LinearSystem& system;
  RowLoops loops;
  PcgMemory& memory;

  double* x_at(Index row) const { return memory.x.data() + row_at(row - loops.layout().begin()); }
  // A vector with four numbers for each row of the system.
  struct WholeVector {
    const double* data;
    std::unique_ptr<double[]> room;  // memory of `data`; null if `data` is PcgMemory::x
  };
  // Returns x in the rows of this rank and in those rows of other ranks that the product A x needs.
  // Other rows are undefined. Evaluates the terms at x. Collective.
  WholeVector whole_x() const {
    const RowLayout& layout = loops.layout();
    WholeVector whole{memory.x.data(), nullptr};
    if (!layout.single()) {
      whole.room = std::make_unique_for_overwrite<double[]>(row_at(layout.n_rows()));
      whole.data = whole.room.get();
      std::copy_n(memory.x.data(), row_at(layout.end() - layout.begin()),
                  whole.room.get() + row_at(layout.begin()));
      layout.exchange(memory.halo, whole.room.get(), 4);
    }
    memory.terms.evaluate(loops.team(), whole.data);
    return whole;
  }

  // Returns the index of a row's first component in vectors stored by slices. The other two
  // components follow with a stride of 8.
  std::size_t place_of(Index row) const {
    const Index place = memory.slices.place[row];
    return slice_at(place / 8) + static_cast<std::size_t>(place % 8);
  }
  // Sets the three components of a row in a vector v stored by slices to value(index, axis), where
  // `index` is the index of the component in v.
  template <class Value>
  void set_row(Index row, std::vector<double>& v, Value&& value) const {
    const std::size_t place = place_of(row);
    for (int d = 0; d < 3; ++d) v[place + 8 * d] = value(place + 8 * d, d);
  }
};

}  // namespace loomstone
