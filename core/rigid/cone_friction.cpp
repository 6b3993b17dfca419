#include "core/rigid/cone_friction.h"

#include <algorithm>
#include <cmath>

#include "core/rigid/squeezed_contacts.h"

namespace loomstone {

void ConeFrictionSolver::convertContacts(btPersistentManifold** manifolds, int n_manifolds,
                                         const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertContacts(manifolds, n_manifolds, info);
  squeezes_ =
      relieve_squeezed({m_tmpSolverContactConstraintPool, m_tmpSolverBodyPool}, info.m_timeStep);
}

btScalar ConeFrictionSolver::solveSingleIteration(int iteration, btCollisionObject** bodies,
                                                  int n_bodies, btPersistentManifold** manifolds,
                                                  int n_manifolds, btTypedConstraint** constraints,
                                                  int n_constraints,
                                                  const btContactSolverInfo& info,
                                                  btIDebugDraw* drawer) {
  // Hides the rows of friction from Bullet's iteration. Shrinking the array leaves them in memory.
  btConstraintArray& rows = m_tmpSolverContactFrictionConstraintPool;
  const int n_rows = rows.size();
  rows.resizeNoInitialize(0);
  btScalar residual = btSequentialImpulseConstraintSolver::solveSingleIteration(
      iteration, bodies, n_bodies, manifolds, n_manifolds, constraints, n_constraints, info,
      drawer);
  rows.resizeNoInitialize(n_rows);
  for (int first = 0; first + 1 < n_rows; first += 2) residual = std::max(residual, correct(first));
  return residual;
}

btScalar ConeFrictionSolver::correct(int first) {
  btSolverConstraint& along = m_tmpSolverContactFrictionConstraintPool[first];
  btSolverConstraint& across = m_tmpSolverContactFrictionConstraintPool[first + 1];
  const btScalar normal = m_tmpSolverContactConstraintPool[along.m_frictionIndex].m_appliedImpulse +
                          squeezes_[along.m_frictionIndex];
  const btScalar bound = along.m_friction * std::max(normal, btScalar(0));
  btScalar to[2] = {along.m_appliedImpulse + stopping(along),
                    across.m_appliedImpulse + stopping(across)};
  const btScalar length = std::sqrt(to[0] * to[0] + to[1] * to[1]);
  if (length > bound) to[0] *= bound / length, to[1] *= bound / length;
  const btScalar changes[2] = {to[0] - along.m_appliedImpulse, to[1] - across.m_appliedImpulse};
  apply(along, changes[0]);
  apply(across, changes[1]);
  const btScalar speeds[2] = {changes[0] / along.m_jacDiagABInv,
                              changes[1] / across.m_jacDiagABInv};
  return std::max(speeds[0] * speeds[0], speeds[1] * speeds[1]);
}

btScalar ConeFrictionSolver::stopping(const btSolverConstraint& row) {
  btSolverBody &a = m_tmpSolverBodyPool[row.m_solverBodyIdA],
               &b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  const btScalar speed = row.m_contactNormal1.dot(a.internalGetDeltaLinearVelocity()) +
                         row.m_relpos1CrossNormal.dot(a.internalGetDeltaAngularVelocity()) +
                         row.m_contactNormal2.dot(b.internalGetDeltaLinearVelocity()) +
                         row.m_relpos2CrossNormal.dot(b.internalGetDeltaAngularVelocity());
  return row.m_rhs - row.m_appliedImpulse * row.m_cfm - speed * row.m_jacDiagABInv;
}

void ConeFrictionSolver::apply(btSolverConstraint& row, btScalar impulse) {
  btSolverBody &a = m_tmpSolverBodyPool[row.m_solverBodyIdA],
               &b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA,
                         impulse);
  b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB,
                         impulse);
  row.m_appliedImpulse += impulse;
}

}  // namespace loomstone
