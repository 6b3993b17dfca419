// Time integration of all cloths. The options select the scheme. See docs/method.md, "Integrators",
// and (2.51)-(2.55) of [Thomaszewski2010].
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/event_motion.h"
#include "core/base/own_rows.h"
#include "core/base/types.h"
#include "core/cloth/cloth_model.h"
#include "core/cloth/cloth_state.h"
#include "core/cloth/elasticity.h"
#include "core/integration/event_collisions.h"
#include "core/integration/options.h"
#include "core/linalg/extra_terms.h"
#include "core/linalg/linear_solver.h"
#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

namespace loomstone {

// Evaluates the terms of a step after the rows have moved by `displacement` (rows x 3) [m, rad] in
// `time` [s]. On entry, `terms` are the terms at the start of the step. Sets their gradient and
// Hessian in the way that `request` selects. Returns their energy up to a constant [J].
using TermsAt = std::function<double(const Points& displacement, double time, TermRequest request,
                                     ExtraTerms& terms)>;

// Updates the friction of `terms` after the rows have moved by `displacement` in `time` [s]. Also
// softens contacts that have pulled and, unless `keep_normal` is set, stiffens those whose gap
// would shrink too much (see ContactTerms::forces_after()). On return, the terms are linearised
// about the start of the step. Returns the relative error, over all ranks, of the forces that
// `terms` had before the call (see ContactError::relative()) [1], or 1 if a contact was stiffened
// on any rank. Collective.
using ForcesAfter = std::function<double(const Points& displacement, double time, bool keep_normal,
                                         ExtraTerms& terms)>;

// The b rigid bodies that the integrator moves within the step. The integrator ignores contacts of
// the bodies with each other and with obstacles.
struct BodiesOfStep {
  const std::vector<RigidPose>* poses = nullptr;  // (b) poses at the start
  // (2 b x 3) velocities at the start, before the impulses of any loads [m/s, rad/s]
  const Points* velocity = nullptr;
  // Vertices attached to bodies, each listed once.
  const std::vector<AttachedVertex>* attached = nullptr;
  std::vector<RigidPose>* end = nullptr;  // (b) poses at the end; set on return
  // (b) 1: vertices are attached to the body, or cloth has pushed it; set on return
  std::vector<std::uint8_t>* with_cloth = nullptr;
};

// Input of a step. Tables with the size (rows) have a row for each cloth vertex. If the linear
// system includes rigid bodies, two rows per body (translation, rotation) follow.
struct StepInputs {
  double step = 0.0;  // length h [s]
  double time = 0.0;  // start of the step [s]
  // Gravity, drag and user forces at the start [N], in cloth rows of this rank.
  const OwnRows* force = nullptr;
  Vec3 gravity = Vec3::Zero();  // acceleration [m/s^2]
  // Contacts, friction, attachments and untangling; implicit schemes only. See also
  // Integrator::needs_all_terms().
  const ExtraTerms* terms = nullptr;
  // Called by Newton schemes for each velocity that they try; null: the terms are linear.
  const TermsAt* terms_at = nullptr;
  // Called by linearised schemes after a linear solve. If the returned error of contact forces is
  // too large, they solve again with the updated terms. Null, on all ranks, if no rank has terms of
  // contacts.
  const ForcesAfter* forces_after = nullptr;
  const std::vector<std::uint8_t>* fixed = nullptr;  // (rows) 1: prescribed motion
  // (n x 3) Positions of prescribed vertices at the end [m]. The rows of other vertices are not
  // used. There are no rows if no vertex is prescribed.
  const Points* target = nullptr;
  // True, on all ranks, if the midpoint rules and BDF-2 must take the step by backward Euler for
  // one of two reasons: a triangle of any rank is in a stiff phase of its strain limits (see
  // LimitPhase), or the scheme has gained more energy than is tolerated (see relative_gain() in
  // core/sim/step/energy_account.h). In a stiff phase, the formulas of midpoint and BDF-2 would
  // make the cloth rebound from the limit. For contacts, see in_contact().
  bool damped = false;
  // Linearised schemes multiply the tolerance of the iterative solver by this factor [1].
  double tolerance_factor = 1.0;
  // True, on all ranks, if contacts, untangling or attachments may couple bodies with cloth. BDF-2
  // then takes the step by midpoint, or by backward Euler if `damped` or in_contact() is true.
  // Forces that act on cloth by BDF-2 and on bodies by symplectic Euler would not conserve
  // momentum.
  bool couples_bodies = false;
  // Handles collisions at events. Used only by schemes with events_collide(). May be null.
  EventCollisions* collisions = nullptr;
  // Rigid bodies. Used only by schemes with moves_bodies(). Null: none.
  const BodiesOfStep* bodies = nullptr;
  // (2 b) two entries per body: mass times identity [kg], then inertia in world axes [kg m^2]
  const std::vector<Mat3>* body_mass = nullptr;

