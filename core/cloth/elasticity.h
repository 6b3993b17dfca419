// Elastic forces, stiffness matrix and energy of all cloths, due to membrane and bending. With a
// layout of several ranks, each rank stores the rows of the matrix that it owns, all hinge
// elements, and the membrane and mid-edge elements that act on these rows or whose energies it
// sums.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/own_rows.h"
#include "core/cloth/bending/bending.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/known_positions.h"
#include "core/cloth/limits/limit_phase.h"
#include "core/cloth/membrane/membrane.h"
#include "core/linalg/block_matrix.h"
#include "core/parallel/team.h"

namespace loomstone {

// How bending enters a step. Explicit: only as a force. Lumped: as a force, and in the matrix as a
// sparse upper bound of half its stiffness, which keeps linearly implicit steps stable (see
// BendingSetup::lumped_stiffness). Full: as a force, and in the matrix with the full Gauss-Newton
// stiffness. Lumped and Full are the same for the hinge element. With JacobianKind::Exact, both
// also add the geometric stiffness of bending to the matrix.
enum class BendingTreatment { Explicit, Lumped, Full };

class Elasticity {
 public:
  // Stores all elements.
  Elasticity(const ClothModel& model, BendingTreatment bending);
  // Stores the membrane and mid-edge elements of this rank, and all hinge elements. Rows [begin,
  // end) in the functions below must then be rows of this rank. Only limit_phase() may also be
  // called for all rows, and then determines the phases of all stored triangles.
  Elasticity(const ClothModel& model, BendingTreatment bending, const RowLayout& layout);

  // Returns the largest eigenvalue of M^-1 K at the rest positions over all cloths [1/s^2], where M
  // is the mass matrix and K the bending stiffness (see Bending::largest_eigenvalue()); 0 without
  // bending.
  static double bending_eigenvalue(const ClothModel& model);

  bool implicit_bending() const { return treatment_ != BendingTreatment::Explicit; }
  BlockMatrix& matrix() { return matrix_; }

  // Adds the elastic and viscous forces of the membrane and, if bending is implicit, of bending to
  // rows [begin, end) of `force`. The matrix of assemble() approximates the stiffness of these
  // forces. If v is null, viscous forces are omitted.
  void add_implicit_forces(const Team& team, const Points& x, const Points* v, Index begin,
                           Index end, RowsOut force);
  // Adds the elastic and damping forces of explicit bending. Adds nothing if bending is implicit.
  void add_explicit_bending(const Team& team, const Points& x, const Points& v, Index begin,
                            Index end, RowsOut force);

  // A product that assemble() computes with the matrix that it sets. `w` must be up to date in all
  // rows that the matrix couples to rows [begin, end).
  struct Product {
    const Points* w;  // at least one row per vertex; null: no product
    OwnRows* y;       // set to (matrix - M) w; contains the rows [begin, end)
  };
  // Sets rows [begin, end) of the matrix to M + s K + t D with the mass M, the stiffness K and the
  // damping matrix D, where s and t are the factors `elastic` and `viscous` of terms.scales.
  // Explicit bending has no part in K and D. Also computes `product` unless product.w is null.
  void assemble(const Team& team, const Points& x, JacobianTerms terms, Index begin, Index end,
                Product product = {});

  // While this guard exists, the energy, forces and stiffness of the membrane include the stiff
  // phases near strain limits. A default-constructed guard changes nothing.
  class [[nodiscard]] LimitPhaseScope {
   public:
    LimitPhaseScope() = default;
    explicit LimitPhaseScope(Membrane& membrane) : membrane_(&membrane) {}
    LimitPhaseScope(LimitPhaseScope&& other) noexcept
        : membrane_(std::exchange(other.membrane_, nullptr)) {}
    LimitPhaseScope& operator=(LimitPhaseScope&&) = delete;
    ~LimitPhaseScope() {
      if (membrane_) membrane_->set_phase(nullptr, nullptr);
    }

   private:
    Membrane* membrane_ = nullptr;
  };
  // Determines the phases of all triangles that touch rows [begin, end) from their strains at x;
  // see LimitPhase::enter(). Returns a guard for these phases. Without strain limits, the guard
  // changes nothing.
  LimitPhaseScope limit_phase(const Team& team, const Points& x, Index begin, Index end,
                              const std::uint8_t* yields = nullptr, double recovery = 1.0);
  // Returns whether the last call of limit_phase() on this rank found a triangle in a stiff phase.
  bool in_limit_phase() const { return in_limit_phase_; }
  // Adds to rows [begin, end) of `force` the forces that the phases of the last call of
  // limit_phase() exert at x. No guard may exist.
  void add_phase_forces(const Team& team, const Points& x, Index begin, Index end, RowsOut force);
  // Returns another guard for the phases that the last call of limit_phase() determined.
  LimitPhaseScope last_limit_phase();

  // Adds a strain-limiting potential to the energy and the forces, but not to the matrix (see
  // Membrane::add_limits).
  void add_limits(const std::vector<LimitModes>& modes);

