#include "core/electrodynamics/magnetic_motion.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/magnetics/induction/flux_linkage.h"
#include "core/magnetics/induction/induced_dipoles.h"
#include "core/magnetics/induction/linear_magnetization.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

// More than these a step means that magnets have run into one another, or that the step is far too
// long.
constexpr int most_substeps = 4096;
// A sub-step whose length times frequency has grown to this many times what was asked for is
// halved.
constexpr double tolerated_growth = 4.0 / 3.0;

}  // namespace

MagneticMotion::MagneticMotion(const Model& model) : model_(model), currents_(model, rotors_) {
  for (const MassProperties& mass : model.body_mass) rotors_.push_back(make_rotor(mass.inertia));
  for (std::size_t i = 0; i < model.magnets.size(); ++i) {
    const Model::Carried& magnet = model.magnets[i];
    groups_.push_back(std::min(magnet.carrier, model.n_bodies()));
    (magnet.source ? hard_ : induced_).push_back(static_cast<Index>(i));
    if (magnet.source || magnet.soft)
      coarse_.push_back(coarse_magnet(magnet.source ? *magnet.source : *magnet.soft->solid()));
    else
      coarse_.push_back(CoarseMagnet{std::make_shared<const Points>(Points::Zero(1, 3)), 0.0,
                                     2.0 * magnet.radius});
    soft_ |= magnet.soft != nullptr;
  }
  for (const Model::Wound& wound : model.coils)
    coarse_coils_.push_back(coarse_magnet(*wound.source));
  polarizabilities_.resize(induced_.size());
  for (std::size_t k = 0; k < induced_.size(); ++k)
    polarizabilities_[k] = model.magnets[induced_[k]].polarizability;
}

std::vector<MagneticBody> MagneticMotion::hard(const std::vector<MagneticBody>& magnets) const {
  std::vector<MagneticBody> result;
  for (const Index i : hard_) result.push_back(magnets[i]);
  return result;
}

Points MagneticMotion::applied_field(const Team& team, const std::vector<MagneticBody>& magnets,
                                     const std::vector<MagneticBody>& coils,
                                     std::vector<KnownField>& known) const {
  Points x(induced_.size(), 3), field = Points::Zero(induced_.size(), 3);
  for (std::size_t k = 0; k < induced_.size(); ++k)
    x.row(k) = magnets[induced_[k]].pose.position.transpose();
  for (const MagneticBody& body : hard(magnets)) {
    known.push_back({body, x, magnetic_field_and_gradient(team, body, x)});
    field += known.back().there.field;
  }
  if (!coils.empty()) field += magnetic_field(team, coils, x, "B");
  field.rowwise() += model_.scene.magnetic_field.transpose();
  return field;
}

// Bodies that answer explicitly take no part in the others' magnetisation.
void MagneticMotion::place_soft(const Team& team, std::vector<MagneticBody>& magnets,
                                const std::vector<MagneticBody>& coils) const {
  std::vector<MagneticBody> by = hard(magnets);
  by.insert(by.end(), coils.begin(), coils.end());
  std::vector<SoftBody> mutual;
  std::vector<Index> rows;
  for (const Index i : induced_) {
    const Model::Carried& magnet = model_.magnets[i];
    const SoftBody body{magnet.soft, magnets[i].pose, magnet.saturation};
    if (magnet.cells.rows() > 0) {
      magnets[i] = explicit_response(body, magnet.cells, by, model_.scene.magnetic_field);
      continue;
    }
    mutual.push_back(body);
    rows.push_back(i);
  }
  if (mutual.empty()) return;
  const double tolerance = 1e-2 * model_.scene.magnetic_tolerance;
  const Induction induced = induce(team, mutual, by, model_.scene.magnetic_field, tolerance);
  for (std::size_t k = 0; k < rows.size(); ++k) magnets[rows[k]] = induced.bodies[k];
}

std::vector<MagneticBody> MagneticMotion::placed(const Team& team, const RigidState& state,
                                                 const std::vector<RigidPose>& obstacles,
                                                 const std::vector<MagneticBody>& coils) const {
  std::vector<KnownField> known;
  return placed(team, state, obstacles, coils, known);
}