  // Returns whether any rank has terms of contacts. If so, the midpoint rules and BDF-2 take the
  // step by backward Euler. With their own formulas, cloth on stiff contacts would not come to
  // rest. The nonlinear midpoint rule evaluates contacts at the middle of the step, so contacts
  // that close within a step would add energy. BDF-2 would repeat the effect of impacts in the next
  // step.
  bool in_contact() const { return forces_after != nullptr; }
};

struct IntegrationReport {
  int newton_iterations = 1;
  int linear_iterations = 0;
  // Relative residual of the last linear solve or, in Newton schemes, of the final iterate [1].
  double residual = 0.0;
  // Newton schemes only: relative residuals of the first guess and then of each iterate.
  std::vector<double> newton_residuals;
  // Number of triangle events in an asynchronous step, and the number that would be needed if all
  // triangles had the shortest step.
  std::int64_t events = 0, synchronous_events = 0;
};

// Thrown if a Newton scheme does not converge. `row` is the cloth vertex with the largest residual
// among those that are not prescribed.
class NewtonFailure : public StepFailure {
 public:
  NewtonFailure(const std::string& what, Index row) : StepFailure(what), row(row) {}
  Index row;
};

// Interface of all integrators.
class Integrator {
 public:
  virtual ~Integrator() = default;
  // Advances state.x and state.v by one step, in all rows on all ranks. On entry, body_velocity
  // (2 b x 3) contains the velocities predicted from the loads on the bodies. Implicit and
  // asynchronous schemes add the changes due to the cloth. If the step fails, throws StepFailure if
  // a shorter step may succeed, and another SolverFailure otherwise.
  virtual IntegrationReport advance(const Team& team, const RowLayout& layout,
                                    const StepInputs& inputs, ClothState& state,
                                    Points& body_velocity) = 0;
  virtual bool implicit() const = 0;            // true: the scheme accepts extra terms
  virtual bool damps() const { return false; }  // true: an implicit Euler scheme
  // True if the energy of neglected strain, 1/2 dF^T dF over a step, stays in the cloth.
  virtual bool keeps_neglected_energy() const { return false; }
  // Time after the start of the step at which an implicit scheme evaluated forces in the last call
  // of advance(), as a fraction of the step [1].
  virtual double time_of_forces() const { return 1.0; }
  // Terms of the last linear solve in the last call of advance(), if they differ from
  // StepInputs::terms; otherwise null. Linearised schemes solve again with other contact forces if
  // the error of those in the first solve was too large (see StepInputs::forces_after).
  virtual const ExtraTerms* terms_of_last_solve() const { return nullptr; }
  // True if the scheme handles collisions at events within a step.
  virtual bool events_collide() const { return false; }
  // True if the scheme needs the extra terms of all rows on every rank. Otherwise a rank may omit
  // terms that act on no row of this rank.
  virtual bool needs_all_terms() const { return true; }
  // True if the scheme itself moves rigid bodies within the step (see BodiesOfStep).
  virtual bool moves_bodies() const { return false; }
  // True if the scheme evaluates energies, as Newton schemes do.
  virtual bool asks_energy() const { return false; }
  // Work that scripts have done on prescribed vertices in the last call of advance() against the
  // forces of the cloth and its loads [J]; empty if the scheme does not measure it. The change of
  // the vertices' kinetic energy is not included.
  virtual std::optional<double> work_on_prescribed() const { return {}; }
  // Memory of the vectors of a step, of the linear solver without its preconditioner, and of the
  // preconditioner [bytes].
  struct Memory {
    std::size_t vectors = 0, solver = 0, preconditioner = 0;
  };
  virtual Memory memory() const { return {}; }
};

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options,
                                            const ClothModel& model, Elasticity& elasticity);

// Returns how bending enters the step. In the implicit Euler schemes, BendingInStep::Auto selects
// implicit bending if explicit bending would be unstable or nearly so. In midpoint and BDF-2,
// explicit bending amplifies oscillations in every step, and Auto selects implicit bending if
// amplitudes would grow by more than 1 % per second. With implicit bending, semi-implicit Euler
// uses the lumped bending stiffness, unless bending is damped or the Jacobian is exact. Other
// implicit schemes use the full stiffness. Explicit and asynchronous schemes always treat bending
// explicitly.
BendingTreatment bending_treatment(const IntegratorOptions& options, const ClothModel& model);

}  // namespace loomstone
