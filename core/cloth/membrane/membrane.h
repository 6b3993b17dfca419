// Orthotropic St. Venant-Kirchhoff membrane on linear triangles in total Lagrangian form, with
// viscosity. Implements (2.7), (2.21)-(2.25), (2.31), (2.33), (2.35) of [Thomaszewski2010]. Kernels
// process eight triangles at once. Forces on a vertex are summed in ascending order of elements,
// and energies in a fixed order, so results are bitwise identical for any number of threads and any
// row range.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/aligned.h"
#include "core/base/bytes.h"
#include "core/base/own_rows.h"
#include "core/base/types.h"
#include "core/cloth/material/material.h"
#include "core/cloth/membrane/limit_modes.h"
#include "core/cloth/membrane/membrane_kernels.h"
#include "core/linalg/block_matrix.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/mesh_part.h"
#include "core/parallel/team.h"

namespace loomstone {

// Plane-stress constants (2.22) and viscosities of one material.
struct MembraneConstants {
  double a11, a22, a12, g;  // [N/m]
  double lambda_d, mu_d;    // viscosity [N s/m]
};
// Returns the constants of a material that check_fields() has accepted. Throws InvalidInput if its
// energy is not positive definite or its viscosity is not dissipative. `where` is the name of the
// material in error messages.
MembraneConstants membrane_constants(const ClothMaterial& material, const std::string& where);

// Constants of each triangle of a mesh.
class MembraneConstantsOf {
 public:
  MembraneConstantsOf(const std::vector<MembraneConstants>& of_triangles) : table_(of_triangles) {}
  // Group i consists of the triangles first_triangle[i] to first_triangle[i + 1] - 1.
  MembraneConstantsOf(const std::vector<MembraneConstants>& of_groups,
                      const std::vector<Index>& first_triangle)
      : table_(of_groups), first_triangle_(&first_triangle) {}

  const MembraneConstants& operator()(Index triangle) const {
    if (!first_triangle_) return table_[triangle];
    const auto next = std::upper_bound(first_triangle_->begin(), first_triangle_->end(), triangle);
    return table_[next - first_triangle_->begin() - 1];
  }
  bool viscous() const {
    return std::any_of(table_.begin(), table_.end(), [](const MembraneConstants& m) {
      return m.lambda_d != 0.0 || m.mu_d != 0.0;
    });
  }

 private:
  const std::vector<MembraneConstants>& table_;
  const std::vector<Index>* first_triangle_ = nullptr;
};

// The membrane elements of all cloths or of a part of them, with their tables and scratch memory.
// Only stored elements can be evaluated. Batch b consists of the triangles 8 b to 8 b + 7.
// A batch is stored if the part contains one of its triangles.
class Membrane {
 public:
  // `corners` has the rest coordinates of each triangle in weft/warp axes [m].
  Membrane(Index n_vertices, const Triangles& triangles, const std::vector<Corners2>& corners,
           const MembraneConstantsOf& constants);
  Membrane(const Triangles& triangles, const std::vector<Corners2>& corners,
           const MembraneConstantsOf& constants, Index n_vertices, MeshPart part);

  bool viscous() const { return viscous_; }
  Index n_triangles() const { return n_triangles_; }  // including those that are not stored
  Index n_batches() const { return static_cast<Index>(stored_.size()); }  // stored batches
  // Returns the index, in the whole mesh, of the batch with index `place` among the stored ones.
  Index batch_at(Index place) const { return stored_[place]; }

  membrane::Tables tables() const {
    return {corners_.data(), gradients_.data(), constants_.data(),
            phase_,          in_phase_,         limits_.empty() ? nullptr : limits_.data()};
  }
  // Sets the tables of the stress that stiff phases add (see membrane::Tables). This stress enters
  // energy, forces and Jacobian. Null: no stress is added. The tables are not copied.
  void set_phase(const double* phase, const std::uint8_t* in_phase) {
    phase_ = phase, in_phase_ = in_phase;
  }
  bool in_phase() const { return phase_ != nullptr; }

  // Adds a potential that limits the strain modes of each triangle. `modes` has one entry per
  // triangle. The potential enters the energy and the forces, but not the Jacobian. A later call
  // replaces it.
  void add_limits(const std::vector<LimitModes>& modes);

  // Returns the places (see batch_at()) of the stored batches that touch rows [begin, end), in
  // ascending order. The list is valid until this function or add_forces() is called with another
  // range of rows.
  const std::vector<Index>& batches_of(Index begin, Index end) {
    return select_rows(begin, end), batches_;
  }

  // Energy of all triangles [J], summed in a fixed order. All of them must be stored.
  double energy(const Team& team, const Points& x);
  // Sets sums[i] to the energy [J] of the triangles 128 i to 128 i + 127 for each i in `blocks`.
  // These triangles must be stored.
  void sum_energies(const Team& team, const Points& x, IndexRange blocks,
                    std::vector<double>& sums);

