// Coupling of linear bodies: the excitation of each body by magnets, currents and a uniform field
// (applied_i in the equations of linear_magnetization.h) and by the charge of the other linear
// bodies (the sum of G_ij x_j).
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "core/magnetics/induction/applied_field.h"
#include "core/magnetics/induction/mutual_fluxes.h"
#include "core/magnetics/induction/soft_shape.h"
#include "core/magnetics/sources/spherical_harmonics.h"

namespace loomstone {

class CoupledResponse {
 public:
  // Keeps references to both arguments. The susceptibilities of the bodies may change afterwards,
  // but their poses must not.
  CoupledResponse(const Team& team, const std::vector<SoftBody>& soft);

  // Returns the excitation of each body (fluxes through its panels, or coefficients of a sphere's
  // harmonics) by the sources `hard` and the uniform flux density `field` [T]. For a body i made of
  // panels, applied[i] is set to the applied field on its panels.
  std::vector<Vector> received(const std::vector<MagneticBody>& hard, const Vec3& field,
                               std::vector<AppliedField>& applied) const;

  // Returns the excitation of the body `target` by the charges of all other bodies. Pairs of bodies
  // with panels use MutualFluxes. Spheres with a common z axis use translations of their harmonics.
  // For other pairs, the field is evaluated at the samples of the target.
  Vector received(std::size_t target, const std::vector<Vector>& charges) const;

  // Returns the bodies as sources with given charges. In bodies with panels, a part of the charge
  // is induced by the applied field, and another part by other charges. Within a panel, the first
  // part varies as the applied field does.
  std::vector<MagneticBody> placed(const std::vector<Vector>& charges,
                                   const std::vector<AppliedField>& applied) const;

 private:
  void add_coaxial(std::size_t target, std::size_t source);
  void add_fluxes(std::size_t target, std::size_t source);

  const Team& team_;
  const std::vector<SoftBody>& soft_;
  std::vector<Points> world_;  // world positions of each body's samples [m]
  std::vector<Mat3> rotations_;
  // The keys are pairs (target, source) of body indices.
  std::map<std::pair<std::size_t, std::size_t>, CoaxialTranslation> coaxial_;
  std::map<std::pair<std::size_t, std::size_t>, MutualFluxes> fluxes_;
};

}  // namespace loomstone
