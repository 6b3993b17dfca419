// The coupling of linear bodies: the field that each receives from magnets and from the charge of
// the others. It contains all geometry that the equations of linear_magnetization.h need.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "core/magnetics/induction/applied_field.h"
#include "core/magnetics/induction/soft_shape.h"
#include "core/magnetics/sources/charged_panels.h"
#include "core/magnetics/sources/spherical_harmonics.h"

namespace loomstone {

class CoupledResponse {
 public:
  // Refers to the bodies: their susceptibilities may change afterwards, their poses must not.
  CoupledResponse(const Team& team, const std::vector<SoftBody>& soft);

  // Received from magnets and a uniform field. applied: receives the field within panels, for
  // bodies made of panels.
  std::vector<Vector> received(const std::vector<MagneticBody>& hard, const Vec3& field,
                               std::vector<AppliedField>& applied) const;

  // Received from the charge of all other bodies: between panels by fluxes, between spheres on a
  // common axis by translation of their harmonics, otherwise by the field.
  std::vector<Vector> received(const std::vector<Vector>& charges) const;

  // The bodies as sources with given charges. With `applied`, the charge varies within panels as
  // the applied field does.
  std::vector<MagneticBody> placed(const std::vector<Vector>& charges) const;
  std::vector<MagneticBody> placed(const std::vector<Vector>& charges,
                                   const std::vector<AppliedField>& applied) const;

 private:
  void add_coaxial(std::size_t target, std::size_t source);
  void add_fluxes(std::size_t target, std::size_t source);

  const Team& team_;
  const std::vector<SoftBody>& soft_;
  std::vector<Points> world_;  // samples of each body [m]
  std::vector<Mat3> rotations_;
  // Keys: target, source.
  std::map<std::pair<std::size_t, std::size_t>, CoaxialTranslation> coaxial_;
  std::map<std::pair<std::size_t, std::size_t>, FluxMatrix> fluxes_;
};

}  // namespace loomstone
