#include "core/electrodynamics/coil_forces.h"

#include <algorithm>
#include <cmath>

#include "core/electrodynamics/coil_currents.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

// Returns the force between two coaxial dipoles with the moments of the bodies [N]. Their distance
// is that of the bodies, but at least the larger of the two radii. Errors of forces are tolerated
// relative to at least a tenth of this force.
double scale_of_force(const MagneticBody& a, const MagneticBody& b) {
  const double apart = std::max(
      {(a.pose.position - b.pose.position).norm(), a.source->radius(), b.source->radius()});
  return 1.5 * mu0 / pi * a.source->moment().norm() * b.source->moment().norm() /
         std::pow(apart, 4);
}

}  // namespace

PlacedCoils::PlacedCoils(const MagneticModel& model, const CarrierPlaces& places,
                         std::vector<Twist> twists)
    : model_(model),
      twists_(std::move(twists)),
      centres_(places.centres()),
      coils_(placed_coils(model, places)) {}

bool PlacedCoils::joined(Index a, Index b) const {
  const auto rests = [&](Index carrier) {
    return carrier >= model_.n_bodies() && twists_[carrier - model_.n_bodies()].rests();
  };
  return a == b || (rests(a) && rests(b));
}

// Adds the wrenches between `coil`, which carries 1 A, and `other`, multiplied by `factor`, about
// the reference points of their carriers. Adds nothing if the carriers are joined().
void PlacedCoils::meet(const Part& coil, const Part& other, double factor,
                       CarrierWrenches& result) const {
  if (joined(coil.carrier, other.carrier)) return;
  const Wrench w = magnetic_wrench(coil.body, other.body, model_.tolerance,
                                   0.1 * scale_of_force(coil.body, other.body));
  const auto add = [&](Index carrier, const Vec3& at, const Vec3& force, const Vec3& torque) {
    result[carrier].force += force;
    result[carrier].torque += torque + (at - centres_.row(carrier).transpose()).cross(force);
  };
  const Vec3 &here = coil.body.pose.position, &there = other.body.pose.position;
  add(coil.carrier, here, factor * w.force, factor * w.torque);
  add(other.carrier, there, -factor * w.force,
      -factor * (w.torque + (here - there).cross(w.force)));
}

CarrierWrenches PlacedCoils::with_magnets(const std::vector<MagneticBody>& magnets,
                                          const Vector& currents) const {
  CarrierWrenches result(centres_.rows());
  for (std::size_t j = 0; j < coils_.size(); ++j) {
    const double current = currents[static_cast<Eigen::Index>(j)];
    for (std::size_t k = 0; k < magnets.size() && current != 0.0; ++k)
      meet(coil(j), magnet(magnets, k), current, result);
  }
  return result;
}

CarrierWrenches PlacedCoils::among_coils(const Vector& currents) const {
  CarrierWrenches result(centres_.rows());
  for (std::size_t j = 0; j < coils_.size(); ++j) {
    const double current = currents[static_cast<Eigen::Index>(j)];
    result[model_.coils[j].carrier].torque += current * coils_[j].moment().cross(model_.field);
    for (std::size_t k = 0; k < j && current != 0.0; ++k)
      meet(coil(j), coil(k), current * currents[static_cast<Eigen::Index>(k)], result);
  }
  return result;
}

CoilForces PlacedCoils::per_ampere(const std::vector<MagneticBody>& magnets, double time,
                                   const CircuitResponse& response) const {
  const std::vector<std::size_t>&given = model_.given, &circuits = model_.circuits;
  CoilForces forces;
  forces.per_ampere.assign(coils_.size(), CarrierWrenches(centres_.rows()));
  forces.sense.assign(coils_.size(), 1.0);
  const bool answered = !response.linear.empty();
  const auto place_coil = [&](std::size_t j, std::size_t n_given, bool on_magnets) {
    CarrierWrenches& result = forces.per_ampere[j];
    for (std::size_t k = 0; k < magnets.size() && on_magnets; ++k)
      meet(coil(j), magnet(magnets, k), 1.0, result);
    for (std::size_t g = 0; g < n_given; ++g)
      meet(coil(j), coil(given[g]), given_current(model_.coils[given[g]].coil, time), result);
    result[model_.coils[j].carrier].torque += coils_[j].moment().cross(model_.field);
    const Vec3 axis = rotation_matrix(coils_[j].pose.orientation).col(2);
    if (axis.dot(model_.coils[j].coil.commutator) < 0.0) forces.sense[j] = -1.0;
  };
  for (std::size_t g = 0; g < given.size(); ++g) place_coil(given[g], g, true);
  for (std::size_t k = 0; k < circuits.size(); ++k) {
    place_coil(circuits[k], given.size(), !answered);
    if (answered) add_times(forces.per_ampere[circuits[k]], 1.0, response.linear[k]);
  }
  forces.pairs = response.quadratic;
  for (std::size_t k = 1; k < circuits.size(); ++k)
    for (std::size_t j = 0; j < k; ++j) {
      const Part a = coil(circuits[j]), b = coil(circuits[k]);
      if (joined(a.carrier, b.carrier)) continue;
      forces.pairs.push_back({j, k, CarrierWrenches(centres_.rows())});
      meet(a, b, 1.0, forces.pairs.back().wrenches);
    }
  return forces;
}

}  // namespace loomstone
