// Inputs of contact terms, and of corrections of the motion in a step.
#pragma once

#include <functional>
#include <utility>

#include "core/base/types.h"
#include "core/collision/tangle/tangle.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

// Velocities of collision vertices [m/s]. They are computed when they are read, because usually
// only those of vertices in contact are needed.
class VertexVelocities {
 public:
  using Of = std::function<Eigen::RowVector3d(Index vertex)>;
  VertexVelocities(Of of) : of_(std::move(of)) {}
  VertexVelocities(const Points& table)  // (n x 3), not copied
      : of_([&table](Index vertex) -> Eigen::RowVector3d { return table.row(vertex); }) {}
  Eigen::RowVector3d row(Index vertex) const { return of_(vertex); }
  Points all(Index n) const {  // (n x 3)
    Points table(n, 3);
    for (Index vertex = 0; vertex < n; ++vertex) table.row(vertex) = of_(vertex);
    return table;
  }

 private:
  Of of_;
};

// Inputs for terms of the implicit solve, with n collision vertices and b bodies.
struct ContactInputs {
  const Points& x0;  // (n x 3) positions at the start of the step [m]
  // Predicted velocities. The velocities of obstacle vertices enter ExtraTerm::drift.
  const VertexVelocities& v0;
  // Expected changes of velocity [m/s]; 0 for bodies and if unknown. For cloth, the change in the
  // last part, scaled to `step`. For an obstacle, v0 minus the mean velocities of its vertices in
  // the last part, which are first turned with the obstacle; 0 if no obstacle moves. For details,
  // see obstacle_changes() in core/sim/step/near_contacts.cpp.
  const VertexVelocities& change;
  const Points& body_centres;  // (b x 3) centres of mass [m]
  double step;                 // length h of the step [s]
  Index n_cloth;               // number of cloth vertices; rows of bodies follow
  const Vector& inverse_mass;  // (n) inverse masses of free cloth vertices, else 0 [1/kg]
  // (n_cloth x 3) Elastic and external forces on cloth at the start of the step [N]. On cloths that
  // bodies load, they include a fraction of the forces of limit phases. If there are 0 rows,
  // contacts are not stiffened; see contact_stiffness().
  const Points& forces;
  // Rows of the solve for which terms are made. Contacts that act on none of them have no term.
  IndexRange rows = all_indices;
};

// Inputs for corrections of the motion x0 -> x1.
struct MotionInputs {
  const Points& x0;  // (n x 3) [m]
  // (n) Inverse masses of free cloth vertices and, in certification, of free bodies; else 0 [1/kg].
  const Vector& inverse_mass;
  const Tangle& tangle;  // intersections at x0
};

}  // namespace loomstone
