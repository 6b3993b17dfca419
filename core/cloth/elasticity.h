// Membrane and bending of all cloths as one elastic body: forces, stiffness, energy.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/cloth/bending/bending.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/limits/limit_phase.h"
#include "core/cloth/membrane/membrane.h"
#include "core/linalg/block_matrix.h"
#include "core/parallel/team.h"

namespace loomstone {

// How bending enters a step: as a force only (Explicit); as a force and in the matrix by a sparse
// bound of its stiffness, which keeps linearly implicit steps stable (Lumped, see
// BendingSetup::lumped_stiffness); or with the whole Gauss-Newton stiffness (Full).
enum class BendingTreatment { Explicit, Lumped, Full };

// Stage.
class Elasticity {
 public:
  Elasticity(const ClothModel& model, BendingTreatment bending);

  // Largest eigenvalue of M^-1 K of bending at rest [1/s^2]; 0 without bending.
  static double bending_eigenvalue(const ClothModel& model);

  bool implicit_bending() const { return treatment_ != BendingTreatment::Explicit; }
  BlockMatrix& matrix() { return matrix_; }

  // Adds minus the elastic and minus the viscous forces of the terms in the matrix: membrane, and
  // bending if implicit. v null: no viscous part.
  void add_implicit_forces(const Team& team, const Points& x, const Points* v, Index begin,
                           Index end, Points& force);
  // Adds minus the elastic and minus the damping forces of explicit bending; adds nothing if
  // bending is implicit.
  void add_explicit_bending(const Team& team, const Points& x, const Points& v, Index begin,
                            Index end, Points& force);

  // A product with the matrix, computed while its rows are in the cache. Rows of w that the matrix
  // couples to [begin, end) must be current.
  struct Product {
    const Points* w;  // null: no product
    Points* y;        // y = (matrix - M) w on rows [begin, end)
  };
  // Sets rows [begin, end) of the matrix to M + elastic K + viscous D.
  void assemble(const Team& team, const Points& x, JacobianTerms terms, Index begin, Index end,
                Product product = {});

  // As long as it lives, forces and stiffness contain the stiff phases near strain limits; its
  // destructor restores those of the membrane alone. A default-constructed one changes nothing.
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
  // The phase of each triangle that touches rows [begin, end) is that of its strain at x. The scope
  // changes nothing where no strain is limited.
  LimitPhaseScope limit_phase(const Team& team, const Points& x, Index begin, Index end);

  double membrane_energy(const Team& team, const Points& x) { return membrane_.energy(team, x); }
  double bending_energy(const Team& team, const Points& x) const;
  void strain(const Team& team, const Points& x, Points& green, Vector& stretch) {
    membrane_.strain(team, x, green, stretch);
  }

 private:
  void add_bending(const Team& team, const Points& x, JacobianTerms terms, Index begin, Index end);
  void finish_rows(Index begin, Index end, Product product);

  const ClothModel& model_;
  Membrane membrane_;
  std::unique_ptr<LimitPhase> limit_phase_;
  std::vector<std::unique_ptr<Bending>> bending_;
  BendingTreatment treatment_;
  BlockMatrix matrix_;
  std::vector<double> wide_in_, wide_out_;  // vectors with 4 doubles per row
  Points zero_velocity_;
};

}  // namespace loomstone