  // Energies of all cloths [J]. Collective if elements are divided among ranks.
  double membrane_energy(const Team& team, const Points& x);
  double bending_energy(const Team& team, const Points& x);
  const Membrane& membrane() const { return membrane_; }
  // Returns a KnownPositions without positions, for the rows that the elements of this rank read.
  const KnownPositions& unknown_positions() const { return unknown_; }
  // Returns whether this rank stores only a part of the elements.
  bool divided() const { return layout_ != nullptr; }
  // Returns an Elasticity that stores all elements of the same model, with the same treatment of
  // bending but without the potential of add_limits().
  std::unique_ptr<Elasticity> whole() const {
    return std::make_unique<Elasticity>(model_, treatment_);
  }
  // Computes the strain of all triangles (see Membrane::strain()). Not collective.
  void strain(const Team& team, const Points& x, Points& green, Vector& stretch);
  // Computes the strain of the triangles of this rank, or of all triangles if this rank stores all.
  void strain_of_rank(const Team& team, const Points& x, Points& green, Vector& stretch);

  // Memory of membrane, bending, and matrix [bytes].
  std::size_t membrane_bytes() const {
    return bytes_of(membrane_, limit_phase_, known_.at, known_.membrane.force, energies_.at);
  }
  std::size_t bending_bytes() const;
  std::size_t matrix_bytes() const { return bytes_of(matrix_); }

 private:
  Elasticity(const ClothModel& model, BendingTreatment bending, const RowLayout* layout);
  struct Range {
    Index begin = 0, end = 0;
    bool operator==(const Range&) const = default;
  };
  // Elastic forces and energies are kept because a part of a step needs them several times at the
  // same positions.
  struct KnownForce {
    bool known = false;
    OwnRows force;  // [N]
  };
  struct KnownForces {
    Range rows;
    KnownPositions at;
    KnownForce membrane, bending;
  };
  // Results of membrane_sums() and bending_sums() [J]; empty: not known. If elements are divided, a
  // rank reuses only its own sums, because rows that only other ranks read may have changed. For
  // bending, the sums of the cloths follow one another.
  struct KnownEnergies {
    KnownPositions at;
    std::vector<double> membrane, bending;
  };
  // Adds to `force` the forces that add() computes. If `known`, which is a member of known_,
  // contains these forces for `rows` and x, uses them instead of calling add(). Otherwise, calls
  // add() and stores the forces in `known`.
  template <class Add>
  void add_known(const Team& team, const Points& x, Range rows, KnownForce& known, Add&& add,
                 RowsOut force);
  // If known_ belongs to other rows or positions, discards its forces and sets its rows and
  // positions to `rows` and x.
  void know_forces_at(const Points& x, Range rows);
  // If energies_ belongs to other positions, discards its energies and sets its positions to x.
  void know_energies_at(const Points& x);
  // Returns the rows outside of `rows` that the elements of this rank read, in ascending order.
  std::vector<Index> other_rows_read(Range rows) const;
  void add_bending_forces(const Team& team, const Points& x, const Points* v, Index begin,
                          Index end, RowsOut force);
  // membrane_sums() and bending_sums() return the energies of the blocks of triangles of this rank
  // [J], and 0 for all other blocks. Where elements are not divided, they return totals instead:
  // one for the whole membrane, and one for the bending of each cloth.
  std::vector<double> membrane_sums(const Team& team, const Points& x);
  std::vector<double> bending_sums(const Team& team, const Points& x);
  void add_bending(const Team& team, const Points& x, JacobianTerms terms, Index begin, Index end);
  void finish_rows(Index begin, Index end, Product product);

  struct BendingElements {
    std::unique_ptr<Bending> element;
    std::vector<Index> first;  // result of first_triangles(); empty: all elements are stored
    IndexRange triangles;      // triangles of `element` whose energies this rank sums
  };
  // Returns the number of sums that bending_sums() returns for the bending of one cloth.
  static Index n_sums(const BendingElements& of_part) {
    const std::vector<Index>& first = of_part.first;
    return first.empty() ? 1 : (first.back() + rows_per_block - 1) / rows_per_block;
  }
  void add_bending_part(const ClothModel::BendingPart& part);

  const ClothModel& model_;
  const RowLayout* layout_;   // null: all elements are stored
  std::vector<Index> first_;  // result of first_triangles(); empty: all elements are stored
  Membrane membrane_;
  std::unique_ptr<LimitPhase> limit_phase_;
  bool in_limit_phase_ = false;
  std::vector<BendingElements> bending_;
  BendingTreatment treatment_;
  BlockMatrix matrix_;
  Points zero_velocity_;  // zeros, allocated at first use
  bool damped_bending_ = false;
  KnownPositions unknown_;  // result of unknown_positions()
  // Membrane values are not reused while the membrane includes stiff phases. Forces are not reused
  // if they include viscous forces.
  KnownForces known_;
  KnownEnergies energies_;
};

}  // namespace loomstone
