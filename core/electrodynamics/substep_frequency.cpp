#include "core/electrodynamics/substep_frequency.h"

#include <algorithm>
#include <cmath>

#include "core/electrodynamics/coil_currents.h"

namespace loomstone {

namespace {

// Factor on the squared frequencies of bodies in contact. It divides their frequencies by four and
// thus allows sub-steps four times as long. Such sub-steps are short enough: contacts are resolved
// only to first order in the sub-step in any case, and friction damps the oscillations
// (docs/experiments/scenes.md).
constexpr double touching_share = 1.0 / 16.0;

// Factor on the moments of induced magnets that add_spheres() does not treat. Such a moment changes
// with the distance r from the inducing magnet, so the force can be proportional to r^-7 instead of
// r^-4. The relative derivative of the force is then 7/4 times as large.
constexpr double induced_growth = 1.75;

// Returns the sum of |charge| times distance from the origin over the surface [A m^2]. Unlike the
// moment, it does not become small when charges cancel.
double spread_moment(const SourcePtr& source) {
  double sum = 0.0;
  for (const PanelSample& sample : source->charges())
    sum += std::abs(sample.charge) * sample.position.norm();
  return sum;
}

// Returns the spread_moment() of an induced body with surface charge, and the dipole moment of any
// other induced magnet [A m^2]. If Source::panel_means() is not null and has a smaller
// spread_moment(), returns this smaller moment.
double induced_moment(const MagneticBody& magnet) {
  const SourcePtr &source = magnet.source, panel_means = source->panel_means();
  const double moment = source->induced() ? spread_moment(source) : magnet.moment().norm();
  return panel_means ? std::min(moment, spread_moment(panel_means)) : moment;
}

CoarseMagnet coarse_magnet(const CarriedMagnet& magnet) {
  if (magnet.source || magnet.soft)
    return coarse_magnet(magnet.source ? *magnet.source : *magnet.soft->solid());
  return {std::make_shared<const Points>(Points::Zero(1, 3)), 0.0, 2.0 * magnet.radius};
}

}  // namespace

SubstepFrequency::SubstepFrequency(const MagneticModel& model, const Magnets& magnets)
    : model_(model), magnets_(magnets) {
  for (const CarriedMagnet& magnet : model.magnets) coarse_.push_back(coarse_magnet(magnet));
  for (const CarriedCoil& wound : model.coils)
    coarse_coils_.push_back(coarse_magnet(*wound.source));
  moving_ = coarse_;
  for (const Index i : magnets.induced()) moving_[i].soft_sphere = all_soft_spheres();
  moving_.insert(moving_.end(), coarse_coils_.begin(), coarse_coils_.end());
  for (const CarriedMagnet& magnet : model.magnets) moving_carriers_.push_back(magnet.carrier);
  for (const CarriedCoil& wound : model.coils) moving_carriers_.push_back(wound.carrier);
}

std::vector<Carrier> SubstepFrequency::carriers(const CarrierPlaces& places) const {
  std::vector<Carrier> carriers(model_.n_bodies() + 1);  // last entry: all obstacles
  for (Index b = 0; b < model_.n_bodies(); ++b) {
    const MagneticRotor& body = model_.bodies[b];
    carriers[b] = {body.bearing ? 0.0 : 1.0 / body.mass.mass, 1.0 / body.rotor.moments.minCoeff(),
                   places.bodies.positions.row(b).transpose()};
  }
  return carriers;
}

// Returns the induced spheres. The list is empty unless all_soft_spheres().
std::vector<SoftSphere> SubstepFrequency::spheres(const std::vector<MagneticBody>& magnets) const {
  const std::vector<Index>& induced = magnets_.induced();
  std::vector<SoftSphere> spheres;
  if (!all_soft_spheres()) return spheres;
  for (const Index i : induced)
    spheres.push_back({magnets_.groups()[i], magnets[i].pose.position, magnets[i].moment(),
                       model_.magnets[i].radius});
  return spheres;
}

// Returns whether there are induced bodies and all of them are point dipoles with positive
// polarisability.
bool SubstepFrequency::all_soft_spheres() const {
  return !magnets_.induced().empty() && magnets_.dipoles_only() &&
         magnets_.polarizabilities().minCoeff() > 0.0;
}

SubstepFrequency::Coarse SubstepFrequency::coarse(const Oscillators& now,
                                                  const std::vector<SoftSphere>& spheres) const {
  const std::vector<Index>& induced = magnets_.induced();
  Coarse coarse{coarse_, {}, magnets_.groups()};
  for (const MagneticBody& magnet : now.magnets) coarse.poses.push_back(magnet.pose);
  for (std::size_t k = 0; k < induced.size(); ++k) {
    CoarseMagnet& magnet = coarse.magnets[induced[k]];
    const auto n = static_cast<double>(magnet.positions->rows());
    magnet.soft_sphere = !spheres.empty();
    magnet.moment = magnet.soft_sphere
                        ? spheres[k].moment.norm() / n
                        : induced_growth * induced_moment(now.magnets[induced[k]]) / n;
  }
  for (std::size_t j = 0; j < model_.coils.size(); ++j) {
    const CarriedCoil& wound = model_.coils[j];
    coarse.magnets.push_back(coarse_coils_[j]);
    coarse.magnets.back().moment *= std::abs(now.currents[static_cast<Eigen::Index>(j)]);
    coarse.poses.push_back(now.places.pose(wound.carrier, wound.local));
    coarse.groups.push_back(model_.group(wound.carrier));
  }
  return coarse;
}

// Adds to `squares` the squared frequencies due to two kinds of forces: those between induced
// spheres, and those on induced spheres from the hard magnets and coils that obstacles carry.
void SubstepFrequency::add_spheres(const Team& team, const Oscillators& now, const Coarse& coarse,
                                   const std::vector<SoftSphere>& spheres,
                                   const std::vector<Carrier>& carriers,
                                   std::vector<double>& squares) const {
  add_sphere_frequencies2(team, spheres, carriers, squares);
  const std::vector<Index>& hard = magnets_.hard();
  for (std::size_t k = 0; k < hard.size(); ++k) {
    const Index i = hard[k];
    if (coarse.groups[i] == model_.n_bodies())
      add_sphere_frequencies2(team, spheres,
                              {coarse.magnets[i], coarse.poses[i], now.known[k].there.gradient},
                              carriers, squares);
  }
  Points x(spheres.size(), 3);
  for (std::size_t k = 0; k < spheres.size(); ++k) x.row(k) = spheres[k].position.transpose();
  for (std::size_t j = 0; j < model_.coils.size(); ++j) {
    const std::size_t i = model_.magnets.size() + j;
    if (coarse.groups[i] != model_.n_bodies() || coarse.magnets[i].moment == 0.0) continue;
    const SourcePtr wound =
        model_.coils[j].source->with_current(now.currents[static_cast<Eigen::Index>(j)]);
    add_sphere_frequencies2(team, spheres,
                            {coarse.magnets[i], coarse.poses[i],
                             magnetic_gradient(team, {{wound, coarse.poses[i]}}, x)},
                            carriers, squares);
  }
}

double SubstepFrequency::at(const Team& team, const Oscillators& now) const {
  const std::vector<Carrier> carriers = this->carriers(now.places);
  const std::vector<SoftSphere> spheres = this->spheres(now.magnets);
  const Coarse coarse = this->coarse(now, spheres);
  std::vector<double> squares =
      frequencies2(coarse.magnets, coarse.poses, coarse.groups, carriers, model_.field.norm());
  if (!spheres.empty()) add_spheres(team, now, coarse, spheres, carriers, squares);
  for (std::size_t b = 0; b < now.touching.size(); ++b)
    if (now.touching[b]) squares[b] *= touching_share;
  return std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

double SubstepFrequency::motion_rate(const Team& team, const CarrierPlaces& places,
                                     const std::vector<CarrierMotion>& motions,
                                     double negligible) const {
  std::vector<RigidPose> poses;
  for (const CarriedMagnet& magnet : model_.magnets)
    poses.push_back(places.pose(magnet.carrier, magnet.local));
  for (const CarriedCoil& wound : model_.coils)
    poses.push_back(places.pose(wound.carrier, wound.local));
  double rate = relative_motion_rate(team, {moving_, poses, moving_carriers_, motions}, negligible);
  if (model_.field.isZero(0.0)) return rate;
  // The uniform field exerts torques on bodies and induces voltages in coils, also in coils on
  // obstacles.
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    const bool coil = i >= model_.magnets.size();
    if (coil || (!moving_[i].soft_sphere && moving_carriers_[i] < model_.n_bodies()))
      rate = std::max(rate, motions[moving_carriers_[i]].spin.norm());
  }
  return rate;
}

}  // namespace loomstone
