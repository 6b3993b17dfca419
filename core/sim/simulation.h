// A built scene that advances: Model + State + Stepper behind the few calls that Python and tests
// need. Its arrays are in the user's vertex order, all cloths end to end.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/base/checkpoint.h"
#include "core/base/frame.h"
#include "core/integration/options.h"
#include "core/magnetics/sources/body.h"
#include "core/parallel/communicator.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

struct State;
struct BrokenLimit;

struct CircuitState;

class Simulation {
 public:
  // Checks everything and builds. threads 0: all processors. Throws InvalidInput / Unsupported.
  Simulation(const Scene& scene, const IntegratorOptions& integrator, int threads = 0,
             std::shared_ptr<const Communicator> communicator = single_communicator());
  ~Simulation();

  void step();          // throws SolverFailure; the state of the last good step remains
  double time() const;  // [s]
  std::int64_t step_index() const;
  double step_size() const;  // [s]
  int threads() const;
  const Communicator& communicator() const;
  const StepReport& report() const;  // of the last step
  bool may_checkpoint() const;       // false between rebuilds of the rigid-body world

  const FrameTopology& topology() const;
  Frame frame() const;                // of the present state
  Frame frame_at(double time) const;  // between the last two steps: interpolated positions

  const std::vector<Index>& vertex_order() const;  // internal row of each user vertex

  // The internal tables, in the internal order, to be read and written between steps. Writing
  // positions or velocities restarts multi-step schemes; every step first checks that all is
  // finite. Ranks hold all rows, current after every step. A rank's writes count for the rows it
  // owns, poses of obstacles on rank 0.
  State& state();
  std::array<Index, 2> owned_rows() const;  // this rank's cloth rows [first, end)
  void gather();                         // shares what each rank wrote with all ranks; collective
  std::int64_t loop_iterations() const;  // of the loops this rank has run within steps

  Points positions() const;  // (n x 3) [m], a copy
  void set_positions(const Points& positions);
  Points velocities() const;  // (n x 3) [m/s], a copy
  void set_velocities(const Points& velocities);
  Points external_forces() const;  // (n x 3) [N], added to every step until changed
  void set_external_forces(const Points& forces);
  // Targets of pinned vertices at the end of the next step, in place of the script; rows of other
  // vertices are ignored.
  void set_pin_targets(const Points& targets);
  // Pose of an obstacle at the end of the next step; replaces its keyframes.
  void set_obstacle_pose(int obstacle, const Vec3& position, const Vec4& orientation);
  Points body_centres() const;  // (b x 3) centres of mass [m]
  // Magnetic forces [N] and torques about the centres [N m] (b x 3) on the bodies now.
  std::array<Points, 2> magnetic_forces() const;
  // The circuits of the scene now, and the currents in all its coils [A].
  const CircuitState& circuits() const;
  Vector currents() const;
  double current() const;  // of the first circuit
  // All magnets at their places in a frame of this scene.
  std::vector<MagneticBody> magnets(const Frame& frame) const;

  Checkpoint checkpoint() const;
  void restore(const Checkpoint& checkpoint);  // same scene and integrator; else throws CacheError
  // Makes all stages again; where a checkpoint may be taken this changes no bit of the future.
  void rebuild_stages();

  // Pairs of triangles (user numbering, all surfaces end to end) that intersect because scripted
  // motion left the cloth no room, until they are free again.
  std::vector<std::array<Index, 2>> forced_pairs() const;

  // Triangles (user numbering, all cloths end to end) beyond a strain limit by more than
  // limit_margin() after the last step, the largest excess first.
  std::vector<BrokenLimit> broken_limits() const;

  // Pairs of triangles (user numbering, all surfaces end to end) that intersect now.
  std::vector<std::array<Index, 2>> intersecting_pairs() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