std::vector<MagneticBody> MagneticMotion::placed(const Team& team, const RigidState& state,
                                                 const std::vector<RigidPose>& obstacles,
                                                 const std::vector<MagneticBody>& coils,
                                                 std::vector<KnownField>& known,
                                                 Points* moments) const {
  known.clear();
  std::vector<MagneticBody> bodies;
  for (const Model::Carried& magnet : model_.magnets)
    bodies.push_back({magnet.source, carried_pose(state, obstacles, magnet.carrier, magnet.local)});
  if (induced_.empty()) return bodies;
  if (soft_) {
    place_soft(team, bodies, coils);
    return bodies;
  }
  Points x(induced_.size(), 3);
  for (std::size_t k = 0; k < induced_.size(); ++k)
    x.row(k) = bodies[induced_[k]].pose.position.transpose();
  const Points induced =
      induced_moments(team, x, polarizabilities_, applied_field(team, bodies, coils, known),
                      1e-2 * model_.scene.magnetic_tolerance, moments ? *moments : Points());
  if (moments) *moments = induced;
  for (std::size_t k = 0; k < induced_.size(); ++k) {
    MagneticBody& body = bodies[induced_[k]];
    body.source = std::make_shared<DipoleSet>(Points::Zero(1, 3), Points(induced.row(k)));
    body.pose.orientation = Vec4(1, 0, 0, 0);
  }
  return bodies;
}

std::vector<Wrench> MagneticMotion::wrenches(const Team& team, const RigidState& state,
                                             const std::vector<RigidPose>& obstacles,
                                             const Vector& currents) const {
  std::vector<KnownField> known;
  const std::vector<MagneticBody> magnets =
      placed(team, state, obstacles, carrying_coils(model_, state, obstacles, currents), known);
  std::vector<Wrench> result = wrenches(team, state, obstacles, magnets, known);
  if (!model_.coils.empty()) {
    add_times(result, 1.0, currents_.on_magnets(state, obstacles, magnets, currents));
    add_times(result, 1.0, currents_.on_coils(state, obstacles, currents));
  }
  result.resize(model_.n_bodies());
  return result;
}

void MagneticMotion::arrive(const Team& team, const RigidState& state,
                            const std::vector<RigidPose>& obstacles, double time, Points& moments) {
  Cause cause{state.positions, state.orientations, obstacles, currents_.resting(),
              currents_.all(time)};
  if (cause_ && *cause_ == cause) return;
  cause_.reset();
  const auto act = [&](const std::vector<MagneticBody>& coils, Points* begin = nullptr) {
    Instant now;
    now.magnets = placed(team, state, obstacles, coils, now.known, begin);
    now.forces = wrenches(team, state, obstacles, now.magnets, now.known);
    return now;
  };
  std::vector<MagneticBody> coils;
  if (!induced_.empty()) coils = carrying_coils(model_, state, obstacles, currents_.all(time));
  now_ = act(coils, &moments);
  std::vector<Wrench> magnetised;
  if (!coils.empty()) {
    magnetised = now_.forces;
    add_times(magnetised, -1.0, act({}).forces);
  }
  CircuitResponse response;
  if (!induced_.empty() && !currents_.circuits().empty()) {
    const auto trial = [&](const Vector& amperes) {
      const Vector currents = currents_.all(time, amperes);
      const Instant then = act(carrying_coils(model_, state, obstacles, currents));
      CircuitTrial result{then.forces, Vector::Zero(currents.size())};
      add_times(result.wrenches, 1.0,
                currents_.on_magnets(state, obstacles, then.magnets, currents));
      for (std::size_t j = 0; j < model_.coils.size(); ++j) {
        if (!wants_flux(model_.scene.coils[j])) continue;
        const Model::Wound& wound = model_.coils[j];
        const MagneticBody coil{wound.source,
                                carried_pose(state, obstacles, wound.carrier, wound.local)};
        for (const Index i : induced_)
          result.flux[static_cast<Eigen::Index>(j)] += linked_flux(coil, then.magnets[i]);
      }
      return result;
    };
    std::vector<Wrench> idle = now_.forces;
    add_times(idle, 1.0, currents_.on_magnets(state, obstacles, now_.magnets, currents_.all(time)));
    response = circuit_response(currents_.circuits(), amperes_beside(now_.magnets), idle, trial);
  }
  currents_.place(state, obstacles, now_.magnets, time, std::move(magnetised), response);
  cause_ = std::move(cause);
}

