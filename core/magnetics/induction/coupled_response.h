// How linear bodies act on one another: what each receives from magnets and from the charge of the
// others, which is all that the equations of linear_magnetization.h need of geometry.
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
  // The bodies must outlive it; their poses stay, their susceptibilities may change.
  CoupledResponse(const Team& team, const std::vector<SoftBody>& soft);

  // From magnets and a uniform field; applied: of bodies of panels, the field within each panel.
  std::vector<Vector> received(const std::vector<MagneticBody>& hard, const Vec3& field,
                               std::vector<AppliedField>& applied) const;

  // From the charge of all other bodies: between panels by fluxes, between spheres on a common axis
  // by translation of their harmonics, otherwise by the field.
  std::vector<Vector> received(const std::vector<Vector>& charges) const;

  // The bodies as sources with their charges; applied: charge of panels varies within them as the
  // applied field does.
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
  // By target and source.
  std::map<std::pair<std::size_t, std::size_t>, CoaxialTranslation> coaxial_;
  std::map<std::pair<std::size_t, std::size_t>, FluxMatrix> fluxes_;
};

}  // namespace loomstone
