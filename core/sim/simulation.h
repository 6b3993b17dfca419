// Simulation of one scene. Contains the Model, the State and the Stepper, and provides the
// functions that Python and the tests call. Arrays of cloth concatenate all cloths. They are in the
// user's vertex order, except in state(), checkpoint() and collision_motion().
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/base/checkpoint.h"
#include "core/base/frame.h"
#include "core/collision/broad_phase/decomposition.h"
#include "core/collision/collision_replay.h"
#include "core/integration/options.h"
#include "core/magnetics/sources/body.h"
#include "core/parallel/communicator.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

struct State;
struct BrokenLimit;
struct Contact;

struct CircuitState;

class Simulation {
 public:
  // Checks the scene and builds its model. If `threads` is 0, uses default_thread_count(). Results
  // do not depend on the numbers of threads and ranks or on `decomposition`. Throws InvalidInput
  // or Unsupported.
  Simulation(const Scene& scene, const IntegratorOptions& integrator, int threads = 0,
             std::shared_ptr<const Communicator> communicator = single_communicator(),
             Decomposition decomposition = Decomposition::Predicted);
  ~Simulation();

  // Advances by one step. Throws InvalidInput if users have written invalid values to state(), and
  // Unsupported if another thread is in step(). If the step fails, restores the state at the start
  // of the step and throws SolverFailure.
  void step();
  double time() const;  // [s]
  std::int64_t step_index() const;
  double step_size() const;  // length of a step; the largest length of automatic steps [s]
  // Returns an estimate of the longest step at which symplectic Euler is stable for small motions
  // about the present positions [s]; infinite without cloth. See loomstone::stable_step().
  double stable_step() const;
  int threads() const;
  const Communicator& communicator() const;
  // Sets whether this rank stores the motion that certification receives, and the starts of
  // preceding motions; see CollisionRecord. keep_collision_motion(false), restore() and
  // rebuild_stages() discard what is stored. collision_motion() returns the motion that was stored
  // last, or one without vertices if there is none, for example because the scene has no cloth.
  void keep_collision_motion(bool keep);
  CollisionRecord collision_motion() const;
  // Returns CollisionStage::hierarchy_bytes(), or 0 if there is no CollisionStage (see
  // Engines::collision).
  std::size_t hierarchy_bytes() const;
  // Memory that one part of the simulation occupies on this rank.
  struct MemoryPart {
    std::string name;
    std::size_t bytes;
  };
  std::vector<MemoryPart> memory() const;
  Decomposition decomposition() const;  // how ranks divide the search for contacts and impacts
  // Returns the report of the last step. Its energies, energy account, strains and circuit values
  // are those of the current state.
  const StepReport& report() const;
  // Returns whether a checkpoint can be taken: there are no bodies, or the number of completed
  // steps is a multiple of Scene::rigid_rebuild_interval, so the rigid-body world has just been
  // rebuilt.
  bool may_checkpoint() const;

  const FrameTopology& topology() const;
  Frame frame() const;  // frame of the current state
  // Returns the frame at a time within the last step [s]. Positions and velocities are
  // interpolated. Throws InvalidInput for other times.
  Frame frame_at(double time) const;

  const std::vector<Index>& vertex_order() const;  // internal row of each vertex

  // Returns the internal tables, in the internal order, to read and write between steps. Writing
  // positions or velocities restarts multistep schemes and the account of energy. Every step first
  // checks the tables that users may write. Every rank has all rows of each table. A step updates
  // all rows on every rank, except in cloth.previous_bending, where it updates only the rows that
  // the rank owns. A rank should write only the rows that it owns. `pin_override`, `target_time`,
  // poses of obstacles, and forces and torques on bodies are taken from rank 0.
  State& state();
  std::array<Index, 2> owned_rows() const;  // cloth rows of this rank, [first, end)
  // Collective. Sends what users have written to state() to all ranks now, not only in the next
  // step. Also completes cloth.previous_bending on every rank.
  void gather();
  // Returns how many iterations of parallel loops and how many tests of TaskPool this rank has run
  // within steps.
  std::int64_t loop_iterations() const;

  Points positions() const;  // (n x 3) [m], a copy
  void set_positions(const Points& positions);
  Points velocities() const;  // (n x 3) [m/s], a copy
  void set_velocities(const Points& velocities);
  Points external_forces() const;  // (n x 3) [N], added in every step until changed
  void set_external_forces(const Points& forces);
  // (b x 3) forces at the centres of mass [N] and torques about them [N m], added in every step
  // until changed
  Points external_body_forces() const;
  void set_external_body_forces(const Points& forces);
  Points external_body_torques() const;
  void set_external_body_torques(const Points& torques);
  // Sets the target positions (n x 3) [m] of all prescribed vertices, which replace their scripts.
  // The vertices reach them after the time step_size(). Rows of other vertices are ignored.
  void set_pin_targets(const Points& targets);
  // Sets the pose of an obstacle: position of the mesh's origin [m] and unit quaternion (w, x, y,
  // z). It replaces the keyframes or vertex_positions. The obstacle reaches it after the time
  // step_size().
  void set_obstacle_pose(int obstacle, const Vec3& position, const Vec4& orientation);
  Points body_centres() const;  // (b x 3) centres of mass [m]
  // Returns the present magnetic forces [N] and torques about the centres of mass [N m] on the
  // bodies (b x 3).
  std::array<Points, 2> magnetic_forces() const;
  // circuits() returns the currents and energies of the circuits, and the energy that bearings have
  // taken from bodies. currents() returns the current in each coil [A].
  const CircuitState& circuits() const;
  Vector currents() const;
  double current() const;  // current of the first circuit, 0 without circuits [A]
  // Returns all magnets, and the coils that carry current, at their poses in a frame of this scene.
  std::vector<MagneticBody> magnets(const Frame& frame) const;

  // Collective. Returns a checkpoint of the current state. Throws InvalidInput unless
  // may_checkpoint().
  Checkpoint checkpoint() const;
  // Collective. Restores a checkpoint. Throws CacheError if the scene or the integrator differs, or
  // if the checkpoint lacks a table or has one that does not fit the scene.
  void restore(const Checkpoint& checkpoint);
  // Rebuilds the engines of all stages. If may_checkpoint() is true, later results are bitwise
  // identical to those without the rebuild.
  void rebuild_stages();

  // Returns the pairs of triangles (user numbering, all surfaces concatenated) that intersected at
  // the end of the last step, if this step or an earlier one has left unresolved impacts, for
  // example because scripted motion leaves the cloth no room. At least one triangle of each pair is
  // cloth. The list is empty again once the cloth is free of intersections, and in the steps after
  // the user has set positions, unless they leave unresolved impacts.
  std::vector<std::array<Index, 2>> forced_pairs() const;

  // Returns each triangle (user numbering, all cloths concatenated) and mode (0: weft, 1: warp, 2:
  // shear) in which the strain exceeds its limit by more than limit_margin() after the last step,
  // in descending order of excess.
  std::vector<BrokenLimit> broken_limits() const;

  // Returns the pairs of triangles (user numbering, all surfaces concatenated) that intersect in
  // the current state and share no vertex.
  std::vector<std::array<Index, 2>> intersecting_pairs() const;

  // Returns the contacts of the current state. Contact::vertices are in the user's numbering, with
  // all surfaces concatenated; Contact::a and Contact::b are internal indices. All ranks must call
  // this function.
  std::vector<Contact> near_contacts() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
