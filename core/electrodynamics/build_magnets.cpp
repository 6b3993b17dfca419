// Builds and checks the magnets on bodies and obstacles.
#include <algorithm>
#include <string>

#include "core/base/message.h"
#include "core/electrodynamics/build.h"
#include "core/magnetics/fast_sums/expanded_mesh.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/induction/induced_dipoles.h"
#include "core/magnetics/induction/linear_magnetization.h"
#include "core/magnetics/sources/polyhedron.h"

namespace loomstone {

namespace {

void carry_hard(const MagneticBody& magnet, const std::string& where, CarriedMagnet& carried) {
  const Source& source = *magnet.source;
  const std::string kind = source.recipe().kind;
  require(!kind.empty(),
          "{} must be a magnet, got the magnetised state of a body; give the body that magnetises "
          "(soft_...) itself",
          where);
  require(kind != "loop" && kind != "solenoid" && kind != "polyline",
          "{} must be a magnet, got a {}; give loops and solenoids as Coil", where, kind);
  const DipoleSet* dipoles = source.dipoles();
  require(dipoles ? !dipoles->moments().isZero(0.0) : !source.moment().isZero(0.0),
          "{} must have a moment other than zero [A m^2]; leave the magnet out", where);
  carried.source = magnet.source;
}

// Sets the data of a body that the field magnetises. A sphere is treated as a point dipole if its
// solid harmonics have degree 1 or their degree is automatic (0), unless it can saturate or has an
// explicit response (Magnet::response). add_magnets() undoes this unless all magnetisable bodies
// are such spheres.
void carry_soft(const Magnet& magnet, const std::string& where, CarriedMagnet& carried) {
  const SoftBody& body = std::get<SoftBody>(magnet.source);
  const bool cells = magnet.response == "explicit";
  carried.soft = body.shape;
  carried.saturation = body.saturation;
  const int degree = body.shape->sphere_degree();
  if (degree >= 0) {
    const double chi = body.shape->susceptibility();
    carried.radius = body.shape->radius();
    carried.polarizability = sphere_polarizability(carried.radius, chi);
    if (degree == 0) carried.soft = soft_sphere(carried.radius, chi, 1);
    if (degree <= 1 && !cells && body.saturation == 0.0) carried.soft = nullptr;
  }
  if (!cells) return;
  try {
    carried.cells = explicit_cells(*body.shape, magnet.density);
  } catch (const InvalidInput& error) {
    fail<InvalidInput>("{}.{}", where, error.what());
  }
}

void check_response(const Magnet& magnet, const std::string& where) {
  const auto* soft = std::get_if<SoftBody>(&magnet.source);
  const bool cells = magnet.response == "explicit";
  require(cells || magnet.response == "mutual",
          "{}.response must be mutual or explicit, got \"{}\"", where, magnet.response);
  require(!cells || soft,
          "{}.response must be mutual for a permanent magnet, got explicit; leave it out", where);
  require(!cells || soft->saturation == 0.0,
          "{}.response must be mutual with a saturation, got explicit; change one of them", where);
  require(cells || magnet.density == 0.0,
          "{}.density must be 0 [1/m^3] without the explicit response, got {}; leave it out", where,
          magnet.density);
  require(!cells || magnet.density > 0.0,
          "{}.density must be > 0 [1/m^3] with the explicit response, got {}; 8e6 makes eight "
          "cells per cubic centimetre",
          where, magnet.density);
}

// Replaces the exact field of each magnet made of a mesh or of cells by an expansion if evaluating
// the field at all magnetisable spheres is expensive. Does nothing if the scene has magnetisable
// bodies that are not treated as point dipoles, or if expansions cannot meet the tolerance. An
// expansion saves time only if many evaluations follow.
void expand_fields(MagneticModel& model) {
  constexpr std::size_t most_exact = 20000, few_spheres = 100;
  constexpr Index few_cells = 1000;
  const double tolerance = 0.3 * model.tolerance;
  if (tolerance < 3e-7) return;
  std::size_t n_spheres = 0;
  for (const CarriedMagnet& carried : model.magnets) {
    if (carried.soft) return;
    n_spheres += !carried.source;
  }
  for (CarriedMagnet& carried : model.magnets) {
    const auto mesh = std::dynamic_pointer_cast<const MeshMagnet>(carried.source);
    const auto cells = std::dynamic_pointer_cast<const CellMagnet>(carried.source);
    if (mesh && n_spheres * mesh->triangles().rows() > most_exact)
      carried.source = std::make_shared<ExpandedMesh>(mesh, tolerance);
    else if (cells && n_spheres >= few_spheres && cells->dipoles()->positions().rows() >= few_cells)
      carried.source = std::make_shared<CellMagnet>(cells->expanded(tolerance));
  }
}

}  // namespace

void add_magnets(const MagneticScene& scene, MagneticModel& model) {
  for (std::size_t i = 0; i < scene.magnets.size(); ++i) {
    const Magnet& magnet = scene.magnets[i];
    const std::string where = formatted("magnets[{}]", i);
    check_fields(magnet, where);
    const auto* hard = std::get_if<MagneticBody>(&magnet.source);
    const auto* soft = std::get_if<SoftBody>(&magnet.source);
    require(hard || soft,
            "{}.source must be a magnet or a body that magnetises, got none; "
            "magnetics.mesh(mesh, polarization=...) takes the body's own shape",
            where);
    check_response(magnet, where);
    const Stand stand =
        find_stand(scene, magnet.body, hard ? hard->pose : soft->pose, where + ".body");
    CarriedMagnet carried;
    carried.carrier = stand.carrier;
    carried.local = stand.local;
    if (hard)
      carry_hard(*hard, where + ".source", carried);
    else
      carry_soft(magnet, where, carried);
    model.magnets.push_back(std::move(carried));
  }
  const auto panels = [](const CarriedMagnet& carried) { return carried.soft != nullptr; };
  if (std::any_of(model.magnets.begin(), model.magnets.end(), panels)) {
    for (std::size_t i = 0; i < model.magnets.size(); ++i) {
      CarriedMagnet& carried = model.magnets[i];
      if (!carried.source && !carried.soft)
        carried.soft = soft_sphere(
            carried.radius, std::get<SoftBody>(scene.magnets[i].source).shape->susceptibility(), 1);
    }
  }
  expand_fields(model);
}

double pole_at(const MagneticModel& model, Index carrier, const Vec3& point) {
  // `nearest` is the smallest ratio so far: the distance of `point` from a magnet, divided by the
  // radius of the magnet's bounding sphere. The limit 1.3 includes points on a body that closely
  // encloses its magnet.
  double nearest = 1.3, pole = 0.0;
  for (const CarriedMagnet& magnet : model.magnets) {
    if (magnet.carrier != carrier || !magnet.source || magnet.source->moment().isZero(0.0))
      continue;
    const Vec3 arm = point - magnet.local.position;
    const double radius = magnet.source->radius() > 0.0 ? magnet.source->radius() : arm.norm();
    if (arm.norm() >= nearest * radius) continue;
    nearest = arm.norm() / radius;
    pole = (rotation_matrix(magnet.local.orientation) * magnet.source->moment())
               .normalized()
               .dot(arm) /
           radius;
  }
  return pole;
}

void check_magnets(const MagneticModel& model, const CarrierPlaces& start) {
  std::vector<SoftBody> soft;
  std::vector<MagneticBody> hard;
  std::vector<std::string> soft_names, hard_names;
  for (std::size_t i = 0; i < model.magnets.size(); ++i) {
    const CarriedMagnet& magnet = model.magnets[i];
    if (!magnet.source && !magnet.soft) continue;
    const RigidPose pose = start.pose(magnet.carrier, magnet.local);
    (magnet.soft ? soft_names : hard_names).push_back(formatted("magnets[{}]", i));
    if (magnet.soft)
      soft.push_back({magnet.soft, pose, magnet.saturation});
    else
      hard.push_back({magnet.source, pose});
  }
  soft_names.insert(soft_names.end(), hard_names.begin(), hard_names.end());
  check_apart(soft, hard, soft_names);
}

}  // namespace loomstone
