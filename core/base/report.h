// Reports: numbers about a step for users, plots and the cache. They do not affect the simulation.
// Each number is declared once, in fields(), for Python, CSV, the cache and help. Its path, such as
// "energy.kinetic", identifies it.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/base/field.h"

namespace loomstone {

// Wall time of each stage of a step [s].
struct StageSeconds {
  double loads = 0.0, proximity = 0.0, integrate = 0.0, bodies = 0.0;
  double certify = 0.0, limit = 0.0, check = 0.0;

  static auto fields() {
    using R = StageSeconds;
    return std::make_tuple(
        field("loads", &R::loads, "s", unlimited(), "scripts, and forces at the start of the step"),
        field("proximity", &R::proximity, "s", unlimited(), "contacts and their terms"),
        field("integrate", &R::integrate, "s", unlimited(), "the cloth's integrator"),
        field("bodies", &R::bodies, "s", unlimited(), "rigid bodies and magnets"),
        field("limit", &R::limit, "s", unlimited(), "strain limits and strain rates"),
        field("certify", &R::certify, "s", unlimited(),
              "continuous collision detection and response"),
        field("check", &R::check, "s", unlimited(), "checks for divergence and intersections"));
  }
};

// Minimum, mean and maximum, over threads, of the time spent in the loops of collision handling
// [s].
struct ThreadReport {
  double least = 0.0, mean = 0.0, most = 0.0;

  static auto fields() {
    using R = ThreadReport;
    return std::make_tuple(field("least", &R::least, "s", unlimited(), "shortest time of a thread"),
                           field("mean", &R::mean, "s", unlimited(), "mean time of the threads"),
                           field("most", &R::most, "s", unlimited(), "longest time of a thread"));
  }
};

// Times that ranks spend computing and waiting in a step, bytes that they send, and number of their
// collective operations. For each rank, the two times add up to the wall time of the step.
struct RankReport {
  double computing = 0.0, most_computing = 0.0, waiting = 0.0, most_waiting = 0.0;
  double collision_computing = 0.0, collision_waiting = 0.0;
  std::int64_t bytes = 0, operations = 0;

  static auto fields() {
    using R = RankReport;
    return std::make_tuple(
        field("computing", &R::computing, "s", unlimited(),
              "time not spent waiting for other ranks, mean of the ranks"),
        field("most_computing", &R::most_computing, "s", unlimited(),
              "time not spent waiting for other ranks, largest of the ranks"),
        field("waiting", &R::waiting, "s", unlimited(),
              "time spent waiting for other ranks, mean of the ranks"),
        field("most_waiting", &R::most_waiting, "s", unlimited(),
              "time spent waiting for other ranks, largest of the ranks"),
        field("collision_computing", &R::collision_computing, "s", unlimited(),
              "part of `computing` in the stages proximity and certify"),
        field("collision_waiting", &R::collision_waiting, "s", unlimited(),
              "part of `waiting` in the stages proximity and certify"),
        field("bytes", &R::bytes, "1", unlimited(), "bytes that a rank sends, mean of the ranks"),
        field("operations", &R::operations, "1", unlimited(),
              "collective operations of a rank, including exchanges of halos"));
  }
};

// Iterations and events of the integrator in a step, and the residual of the last linear solve (in
// Newton schemes, of the last Newton iterate).
struct SolverReport {
  int newton_iterations = 0, linear_iterations = 0;
  double residual = 0.0;
  std::int64_t events = 0, synchronous_events = 0;

  static auto fields() {
    using R = SolverReport;
    return std::make_tuple(
        field("newton_iterations", &R::newton_iterations, "1", unlimited(),
              "Newton iterations; 1 for linearised schemes"),
        field("linear_iterations", &R::linear_iterations, "1", unlimited(),
              "iterations of the linear solver, summed over Newton iterations"),
        field("residual", &R::residual, "1", unlimited(),
              "relative residual of the last linear solve; Newton schemes: of "
              "the nonlinear equations"),
        field("events", &R::events, "1", unlimited(),
              "events of the membrane's triangles in asynchronous steps"),
        field("synchronous_events", &R::synchronous_events, "1", unlimited(),
              "number of events if every triangle took the shortest step of a triangle"));
  }
};

// Error estimates of a step, the length of its shortest part, and the number of parts whose error
// is too large although they cannot be divided further.
struct ErrorReport {
  double strain = 0.0, energy = 0.0, least_part = 0.0;
  int beyond = 0;