// As many in each circuit as give it the moment of the strongest magnet: what they do then shows
// beside what magnets do.
Vector MagneticMotion::amperes_beside(const std::vector<MagneticBody>& magnets) const {
  double moment = 0.0;
  for (const MagneticBody& magnet : magnets)
    moment = std::max(moment, magnet.source->moment().norm());
  Vector amperes(currents_.circuits().size());
  for (Eigen::Index k = 0; k < amperes.size(); ++k)
    amperes[k] =
        moment > 0.0 ? moment / model_.coils[currents_.circuits()[k]].source->moment().norm() : 1.0;
  return amperes;
}

std::vector<Wrench> MagneticMotion::wrenches(const Team& team, const RigidState& state,
                                             const std::vector<RigidPose>& obstacles,
                                             const std::vector<MagneticBody>& magnets,
                                             const std::vector<KnownField>& known) const {
  const std::vector<Wrench> each =
      magnetic_wrenches(team, magnets, model_.scene.magnetic_tolerance, groups_, known);
  const Points centres = carrier_centres(state, obstacles);
  std::vector<Wrench> result(centres.rows());
  for (std::size_t i = 0; i < magnets.size(); ++i) {
    const Index carrier = model_.magnets[i].carrier;
    const Vec3 arm = magnets[i].pose.position - centres.row(carrier).transpose();
    result[carrier].force += each[i].force;
    result[carrier].torque += each[i].torque + arm.cross(each[i].force);
    result[carrier].torque += magnets[i].moment().cross(model_.scene.magnetic_field);
    result[carrier].error += each[i].error;
  }
  return result;
}

// Hard magnets in one another's field and in the uniform one; induced dipoles have half of what
// they would have if they were hard, in the field that is not theirs: the other half is stored in
// them.
double MagneticMotion::energy(const Team& team, const RigidState& state,
                              const std::vector<RigidPose>& obstacles, Points moments) const {
  const bool here = cause_ && model_.coils.empty() && cause_->positions == state.positions &&
                    cause_->orientations == state.orientations && cause_->obstacles == obstacles;
  std::vector<KnownField> known;
  const std::vector<MagneticBody> magnets =
      here ? now_.magnets : placed(team, state, obstacles, {}, known, &moments);
  if (here) known = now_.known;
  const std::vector<MagneticBody> hard = this->hard(magnets);
  std::vector<Index> groups;
  double total = 0.0;
  for (const Index i : hard_) {
    groups.push_back(groups_[i]);
    total -= magnets[i].moment().dot(model_.scene.magnetic_field);
  }
  total += magnetic_energy(team, hard, model_.scene.magnetic_tolerance, groups);
  if (induced_.empty()) return total;
  if (soft_) {
    for (const Index i : induced_) {
      total -= 0.5 * magnets[i].moment().dot(model_.scene.magnetic_field);
      for (const MagneticBody& by : hard)
        total += 0.5 * magnetic_energy(by, magnets[i], model_.scene.magnetic_tolerance);
    }
    return total;
  }
  for (std::size_t k = 0; k < induced_.size(); ++k) {
    Vec3 applied = model_.scene.magnetic_field;
    for (const KnownField& field : known) applied += field.there.field.row(k).transpose();
    total -= 0.5 * magnets[induced_[k]].moment().dot(applied);
  }
  return total;
}

