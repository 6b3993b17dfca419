#include "core/electrodynamics/magnets.h"

#include "core/electrodynamics/coil_currents.h"
#include "core/magnetics/induction/induced_dipoles.h"
#include "core/magnetics/induction/linear_magnetization.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/sphere.h"

namespace loomstone {

namespace {

// Tolerated relative residual of the solve for the magnetisation, as a fraction of the force
// tolerance [1].
constexpr double share_of_tolerance = 1e-2;

}  // namespace

Magnets::Magnets(const MagneticModel& model) : model_(model) {
  for (std::size_t i = 0; i < model.magnets.size(); ++i) {
    const CarriedMagnet& magnet = model.magnets[i];
    groups_.push_back(model.group(magnet.carrier));
    (magnet.source ? hard_ : induced_).push_back(static_cast<Index>(i));
    soft_ |= magnet.soft != nullptr;
  }
  polarizabilities_.resize(induced_.size());
  for (std::size_t k = 0; k < induced_.size(); ++k)
    polarizabilities_[k] = model.magnets[induced_[k]].polarizability;
}

std::vector<MagneticBody> Magnets::hard(const std::vector<MagneticBody>& magnets) const {
  std::vector<MagneticBody> result;
  for (const Index i : hard_) result.push_back(magnets[i]);
  return result;
}

Points Magnets::dipole_positions(const std::vector<MagneticBody>& magnets) const {
  Points x(induced_.size(), 3);
  for (std::size_t k = 0; k < induced_.size(); ++k)
    x.row(k) = magnets[induced_[k]].pose.position.transpose();
  return x;
}

// Returns the flux density at the induced spheres, without the fields of these spheres [T]. Adds
// the fields of hard magnets to `magnetised.known`.
Points Magnets::applied_field(const Team& team, const std::vector<MagneticBody>& coils,
                              Magnetised& magnetised) const {
  const Points x = dipole_positions(magnetised.magnets);
  Points field = Points::Zero(induced_.size(), 3);
  for (const MagneticBody& body : hard(magnetised.magnets)) {
    magnetised.known.push_back({body, x, magnetic_field_and_gradient(team, body, x)});
    field += magnetised.known.back().there.field;
  }
  if (!coils.empty()) field += magnetic_field(team, coils, x, "B");
  field.rowwise() += model_.field.transpose();
  return field;
}

// Magnetises the induced magnets, none of which may be treated as a point dipole. Magnets with
// explicit response (Magnet::response) neither magnetise other induced magnets nor are magnetised
// by them.
void Magnets::magnetise_bodies(const Team& team, const std::vector<MagneticBody>& coils,
                               Magnetised& magnetised) const {
  std::vector<MagneticBody>& magnets = magnetised.magnets;
  std::vector<MagneticBody> by = hard(magnets);
  by.insert(by.end(), coils.begin(), coils.end());
  std::vector<SoftBody> mutual;
  std::vector<Index> rows;
  for (const Index i : induced_) {
    const CarriedMagnet& magnet = model_.magnets[i];
    const SoftBody body{magnet.soft, magnets[i].pose, magnet.saturation};
    if (magnet.cells.rows() > 0) {
      magnets[i] = explicit_response(body, magnet.cells, by, model_.field);
      continue;
    }
    mutual.push_back(body);
    rows.push_back(i);
  }
  if (mutual.empty()) return;
  const Induction induced =
      induce(team, mutual, by, model_.field, share_of_tolerance * model_.tolerance);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    magnets[rows[k]] = induced.bodies[k];
    magnetised.saturation_energy += saturation_energy(mutual[k], induced.susceptibilities[k]);
  }
}

void Magnets::magnetise_dipoles(const Team& team, const std::vector<MagneticBody>& coils,
                                Magnetised& magnetised) const {
  const Points x = dipole_positions(magnetised.magnets);
  magnetised.moments =
      induced_moments(team, x, polarizabilities_, applied_field(team, coils, magnetised),
                      share_of_tolerance * model_.tolerance, magnetised.moments);
  for (std::size_t k = 0; k < induced_.size(); ++k) {
    MagneticBody& body = magnetised.magnets[induced_[k]];
    body.source =
        std::make_shared<DipoleSet>(Points::Zero(1, 3), Points(magnetised.moments.row(k)));
    body.pose.orientation = Vec4(1, 0, 0, 0);
  }
}