  static auto fields() {
    using R = ErrorReport;
    return std::make_tuple(
        field("strain", &R::strain, "1", unlimited(),
              "largest strain that the linear model of a part neglects"),
        field("energy", &R::energy, "1", unlimited(),
              "membrane energy of neglected strains over the kinetic energy of the cloth, largest "
              "of all cloths and parts"),
        field("least_part", &R::least_part, "s", unlimited(), "length of the shortest part"),
        field("beyond", &R::beyond, "1", unlimited(),
              "number of shortest possible parts whose error is still too large"));
  }
};

struct ContactReport {
  std::int64_t near = 0, impacts = 0, unresolved = 0, intersections = 0, forced = 0;
  std::int64_t candidates = 0, registered = 0, evaluated = 0, event_impulses = 0;
  double acceleration = 0.0;

  static auto fields() {
    using R = ContactReport;
    return std::make_tuple(
        field("near", &R::near, "1", unlimited(),
              "contacts: pairs nearer than their thickness, resolved by the solve or by impulses"),
        field("impacts", &R::impacts, "1", unlimited(),
              "pairs that meet, found by the first pass of continuous collision detection"),
        field("candidates", &R::candidates, "1", unlimited(),
              "pairs within reach of each other in an asynchronous step"),
        field(
            "registered", &R::registered, "1", unlimited(),
            "candidates for events; the others are culled because they stay apart or do not cross"),
        field("evaluated", &R::evaluated, "1", unlimited(),
              "evaluations of registered pairs at events"),
        field("event_impulses", &R::event_impulses, "1", unlimited(),
              "impulses on registered pairs at events"),
        field("unresolved", &R::unresolved, "1", unlimited(),
              "impacts that certification leaves after the step has been divided into 1/64"),
        field("intersections", &R::intersections, "1", unlimited(),
              "intersecting triangle pairs at the end; counted from a step with unresolved impacts "
              "until none remain"),
        field("forced", &R::forced, "1", unlimited(),
              "intersecting pairs where scripted motion leaves the cloth no room; see "
              "sim.forced_pairs"),
        field("acceleration", &R::acceleration, "m/s^2", unlimited(),
              "root mean square acceleration of free vertices in contact: change of velocity over "
              "the step"));
  }
};

// Requested motion, and motion that certification withheld.
struct WithheldReport {
  std::int64_t vertices = 0;
  double requested = 0.0, motion = 0.0, share = 0.0, momentum = 0.0;

  static auto fields() {
    using R = WithheldReport;
    return std::make_tuple(
        field("vertices", &R::vertices, "1", unlimited(), "vertices with withheld motion"),
        field("requested", &R::requested, "m", unlimited(),
              "sum of the lengths of free cloth vertices' displacements"),
        field("motion", &R::motion, "m", unlimited(),
              "sum of the lengths withheld from cloth and free bodies"),
        field("share", &R::share, "1", unlimited(), "withheld motion over requested motion"),
        field("momentum", &R::momentum, "kg m/s", unlimited(),
              "mass times withheld velocity, magnitudes summed over vertices and bodies"));
  }
};

// Effort of strain limiting in a step (sweeps, rounds, fallbacks, evaluations), and the excess that
// remains.
struct StrainLimitReport {
  int sweeps = 0, rate_sweeps = 0, rounds = 0, fallbacks = 0;
  std::int64_t evaluations = 0;
  double excess = 0.0, weft_excess = 0.0, warp_excess = 0.0, shear_excess = 0.0;
  std::int64_t beyond = 0, worst_element = -1, broken = 0;

