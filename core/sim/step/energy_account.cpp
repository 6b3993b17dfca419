#include "core/sim/step/energy_account.h"

#include <algorithm>
#include <cmath>

#include "core/base/same_bits.h"
#include "core/sim/step/energies.h"

namespace loomstone {

namespace {

// Tolerated gain of energy, as a fraction of a scale, if ImplicitOptions::accuracy is 1; the
// accuracy multiplies this tolerance. A part in which the energy of contacts rises by more than
// this is shortened if the sum of all energies, minus the work of scripts and loads, has also risen
// by more than this since the account began. In automatic steps in which no pin moves, nothing is
// untangled and no triangle is in a limit phase, the same sum plus known_losses() must not rise by
// more than this in the part either. (Where pins push a ribbon, this would take 205 steps where
// fewer than 160 suffice. In given steps, it would disturb cloth that comes to rest.) The scale is
// the largest kinetic energy so far or the energy of contacts at the start of the part, whichever
// is larger. Our choice: in 27 falls of towels on a floor, the gain is then at most 0.023
// (docs/experiments/energy.md). The same fraction, with a larger scale, bounds other gains; see
// share_of_rise. Schemes without damping take parts by backward Euler while relative_gain() exceeds
// 1, that is, while they have gained more than this fraction, times the accuracy, of the largest of
// the energies that are listed at relative_gain().
constexpr double gain_tolerance = 0.02;
// Energy that everything but contacts may gain in a part, as a fraction of the scale of
// gain_tolerance (but see share_of_work). The gain excludes the work of scripts and loads, the
// energy that contacts lose and the energy that sweeps of strain limiting add. If pins move in the
// part and no triangle is in a limit phase, gain_tolerance applies instead. The accuracy multiplies
// this tolerance, too.
// Our choice: the gain is 0.63 where contacts throw apart two magnets that should stay together, up
// to 0.07 in harmless parts of a scene with magnets on cloth, and at most 0.003 in 14 other scenes
// (docs/experiments/energy.md).
constexpr double release_tolerance = 0.1;
// For the gain of everything but contacts in a part, the scale is at least this fraction of the
// work of scripts in the part. For the gain since the account began (see share_of_rise), the
// scale is at least this fraction of the work of scripts or of the work of loads since then,
// whichever is larger. Our choice: with fractions from 0.05 to 0.2, slow shear of stiff cloth keeps
// its long steps, and pushed cloth gains at most 0.02 of the largest kinetic energy.
constexpr double share_of_work = 0.1;
// Energy that may vanish in a part with implicit Euler, as a fraction of the scale of
// gain_tolerance or of the elastic energy of cloth and contacts, whichever is larger. Vanished
// energy counts only up to the work that scripts do in the part. The accuracy multiplies this
// tolerance, too. Our choice: where pins pull stiff cloth over the edge of a table without
// friction, in automatic steps, the fraction is up to 13 without this check. The pins then do
// 0.47 J of work; with the check, they do 0.03 J. With a tolerance of 0.05, a pushed ribbon takes a
// tenth more steps (docs/experiments/energy.md).
constexpr double loss_tolerance = 0.15;
// A part is halved if everything but contacts has gained more than the tolerated energy since the
// account began, and more than this fraction of the tolerated energy in the part (see
// check_energy() for exceptions). Our choice: in one part, neglected strain may add a fifth of the
// kinetic energy to the membrane, but only a sixteenth of that if the part has half the length.
// With 0.25, stiff sheets that swing in steps of 4 ms gain up to 0.04 of the largest kinetic
// energy.
constexpr double share_of_rise = 0.05;
// A part in which contacts create too much energy is shortened to the largest length at whose end
// neither of these sums (see gain_tolerance) is expected to have risen by more than this fraction
// of the tolerated energy. The part is not shortened below the shortest permitted length.
constexpr double aim = 0.5;
// Largest tolerated result of add_to_account() for a part of an asynchronous step, as a fraction of
// the largest kinetic energy so far. Our choice.
constexpr double tolerated_after_solve = 0.005;

// Returns the energy of everything but contacts [J]. Includes the energy that resistances and
// bearings have taken since the start, minus CircuitState::supply.
double total_energy(const StepReport& report) {
  const EnergyReport& e = report.energy;
  const CircuitReport& c = report.circuits;
  return e.kinetic + e.membrane + e.bending + e.gravity + e.body_kinetic + e.body_gravity +
         e.magnetic + c.energy + c.heat + c.bearing_work - c.supply;
}

double body_kinetic_energy(const Engines& engines, const State& state) {
  EnergyReport bodies;
  measure_bodies(engines.model, state.rigid, bodies);
  return bodies.body_kinetic;
}

// Returns the energy that cloth and bodies have lost since the stage that moved the bodies [J].
// note_solved() has noted the state after that stage in `solved`.
double lost_after_solve(const Solved& solved, const Engines& engines, const State& state) {
  EnergyReport bodies;
  measure_bodies(engines.model, state.rigid, bodies);
  double lost = solved.body_energy - bodies.body_kinetic - bodies.body_gravity;
  const ClothState& cloth = state.cloth;
  if (solved.x.rows() == 0) return lost;
  if (!same_bits(solved.v, cloth.v))
    lost += kinetic_energy(engines, solved.v) - kinetic_energy(engines, cloth.v);
  if (!same_bits(solved.x, cloth.x)) {
    const double before = potential_energy(engines, solved.x);
    lost += before - potential_energy(engines, cloth.x);  // last, so that this energy stays cached
  }
  return lost;
}

// Returns the energy of everything but contacts, minus its value when the account began and minus
// the work of scripted motion and loads [J].
double gain_of(const EnergyAccount& account, const StepReport& report) {
  return total_energy(report) - account.start - account.scripts - account.loads;
}

// Returns gain_of() [J] for `state`, whose obstacles have the poses `obstacles`.
double measured_gain(const SteppedState& state, const std::vector<RigidPose>& obstacles,
                     const Engines& engines) {
  StepReport report;
  measure_without_contacts(state, obstacles, engines, *engines.elasticity, report);
  return gain_of(state.account, report);
}

// Returns a bound on the energy of rounding errors [J]: the kinetic energy of cloth that moves by
// 1e-10 of its size in the time h [s]. Our choice: rounding of positions moves cloth by about 1e-16
// of its size.
double rounding_energy(double h, const Model& model) {
  const double speed = 1e-10 * model.cloth_size / h;
  return 0.5 * model.cloth.mass.sum() * speed * speed;
}

// Returns gain_of() [J] for the start of the part. Reads from `state` only data that are constant
// during a step.
double gain_at_start(const StepContext& part, const Engines& engines, const State& state) {
  std::vector<RigidPose> obstacles;
  if (engines.magnetics) {
    State start = state;
    static_cast<SteppedState&>(start) = *part.start;
    obstacles = poses_of_magnets(start, part.t0, engines);
  }
  return measured_gain(*part.start, obstacles, engines);
}

// Energies in a part [J].
struct PartEnergies {
  double at_start, at_end;  // gain_of() at the start and at the end
  double by_contacts;       // energy that contacts have gained
  double of_contacts;       // energy of contacts at the end
};

// Returns the energy that friction, damping, strain limits and certification have taken in the part
// [J].
double known_losses(const StepContext& part, const State& state) {
  const auto of = [](const EnergyAccount& account) {
    return account.friction + account.damping + account.limits + account.withheld;
  };
  return of(state.account) - of(part.start->account);
}

// Returns whether the energy that contacts create in the part is compared with the start of the
// part, too (see gain_tolerance). Limit phases (`limited`) and untangling may release energy that
// the account omits.
bool judged_alone(const StepContext& part, const NearContacts& near, bool pinned, bool limited) {
  return part.automatic && !pinned && !limited && near.tangle.empty();
}

// Returns whether too much of the work that scripts did in the part has been lost other than by
// known_losses(). `scale` [J] is that of gain_tolerance.
bool loses_work(const StepContext& part, const PartEnergies& energies, double scale,
                const Engines& engines, const State& state) {
  const double lost =
      energies.at_start - energies.at_end - energies.by_contacts - known_losses(part, state);
  const double wasted = std::min(lost, state.account.scripts - part.start->account.scripts);
  const double tolerance = loss_tolerance * *engines.accuracy;
  if (wasted <= tolerance * std::max(scale, rounding_energy(part.h, engines.model))) return false;
  const double elastic = engines.elasticity->membrane_energy(engines.team, state.cloth.x) +
                         engines.elasticity->bending_energy(engines.team, state.cloth.x);
  return wasted > tolerance * (elastic + energies.of_contacts);
}

}  // namespace

void begin_account(const Engines& engines, State& state) {
  if (state.account.begun) return;
  StepReport report;
  engines.contact_energy.reset();
  know_contacts(state, engines);
  measure_energies(state, state.time, engines, *engines.elasticity, report);
  state.account = {};
  state.account.begun = true;
  state.account.start = total_energy(report);
  state.account.start_of_contacts = report.energy.contact;
  state.account.largest_kinetic = report.energy.kinetic + report.energy.body_kinetic;
}

double add_to_account(const PartWork& work, const Solved& solved, const AfterSolve& after,
                      const Engines& engines, State& state) {
  EnergyAccount& account = state.account;
  account.scripts += work.scripts, account.loads += work.loads;
  account.friction += work.friction, account.damping += work.damping;
  account.limits += after.limited;
  const double lost = lost_after_solve(solved, engines, state) - after.limited;
  // Untangling forces or scripted motion, if there are any, account for an increase of the energy.
  if (lost < 0.0 && after.untangles)
    account.loads -= lost;
  else if (lost < 0.0 && after.surfaces_move)
    account.scripts -= lost;
  else
    account.withheld += lost;
  const double kinetic =
      kinetic_energy(engines, state.cloth.v) + body_kinetic_energy(engines, state);
  account.largest_kinetic = std::max(account.largest_kinetic, kinetic);
  return after.untangles ? 0.0 : std::max(0.0, -lost) + std::max(0.0, solved.moved.carried_gain);
}

double relative_gain(const StepContext& part, const Engines& engines, const State& state) {
  if (!engines.accuracy) return 0.0;
  const EnergyAccount& account = state.account;
  const double scale = std::max({account.largest_kinetic, std::abs(account.scripts),
                                 std::abs(account.loads), rounding_energy(part.h, engines.model)});
  return (gain_at_start(part, engines, state) - account.start_of_contacts) /
         (gain_tolerance * *engines.accuracy * scale);
}

void report_account(const Model& model, const State& state, StepReport& report) {
  const EnergyAccount& account = state.account;
  AccountReport& to = report.account;
  to = {};
  if (!account.begun) return;
  to.scripts = account.scripts, to.loads = account.loads;
  to.friction = account.friction, to.damping = account.damping;
  to.limits = account.limits, to.withheld = account.withheld;
  to.largest_kinetic = account.largest_kinetic;
  const double gain = gain_of(account, report);
  to.lost = -gain - account.friction - account.damping - account.limits - account.withheld;
  const double rounding = report.length > 0.0 ? rounding_energy(report.length, model) : 0.0;
  if (account.largest_kinetic <= rounding) return;
  to.balance = gain / account.largest_kinetic;
  to.contact_balance =
      (gain + report.energy.contact - account.start_of_contacts) / account.largest_kinetic;
}

PartResult check_energy(const StepContext& part, const Loads& loads, const NearContacts& near,
                        double gained, const Engines& engines, const State& state) {
  const auto created = [](int longest) {
    return PartResult{.longest = longest, .gains_energy = true};
  };
  if (engines.event_contacts) {
    const int least = surfaces_move(loads) ? StepPart::quarter : StepPart::least;
    const bool repeat = gained > tolerated_after_solve * state.account.largest_kinetic;
    return repeat && part.length > least ? created(part.length / 2) : PartResult{};
  }
  if (!engines.error || !engines.contacts_in_solve || !part.halvable) return {};
  const bool pinned = pins_move(engines.model.cloth, loads);
  const bool moves = !part.automatic && surfaces_move(loads), meets = near.any_terms || pinned;
  if (part.length <= (moves && meets ? StepPart::quarter : StepPart::least)) return {};
  const EnergyAccount& account = state.account;
  const double scale = std::max(account.largest_kinetic, near.energy);
  const double tolerated = gain_tolerance * *engines.accuracy * scale;
  // Limit phases store energy that the account omits. at_limits() refers to the solve of the part
  // until energy_at_end() finds the phases at the end.
  const bool damps = engines.integrator->damps(), stores = engines.at_limits();
  const bool may_gain = (pinned || !damps) && !stores;
  const double energy = energy_at_end(state, part.t1, engines);
  const bool squeezed = moves && (meets || energy > 0.0), moved = pinned && may_gain;
  const int least = squeezed ? StepPart::quarter : StepPart::least;
  if (part.length <= least) return {};
  if (!may_gain && !damps && std::max(energy, near.energy) <= tolerated) return {};
  // The gain at the start is measured first, because energies at the start positions are still
  // cached.
  const double at_start = gain_at_start(part, engines, state);
  const double at_end = measured_gain(state, poses_of_magnets(state, part.t1, engines), engines);
  const double by_contacts = energy - near.energy;
  // Energy that sweeps of strain limiting add is not counted: shorter parts do not prevent it.
  const double by_limits = account.limits - part.start->account.limits;
  const double in_part = at_end - at_start + std::min(0.0, by_contacts) + std::min(0.0, by_limits);
  // If scripts stretch cloth slowly, their work is much larger than the kinetic energy.
  const double work = std::abs(account.scripts - part.start->account.scripts);
  const double most =
      (moved ? gain_tolerance : release_tolerance) *
      std::max({scale, share_of_work * work, rounding_energy(part.h, engines.model)});
  const int half = std::max(least, part.length / 2);
  if (in_part > *engines.accuracy * most) return created(half);
  const double gain = at_end - account.start_of_contacts;
  const double all_work = std::max(std::abs(account.scripts), std::abs(account.loads));
  const double most_rise =
      gain_tolerance * *engines.accuracy *
      std::max({scale, share_of_work * all_work, rounding_energy(part.h, engines.model)});
  if (gain > most_rise && in_part > share_of_rise * most_rise) return created(half);
  if (damps && part.saves_work && !squeezed && !stores && !engines.at_limits() &&
      loses_work(part, {at_start, at_end, by_contacts, energy}, scale, engines, state))
    return {.longest = half};
  const double in_this_part = at_end - at_start + known_losses(part, state) - near.energy;
  const bool alone = judged_alone(part, near, pinned, stores || engines.at_limits());
  const double without_contacts = alone ? std::max(gain, in_this_part) : gain;
  if (by_contacts <= tolerated || without_contacts + energy <= tolerated) return {};
  const std::vector<double> energies =
      contact_energies(state, part.t1, engines, *engines.elasticity, &loads.x0, part.length);
  int longest = part.length;
  while (longest > least && without_contacts + energies[longest - 1] > aim * tolerated) --longest;
  return created(longest);
}

}  // namespace loomstone
