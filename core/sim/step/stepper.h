// One step: a row of stages. Everything here may be thrown away between two steps; only State
// carries on.
#pragma once

#include <memory>
#include <optional>

#include "core/base/report.h"
#include "core/cloth/limits/strain_limiter.h"
#include "core/collision/collision_stage.h"
#include "core/integration/integrator.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"
#include "core/sim/magnetic_motion.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// What a step leaves for people to look at.
struct StepOutcome {
  StepReport report;
  State start;  // of the step, for frames between steps; a failed step goes back to it
  std::vector<std::uint8_t>
      contact;  // (n) rows: 1 in contact, 2 in a triangle that intersects because it is forced to
  std::vector<BrokenLimit> broken;  // of triangles in the internal order, the largest excess first
  std::vector<std::array<Index, 2>>
      forced;  // pairs of triangles (of all surfaces) that intersect because they are forced to
};

// A part of a step in 64ths of it: a step that certification cannot free of impacts, whose solver
// finds no solution, that breaks limits of strain or stops the cloth for them is taken again in
// halves; down to quarters where sweeps alone limit, and where certification took much of the
// motion.
struct StepPart {
  static constexpr int whole = 64, quarter = 16;
  int first = 0, last = whole;
  int length() const { return last - first; }
};

// Stage of stages.
class Stepper {
 public:
  Stepper(const Model& model, const IntegratorOptions& options, const Team& team,
          const RowLayout& layout, const State& state);

  // Advances `state` by one step. Throws SolverFailure; `state` is then that of the start of the
  // step.
  void advance(State& state, StepOutcome& outcome);

  Elasticity& elasticity() { return *elasticity_; }

  // Magnetic force and torque on each body now, and the energy of all magnets [J]; nothing without
  // magnets.
  std::vector<Wrench> magnetic_forces(const State& state) const;
  double magnetic_energy(const State& state) const;

 private:
  // What a part leaves: impacts, whether certification took much of the motion, and whether it
  // broke limits of strain that held at its start, or stopped the cloth for them.
  struct Left {
    std::int64_t impacts = 0;
    bool froze = false;
    bool broke_limits = false;
    bool stopped = false;
  };
  // All stages of a part.
  Left take(State& state, StepOutcome& outcome, StepPart part);
  void loads(const State& state);
  void expect_motion(const State& state);
  void add_attachments(const State& state, ExtraTerms& terms) const;
  double terms_at(const Points& displacement, double time, TermRequest request, ExtraTerms& terms);
  void integrate(State& state, StepReport& report);
  void bodies(State& state, StepReport& report);
  void move_cloth(State& state);
  void limit_strain_rate(State& state, StepOutcome& outcome);
  FreeBodies free_bodies(const State& state) const;
  Left limit_and_certify(State& state, StepOutcome& outcome);
  void count_intersections(State& state, StepOutcome& outcome);
  void measure_contacts(const ClothState& before, const State& state, StepOutcome& outcome);
  Index vertex_of_row(Index row) const;  // in the user's order
  void check(const State& state,
             const char* stage) const;  // throws SolverFailure where the step diverged

  const Model& model_;
  IntegratorOptions options_;
  Team team_;
  std::vector<double> busy_;  // of each thread in this step [s]
  Team collision_team_;       // the same threads, watched
  const RowLayout& layout_;
  std::unique_ptr<Elasticity> elasticity_;
  std::unique_ptr<Integrator> integrator_;
  std::unique_ptr<CollisionStage> collision_;
  std::unique_ptr<RigidWorld> world_;
  std::unique_ptr<MagneticMotion> magnetics_;
  std::unique_ptr<StrainLimiter> limiter_;  // where a cloth has limits
  bool contacts_in_solve_ = false;          // else impulses answer them after the step
  bool limits_in_solve_ = false;            // else they are enforced after it alone

  std::optional<LimitReport>
      left_;  // what limiting left of this part, where nothing has moved since

  // Scratch of a part of a step: its length and ends [s], and its share of what was left of the
  // step.
  std::uint64_t limit_key_ = 0;  // of random orders: which step, which part
  double step_ = 0.0, start_time_ = 0.0, end_time_ = 0.0, share_ = 1.0;
  std::vector<std::uint8_t> fixed_;
  Vector inverse_mass_;
  Points force_, target_, next_obstacles_, x0_, v0_, last_change_, x1_, body_velocity_,
      predicted_body_velocity_;
  std::vector<Mat3> body_blocks_;
  std::vector<RigidPose> start_poses_;  // of bodies
  std::vector<Contact> contacts_;
  ExtraTerms terms_;  // contacts first, then what untangles, then attachments
  std::size_t n_contact_terms_ = 0;
};

}  // namespace loomstone