  static auto fields() {
    using R = StrainLimitReport;
    return std::make_tuple(
        field("sweeps", &R::sweeps, "1", unlimited(), "sweeps of strain limiting"),
        field("rate_sweeps", &R::rate_sweeps, "1", unlimited(), "sweeps of strain-rate limiting"),
        field("rounds", &R::rounds, "1", unlimited(),
              "largest number of certifications in a part, between which limits are met again; 1: "
              "limits held after the first"),
        field("fallbacks", &R::fallbacks, "1", unlimited(),
              "rounds with motion withheld because limits and contacts disagree"),
        field("evaluations", &R::evaluations, "1", unlimited(),
              "evaluations of an element's strain in sweeps"),
        field("excess", &R::excess, "1", unlimited(),
              "largest excess (strain beyond its limit) at the end of a part of the step"),
        field("weft_excess", &R::weft_excess, "1", unlimited(),
              "largest excess along weft at the end"),
        field("warp_excess", &R::warp_excess, "1", unlimited(),
              "largest excess along warp at the end"),
        field("shear_excess", &R::shear_excess, "1", unlimited(),
              "largest excess of shear strain at the end"),
        field("beyond", &R::beyond, "1", unlimited(),
              "elements with an excess above the tolerance at the end"),
        field("worst_element", &R::worst_element, "1", unlimited(),
              "element of the largest excess, all cloths end to end; -1: none"),
        field("broken", &R::broken, "1", unlimited(),
              "elements with an excess above 0.01 (a fifth of the limit for limits below 0.05); "
              "see sim.broken_limits"));
  }
};

// Largest strains U - I and largest principal stretch at the end of the step. U is the right
// stretch tensor. The maxima are over all triangles, with or without strain limits.
struct StrainReport {
  double weft = 0.0, warp = 0.0, shear = 0.0, stretch = 1.0;

  static auto fields() {
    using R = StrainReport;
    return std::make_tuple(
        field("weft", &R::weft, "1", unlimited(), "largest strain along weft"),
        field("warp", &R::warp, "1", unlimited(), "largest strain along warp"),
        field("shear", &R::shear, "1", unlimited(), "largest magnitude of shear strain e12"),
        field("stretch", &R::stretch, "1", unlimited(), "largest principal stretch"));
  }
};

struct EnergyReport {
  double kinetic = 0.0, membrane = 0.0, bending = 0.0, gravity = 0.0, contact = 0.0;
  double body_kinetic = 0.0, body_gravity = 0.0, magnetic = 0.0;

  static auto fields() {
    using R = EnergyReport;
    return std::make_tuple(
        field("kinetic", &R::kinetic, "J", unlimited(), "kinetic energy of cloth"),
        field("membrane", &R::membrane, "J", unlimited(), "membrane energy of cloth"),
        field("bending", &R::bending, "J", unlimited(), "bending energy of cloth"),
        field("gravity", &R::gravity, "J", unlimited(), "gravitational energy of cloth"),
        field("contact", &R::contact, "J", unlimited(), "energy of contacts in the solve"),
        field("body_kinetic", &R::body_kinetic, "J", unlimited(),
              "kinetic energy of rigid bodies, translation and rotation"),
        field("body_gravity", &R::body_gravity, "J", unlimited(),
              "gravitational energy of rigid bodies"),
        field("magnetic", &R::magnetic, "J", unlimited(),
              "energy of magnets in one another's field and in the uniform field"));
  }
};

// Work done, energy lost, energy balances and largest kinetic energy since the start of the run, or
// since the user last set positions or velocities.
struct AccountReport {
  double scripts = 0.0, loads = 0.0, friction = 0.0, damping = 0.0, limits = 0.0, withheld = 0.0;
  double lost = 0.0, balance = 0.0, contact_balance = 0.0, largest_kinetic = 0.0;