  // Adds the elastic force, and the viscous force if v is given, to rows [begin, end) of `force`.
  void add_forces(const Team& team, const Points& x, const Points* v, Index begin, Index end,
                  RowsOut force);

  // Sets rows [begin, end) of `matrix` to s K + t D with the stiffness K and the damping matrix D,
  // where s and t are the factors `elastic` and `viscous` of terms.scales. The pattern of `matrix`
  // must contain all mesh edges.
  void set_jacobian(const Team& team, const Points& x, JacobianTerms terms, Index begin, Index end,
                    BlockMatrix& matrix);

  // Together, the next two functions do the same as set_jacobian(), in chunks of rows_per_block
  // rows, for callers that continue to work on a chunk while it is in the cache. Call locate_rows()
  // first, then set_chunk() for every chunk. Each thread needs its own scratch memory.
  void locate_rows(const BlockMatrix& matrix, Index begin, Index end);
  void set_chunk(Index chunk, const Points& x, JacobianTerms terms, AlignedDoubles& scratch,
                 BlockMatrix& matrix) const;

  // Result of neglected(); see neglected_strains() in membrane_kernels.h.
  struct Neglected {
    double strain = 0.0;  // largest eigenvalue of the neglected strain [1]
    double energy = 0.0;  // membrane energy of the neglected strain [J]
    // Membrane energy at positions `end` [J], without the stress of set_phase() and the potential
    // of add_limits().
    double elastic = 0.0;
  };
  // Computes the neglected strain of the triangles [first_triangle, last_triangle) for the
  // displacement end - start (n x 3 each), or for the displacement `end` if `start` is null.
  // `elastic` is meaningful only if `end` contains positions.
  Neglected neglected(const double* start, const double* end, Index first_triangle,
                      Index last_triangle) const;

  // Computes the Green strain (E11, E22, E12) (k x 3) and the largest principal stretch (k) of k
  // stored triangles. The index of the first one must be a multiple of eight.
  void strain(const Team& team, const Points& x, IndexRange triangles, Points& green,
              Vector& stretch);
  // Computes the strain of all triangles. All of them must be stored.
  void strain(const Team& team, const Points& x, Points& green, Vector& stretch) {
    strain(team, x, {0, n_triangles_}, green, stretch);
  }

  std::size_t bytes() const {
    return bytes_of(stored_, corners_, gradients_, constants_, limits_, slot_start_, slots_,
                    batches_, element_forces_, element_strains_, chunk_start_, chunk_batches_,
                    row_start_, diagonal_, sources_);
  }

 private:
  void store(const Triangles& triangles, MeshPart part);
  void make_tables(const Triangles& triangles, const std::vector<Corners2>& corners,
                   const MembraneConstantsOf& constants);
  void make_slots(Index n_vertices, IndexRange rows);
  void select_rows(Index begin, Index end);
  Index place_of(Index batch) const {  // `batch` must be stored
    return static_cast<Index>(std::lower_bound(stored_.begin(), stored_.end(), batch) -
                              stored_.begin());
  }

  Index n_triangles_;
  std::vector<Index> stored_;   // stored batches, ascending
  std::vector<Index> corners_;  // layout: see membrane_kernels.h
  std::vector<double> gradients_, constants_;
  std::vector<double> limits_;  // empty: no limits
  const double* phase_ = nullptr;
  const std::uint8_t* in_phase_ = nullptr;
  bool viscous_ = false;
  // The offsets in element_forces_ of the forces on row i are the entries slot_start_[i] to
  // slot_start_[i + 1] - 1 of slots_.
  std::vector<Index> slot_start_, slots_;

  std::vector<Index> batches_;  // batches that touch rows [begin_, end_): indices into stored_
  Index begin_ = -1, end_ = -1;
  std::vector<double> element_forces_, element_strains_;

  // Element blocks that contribute to rows [located_begin_, located_end_). locate_rows() determines
  // them again if the matrix pattern or the range of rows has changed. The batches of chunk c are
  // the entries chunk_start_[c] to chunk_start_[c + 1] - 1 of chunk_batches_. These entries are
  // indices into stored_.
  std::vector<Index> chunk_start_, chunk_batches_;
  // First block and diagonal block of each row, counted from the first matrix block of the range.
  // row_start_ also has the number of blocks as its last entry.
  std::vector<Index> row_start_, diagonal_;
  std::vector<Index> sources_;  // (blocks x 2) offsets in the chunk's scratch, see membrane::rows
  const Index* located_columns_ = nullptr;
  Index located_blocks_ = -1, located_begin_ = -1, located_end_ = -1;
};

}  // namespace loomstone