MagneticMotion::Done MagneticMotion::advance(const Team& team, double step, const Points& impulses,
                                             const Points& angular_impulses,
                                             const ObstaclePlaces& obstacles,
                                             const ObstaclePlaces& moved_obstacles, double time,
                                             RigidWorld& world, RigidState& state,
                                             CircuitState& circuit, Points& moments) {
  const Index n = model_.n_bodies();
  Points momenta(n, 3);  // angular, world axes [kg m^2/s]
  for (Index b = 0; b < n; ++b) {
    state.velocities.row(b) += impulses.row(b) / model_.body_mass[b].mass;
    const Vec3 spin = state.angular_velocities.row(b).transpose();
    momenta.row(b) =
        angular_momentum(rotors_[b], state.orientations.row(b).transpose(), spin).transpose();
    momenta.row(b) += angular_impulses.row(b);
    if (!currents_.held(b)) continue;
    momenta.row(b) = momenta.row(b).dot(currents_.axis(b)) * currents_.axis(b).transpose();
    state.velocities.row(b).setZero();
  }
  const Points none = Points::Zero(n, 3);
  const Vec3& gravity = model_.scene.gravity;
  std::vector<std::uint8_t> touched;
  std::vector<Wrench> before;
  currents_.move(obstacles.poses, moved_obstacles.poses, step);
  arrive(team, state, obstacles.poses, time, moments);
  Done done;
  int parts = 1;  // the sub-step is step / parts; `place` of them are done
  double limit = model_.scene.magnetic_step;
  for (int place = 0; place < parts;) {
    const ObstaclePlaces here =
        between(obstacles, moved_obstacles, static_cast<double>(place) / parts);
    Vector currents = currents_.all(time + step * place / parts);
    for (const std::size_t j : currents_.circuits())
      currents[static_cast<Eigen::Index>(j)] = circuit.currents[static_cast<Eigen::Index>(j)];
    const double frequency_now = frequency(team, state, here.poses, currents, world);
    while (frequency_now * step > limit * parts && parts <= most_substeps) parts *= 2, place *= 2;
    if (parts > most_substeps || !std::isfinite(frequency_now)) {
      std::ostringstream out;
      out << "magnets must move in at most " << most_substeps
          << " sub-steps, got an angular frequency of " << frequency_now << " rad/s at step "
          << step << " s; shorten integrator.step, or keep point dipoles apart";
      throw SolverFailure(out.str());
    }
    limit = tolerated_growth * model_.scene.magnetic_step;
    const double h = step / parts;
    ++place;
    const ObstaclePlaces at_end =
        between(obstacles, moved_obstacles, static_cast<double>(place) / parts);

    before = now_.forces;
    const double start = time + step * (place - 1) / parts;
    currents_.kick(start + 0.25 * h, 0.5 * h, state, momenta, before, circuit);
    // The world's answer first: it wants velocities after the whole kick.
    RigidState answer{
        state.positions, state.orientations, state.velocities, state.angular_velocities, {}};
    for (Index b = 0; b < n; ++b) {
      const Vec3 kick = h * (before[b].force / model_.body_mass[b].mass + gravity);
      answer.velocities.row(b) += kick.transpose();
      answer.angular_velocities.row(b) =
          angular_velocity(rotors_[b], state.orientations.row(b).transpose(),
                           momenta.row(b).transpose() + h * before[b].torque)
              .transpose();
    }
    world.advance(h, none, none, at_end, answer, &touched);
    for (Index b = 0; b < n; ++b) {
      const Vec4 orientation = state.orientations.row(b).transpose();
      if (touched[b] && !currents_.held(b)) {
        const Vec3 spin = answer.angular_velocities.row(b).transpose();
        momenta.row(b) = angular_momentum(rotors_[b], orientation, spin).transpose();
        momenta.row(b) -= 0.5 * h * before[b].torque.transpose();
        state.velocities.row(b) =
            answer.velocities.row(b) -
            0.5 * h * (before[b].force / model_.body_mass[b].mass + gravity).transpose();
        state.positions.row(b) = answer.positions.row(b);
        state.orientations.row(b) = answer.orientations.row(b);
        continue;
      }
      momenta.row(b) += 0.5 * h * before[b].torque.transpose();
      state.velocities.row(b) +=
          0.5 * h * (before[b].force / model_.body_mass[b].mass + gravity).transpose();
      state.positions.row(b) += h * state.velocities.row(b);
      state.orientations.row(b) =
          freely_turned(rotors_[b], orientation, momenta.row(b).transpose(), h).transpose();
    }
    arrive(team, state, at_end.poses, start + h, moments);
    before = now_.forces;
    currents_.kick(start + 0.75 * h, 0.5 * h, state, momenta, before, circuit);
    for (Index b = 0; b < n; ++b) {
      momenta.row(b) += 0.5 * h * before[b].torque.transpose();
      state.velocities.row(b) +=
          0.5 * h * (before[b].force / model_.body_mass[b].mass + gravity).transpose();
    }
    ++done.substeps;
  }
  for (Index b = 0; b < n; ++b) {
    state.angular_velocities.row(b) =
        angular_velocity(rotors_[b], state.orientations.row(b).transpose(),
                         momenta.row(b).transpose())
            .transpose();
    done.error = std::max(done.error, before[b].error);
    if (!state.positions.row(b).allFinite() || !state.velocities.row(b).allFinite() ||
        !momenta.row(b).allFinite())
      throw SolverFailure(
          "bodies[" + std::to_string(b) +
          "] must stay finite, got NaN or infinity from magnetic forces; shorten integrator.step");
  }
  return done;
}

}  // namespace loomstone