  static auto fields() {
    using R = AccountReport;
    return std::make_tuple(
        field("scripts", &R::scripts, "J", unlimited(),
              "work of scripted pins and obstacles on cloth and bodies"),
        field("loads", &R::loads, "J", unlimited(),
              "work of air, external forces, forces that untangle, and asynchronous contacts that "
              "restore their gaps, on cloth; work of external forces and torques on bodies"),
        field("friction", &R::friction, "J", unlimited(),
              "work against the friction of contacts, in the solve or at events"),
        field("damping", &R::damping, "J", unlimited(),
              "work against viscosity and damping of bending"),
        field("limits", &R::limits, "J", unlimited(),
              "energy of cloth lost to sweeps of strain limiting and of strain-rate limiting"),
        field("withheld", &R::withheld, "J", unlimited(),
              "energy of cloth and bodies lost to certification"),
        field("lost", &R::lost, "J", unlimited(),
              "remaining loss: by contacts, contacts between bodies, limit impulses and the "
              "integrator"),
        field(
            "balance", &R::balance, "1", unlimited(),
            "increase since the start of the energy (without that of contacts) minus the work, "
            "relative to the largest kinetic energy so far; 0 while cloth moves by rounding errors "
            "only"),
        field("contact_balance", &R::contact_balance, "1", unlimited(),
              "the same balance with the energy of contacts"),
        field("largest_kinetic", &R::largest_kinetic, "J", unlimited(),
              "largest kinetic energy of cloth and bodies so far"));
  }
};

// Sub-steps of the motion of magnets, and largest estimated error of a magnetic force.
struct MagnetReport {
  int substeps = 0;
  double force_error = 0.0;

  static auto fields() {
    using R = MagnetReport;
    return std::make_tuple(
        field("substeps", &R::substeps, "1", unlimited(), "sub-steps of the magnets' motion"),
        field("force_error", &R::force_error, "N", unlimited(),
              "largest estimated error of a magnetic force at the end"));
  }
};

struct CircuitReport {
  double current = 0.0, energy = 0.0, heat = 0.0, supply = 0.0, bearing_work = 0.0;

  static auto fields() {
    using R = CircuitReport;
    return std::make_tuple(
        field("current", &R::current, "A", unlimited(), "current in the first circuit at the end"),
        field("energy", &R::energy, "J", unlimited(),
              "energy of the self and mutual inductances of all circuits"),
        field("heat", &R::heat, "J", unlimited(),
              "heat in the resistances of circuits since the start"),
        field("supply", &R::supply, "J", unlimited(),
              "energy from the sources of all coils since the start"),
        field("bearing_work", &R::bearing_work, "J", unlimited(),
              "energy lost to friction and torques of bearings since the start"));
  }
};

struct StepReport {
  std::int64_t step = 0;
  double time = 0.0, length = 0.0;
  int parts = 1;
  StageSeconds seconds;
  ThreadReport busy;
  RankReport ranks;
  SolverReport solver;
  ErrorReport error;
  ContactReport contacts;
  WithheldReport withheld;
  StrainLimitReport limits;
  StrainReport strain;
  EnergyReport energy;
  AccountReport account;
  MagnetReport magnets;
  CircuitReport circuits;

  static auto fields() {
    using R = StepReport;
    return std::make_tuple(
        field("step", &R::step, "1", unlimited(), "number of the step"),
        field("time", &R::time, "s", unlimited(), "time at the end of the step"),
        field("length", &R::length, "s", unlimited(), "length of the step"),
        field(
            "parts", &R::parts, "1", unlimited(),
            "parts of the step: several if its error is too large, or if certification, limits or "
            "the solver fail at its full length"),
        field("seconds", &R::seconds, "wall time of each stage"),
        field("busy", &R::busy, "time of threads in the loops of collision handling"),
        field("ranks", &R::ranks, "computing and waiting of ranks"),
        field("solver", &R::solver, "solves of the integrator"),
        field("error", &R::error, "error of the step, and its parts"),
        field("contacts", &R::contacts, "contacts and intersections"),
        field("withheld", &R::withheld, "motion that certification withholds"),
        field("limits", &R::limits, "strain limits"),
        field("strain", &R::strain, "strain of all triangles at the end"),
        field("energy", &R::energy, "energies at the end"),
        field("account", &R::account, "work and losses since the start"),
        field("magnets", &R::magnets, "motion of magnets"),
        field("circuits", &R::circuits, "electric circuits and bearings"));
  }
};

// Calls visit(path, field, number) for every number of a report and of its nested reports.
template <class Report, class Visitor>
void for_each_number(Report& report, Visitor&& visit, const std::string& prefix = {}) {
  for_each_field<std::remove_const_t<Report>>([&](const auto& each) {
    auto& value = report.*(each.member);
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(value)>>)
      visit(prefix + each.name, each, value);
    else
      for_each_number(value, visit, prefix + each.name + ".");
  });
}

}  // namespace loomstone