Magnetised Magnets::at(const Team& team, const CarrierPlaces& places,
                       const std::vector<MagneticBody>& coils, const Points& moments) const {
  Magnetised magnetised{{}, {}, moments};
  for (const CarriedMagnet& magnet : model_.magnets)
    magnetised.magnets.push_back({magnet.source, places.pose(magnet.carrier, magnet.local)});
  if (induced_.empty()) return magnetised;
  if (soft_)
    magnetise_bodies(team, coils, magnetised);
  else
    magnetise_dipoles(team, coils, magnetised);
  return magnetised;
}

CarrierWrenches Magnets::wrenches(const Team& team, const CarrierPlaces& places,
                                  const Magnetised& magnetised) const {
  const std::vector<MagneticBody>& magnets = magnetised.magnets;
  const std::vector<Wrench> each =
      magnetic_wrenches(team, magnets, model_.tolerance, groups_, magnetised.known);
  const Points centres = places.centres();
  CarrierWrenches result(centres.rows());
  for (std::size_t i = 0; i < magnets.size(); ++i) {
    const Index carrier = model_.magnets[i].carrier;
    const Vec3 arm = magnets[i].pose.position - centres.row(carrier).transpose();
    result[carrier].force += each[i].force;
    result[carrier].torque += each[i].torque + arm.cross(each[i].force);
    result[carrier].torque += magnets[i].moment().cross(model_.field);
    result[carrier].error += each[i].error;
  }
  return result;
}

// Sums the energies of hard magnets in the uniform field and in the fields of hard magnets of other
// groups, and the energies of induced magnets in the field of hard magnets and the uniform field.
// An induced magnet has half the energy of a hard magnet with the same moment, because the other
// half is stored in its magnetisation. Bodies with saturation store a different part, which
// Magnetised::saturation_energy takes into account.
double Magnets::energy(const Team& team, const Magnetised& magnetised) const {
  const std::vector<MagneticBody>& magnets = magnetised.magnets;
  const std::vector<MagneticBody> hard = this->hard(magnets);
  std::vector<Index> groups;
  double total = 0.0;
  for (const Index i : hard_) {
    groups.push_back(groups_[i]);
    total -= magnets[i].moment().dot(model_.field);
  }
  total += magnetic_energy(team, hard, model_.tolerance, groups);
  if (induced_.empty()) return total;
  if (soft_) {
    for (const Index i : induced_) {
      total -= 0.5 * magnets[i].moment().dot(model_.field);
      for (const MagneticBody& by : hard)
        total += 0.5 * magnetic_energy(by, magnets[i], model_.tolerance);
    }
    return total + magnetised.saturation_energy;
  }
  for (std::size_t k = 0; k < induced_.size(); ++k) {
    Vec3 applied = model_.field;
    for (const KnownField& field : magnetised.known)
      applied += field.there.field.row(k).transpose();
    total -= 0.5 * magnets[induced_[k]].moment().dot(applied);
  }
  return total;
}

std::vector<MagneticBody> shown_magnets(const Team& team, const MagneticModel& model,
                                        const CarrierPlaces& places, const Vector& currents) {
  const std::vector<MagneticBody> coils = carrying_coils(model, places, currents);
  std::vector<MagneticBody> magnets = Magnets(model).at(team, places, coils).magnets;
  for (std::size_t i = 0; i < magnets.size(); ++i) {
    if (model.magnets[i].source || model.magnets[i].soft) continue;
    const double radius = model.magnets[i].radius;  // of a sphere treated as a point dipole [m]
    const Vec3 polarization =
        mu0 / (4.0 / 3.0 * pi * radius * radius * radius) * magnets[i].moment();
    magnets[i].source = std::make_shared<Sphere>(radius, polarization);
  }
  magnets.insert(magnets.end(), coils.begin(), coils.end());
  return magnets;
}

}  // namespace loomstone
