// Bullet's contact solver with the Coulomb friction cone.
#pragma once

#include <vector>

#include "core/rigid/bullet.h"

namespace loomstone {

// Bullet bounds the friction of a contact separately along two directions: that of the sliding
// velocity at the start of the step and the perpendicular one. If other contacts turn the sliding
// velocity, friction along the second direction would oppose this turn, with a bound as large as
// along the first. A body that slides and spins would then keep the ratio of the two motions. This
// solver bounds the length of the friction impulse instead. Friction then opposes the sliding
// velocity of its own contact, apart from changes in the direction of this velocity within a step.
class ConeFrictionSolver : public btSequentialImpulseConstraintSolver {
 protected:
  void convertContacts(btPersistentManifold** manifolds, int n_manifolds,
                       const btContactSolverInfo& info) override;
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int n_bodies,
                                btPersistentManifold** manifolds, int n_manifolds,
                                btTypedConstraint** constraints, int n_constraints,
                                const btContactSolverInfo& info, btIDebugDraw* drawer) override;

 private:
  // Corrects the two friction impulses of a contact. Its friction rows are `first` and `first` + 1.
  // Returns the square of the larger change of sliding velocity along the two rows [m^2/s^2].
  btScalar correct(int first);
  // Returns the change of a row's impulse that stops the sliding along its direction [N s].
  btScalar stopping(const btSolverConstraint& row);
  void apply(btSolverConstraint& row, btScalar impulse);

  // (contacts) Impulses that count as normal impulses for friction, but that the solver does not
  // apply, because opposite contacts would balance them (see squeezed_contacts.h) [N s].
  std::vector<btScalar> squeezes_;
};

}  // namespace loomstone
