// Error of a displacement of cloth: the part of the strain that a model linear in the displacement
// neglects, and the energy of this strain. Also the numerical damping of a step.
#pragma once

#include <vector>

#include "core/base/bytes.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/elasticity.h"
#include "core/cloth/known_positions.h"
#include "core/cloth/membrane/membrane.h"
#include "core/parallel/mesh_part.h"
#include "core/parallel/row_layout.h"

namespace loomstone {

struct StepError {
  // Largest eigenvalue of the neglected strain 1/2 dF^T dF over all triangles, where dF is the
  // gradient of the displacement [1].
  double strain = 0.0;
  // Largest ratio, over all cloths, of the membrane energy of the neglected strain to the kinetic
  // energy of the cloth [1]. Kinetic energy is measured in a frame that moves with the centre of
  // mass of the prescribed vertices of the cloth if there are any, and otherwise with that of the
  // cloth.
  double energy = 0.0;
};

// Numerical damping of one cloth by implicit Euler.
struct Damping {
  // Energy that is removed per unit of time, divided by the energy of the cloth as defined at
  // DisplacementError::damping() [1/s].
  double rate = 0.0;
  // √(L / g), where L is the square root of the rest area and g the gravitational acceleration [s];
  // infinite without gravity.
  double fall_time = 0.0;
};

// Evaluates the error and the numerical damping of steps. Each rank evaluates the blocks of its
// triangles (mesh_part.h). The sums of all blocks are then added in order, so results are bitwise
// independent of the number of threads and ranks.
class DisplacementError {
 public:
  // `gravity` is the magnitude of the gravitational acceleration [m/s^2].
  DisplacementError(const ClothModel& cloth, const Elasticity& elasticity, double gravity,
                    const RowLayout& layout);

  // Returns the error of a step of length h [s] that moves the vertices from `start` (n x 3) [m] to
  // `end` (n x 3) [m]. Collective.
  StepError over(const Team& team, const Points& start, const Points& end, double h);
  // Like over(), for the displacement h v with velocities v (n x 3) [m/s].
  StepError at(const Team& team, const Points& v, double h);
  // Returns the numerical damping of each cloth in a step of length h [s]. In this step, implicit
  // Euler removes the energy 1/2 m (v1 - v0)^2 from each vertex of mass m that is not prescribed.
  // The energy of a cloth is the sum of its kinetic energy (see StepError::energy), its membrane
  // energy and 1/2 M g L, where M is its mass and L the square root of its rest area. A cloth is
  // omitted if the step does not resolve its motion, for example that of snapping wrinkles (see
  // `resolved` in displacement_error.cpp). x1 (n x 3) are the positions at the end [m], and v0 and
  // v1 (n x 3) the velocities at the start and at the end [m/s]. The membrane energy at x1 is
  // reused if the last call of over() ended at x1 and no call of at() followed. Collective.
  std::vector<Damping> damping(const Team& team, const Points& x1, const Points& v0,
                               const Points& v1, double h);

  std::size_t bytes() const { return bytes_of(blocks_, offsets_, scales_, sums_, end_); }

 private:
  // A block of triangles of one cloth, and a range of the cloth's vertices.
  struct Block {
    Index cloth = 0, first_triangle = 0, last_triangle = 0, first_vertex = 0, last_vertex = 0;
  };
  // Results of a block for a displacement u. at() and damping() use velocities in place of u.
  struct Sums {
    // Largest eigenvalue of the neglected strain [1], and the membrane energy of this strain,
    // summed over the triangles [J]. In damping(), `energy` is the energy that implicit Euler
    // removes.
    double strain = 0.0, energy = 0.0;
    double elastic = 0.0;            // membrane energy at the end of the motion [J]; unused in at()
    double squares = 0.0;            // sum of m u^2 [kg m^2]
    Vec3 moment = Vec3::Zero();      // sum of m u [kg m]
    Vec3 prescribed = Vec3::Zero();  // sum of m u over prescribed vertices [kg m]
  };
  struct Scales {
    double mass = 0.0, mass_of_prescribed = 0.0;  // [kg]
    double height = 0.0;                          // 1/2 M g L as in damping() [J]
    double fall_time = 0.0;                       // see Damping [s]
  };

  // Returns the error of a step of length h [s] with the displacement (end - start) * time, or
  // end * time if start is null. `time` is 1 if `end` contains positions, and h if it contains
  // velocities.
  StepError evaluate(const Team& team, const Points* start, const Points& end, double time,
                     double h);
  Sums sums_of(const Block& block, const Points* start, const Points& end) const;
  Sums vertex_sums(const Block& block, const Points* start, const Points& end) const;
  // Sets sums_: the entries of this rank's blocks to the results of of_block(), and all other
  // entries to the results that the other ranks send. Collective.
  template <class OfBlock>
  void gather(const Team& team, OfBlock&& of_block);
  // Returns the sums of the cloth whose first block is `block`, and sets `block` to the first block
  // of the next cloth.
  Sums total(std::size_t& block) const;
  // Returns the kinetic energy in the moving frame (see StepError::energy) [J] if the sums are over
  // velocities. If they are over displacements in a time t [s], the result is this energy times
  // t^2.
  double kinetic(const Sums& sums, const Scales& scales) const;

  const ClothModel& cloth_;
  const Membrane& membrane_;
  const RowLayout& layout_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> offsets_;  // (ranks + 1) start of each rank's part of sums_ [bytes]
  std::vector<Scales> scales_;        // (cloths)
  std::vector<Sums> sums_;            // (blocks)
  // `end` of the last call of over(); no positions if at() has been called since.
  KnownPositions end_;
};

}  // namespace loomstone
