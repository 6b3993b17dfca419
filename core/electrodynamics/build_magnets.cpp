// Magnets on bodies and obstacles.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/electrodynamics/build.h"
#include "core/magnetics/fast_sums/expanded_mesh.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/induction/induced_dipoles.h"
#include "core/magnetics/induction/linear_magnetization.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/magnetics/sources/sphere.h"

namespace loomstone {

namespace {

void require(bool holds, const std::string& message) {
  if (!holds) throw InvalidInput(message);
}

// What a shape has no use for must keep its default: nothing given is passed over in silence.
void check_shape(const Magnet& magnet, const std::string& where) {
  const bool mesh = magnet.shape == "mesh", sphere = magnet.shape == "sphere",
             cuboid = magnet.shape == "cuboid", cylinder = magnet.shape == "cylinder",
             dipole = magnet.shape == "dipole";
  require(mesh || sphere || cuboid || cylinder || dipole,
          where + ".shape must be mesh, sphere, cuboid, cylinder or dipole, got \"" + magnet.shape +
              "\"");
  const auto only = [&](bool given, bool wanted, const char* name) {
    require(!given || wanted, where + "." + name + " means nothing to a magnet of shape " +
                                  magnet.shape + "; leave it out");
  };
  only(magnet.mesh != nullptr, mesh, "mesh");
  only(!magnet.size.isZero(0.0), cuboid, "size");
  only(magnet.radius != 0.0, sphere || cylinder, "radius");
  only(magnet.inner_radius != 0.0, cylinder, "inner_radius");
  only(magnet.height != 0.0, cylinder, "height");
  only(!magnet.polarization.isZero(0.0), !dipole, "polarization");
  only(!magnet.moment.isZero(0.0), dipole, "moment");
  require(magnet.polarization.allFinite(), where + ".polarization must be finite [T]");
  require(magnet.moment.allFinite(), where + ".moment must be finite [A m^2]");
  const bool induced = magnet.susceptibility != 0.0;
  require(
      !induced || magnet.polarization.isZero(0.0),
      where + ".polarization must be zero where susceptibility is given: a magnet is hard or soft");
  if (induced && dipole)
    throw Unsupported(where + ".susceptibility is that of bodies with a volume, got shape dipole");
  require(!induced || magnet.engine == "accurate",
          where + ".engine must be accurate with a susceptibility");
  const bool cells = magnet.response == "explicit";
  require(
      magnet.focus == 0.0 || (induced && cuboid && !cells),
      where + ".focus belongs to cuboids with a susceptibility and response mutual; leave it out");
  require(cells || magnet.response == "mutual",
          where + ".response must be mutual or explicit, got \"" + magnet.response + "\"");
  require(
      induced || (!cells && magnet.saturation == 0.0 && magnet.resolution == 0),
      where + ".response, saturation and resolution belong to a susceptibility; leave them out");
  if (magnet.resolution != 0 && (cuboid || cylinder))
    check_cells(magnet.resolution, magnet.shape, where + ".resolution");
  require(magnet.saturation == 0.0 || (magnet.susceptibility > 0.0 && !cells),
          where + ".saturation must be 0 [T] unless susceptibility is > 0 and response mutual");
  require(!cells || magnet.resolution == 0,
          where + ".resolution belongs to the mutual response; leave it out");
  require(induced || !magnet.polarization.isZero(0.0) || !magnet.moment.isZero(0.0),
          where +
              (dipole ? ".moment must not be zero [A m^2]" : ".polarization must not be zero [T]") +
              "; leave the magnet out");
  require(magnet.position.allFinite(), where + ".position must be finite [m]");
  require(std::abs(magnet.orientation.norm() - 1.0) < 1e-6,
          where + ".orientation must be a unit quaternion (w, x, y, z), got length " +
              std::to_string(magnet.orientation.norm()));
  require(magnet.engine == "accurate" || magnet.engine == "cells",
          where + ".engine must be accurate or cells, got \"" + magnet.engine + "\"");
  require(magnet.engine == "cells" || cells || magnet.density == 0.0,
          where + ".density belongs to engine cells and to the explicit response; leave it out");
  require((magnet.engine != "cells" && !cells) || magnet.density > 0.0,
          where + ".density must be > 0 [1/m^3] for cells; 8e6 is eight cells a cubic centimetre");
  require(magnet.engine != "cells" || !dipole,
          where + ".engine must be accurate for a dipole, which has no cells");
}

// The source about its own centre, whose place in the frame of the carrier's mesh is added to
// `pose`.
SourcePtr source_of(const Magnet& magnet, const TriangleMesh& carrier, RigidPose& pose) {
  if (magnet.shape == "sphere") return std::make_shared<Sphere>(magnet.radius, magnet.polarization);
  if (magnet.shape == "cuboid") return std::make_shared<Cuboid>(magnet.size, magnet.polarization);
  if (magnet.shape == "cylinder")
    return std::make_shared<Cylinder>(magnet.radius, magnet.height, magnet.polarization,
                                      magnet.inner_radius);
  if (magnet.shape == "dipole")
    return std::make_shared<DipoleSet>(Points::Zero(1, 3), Points(magnet.moment.transpose()));
  const MagneticBody body =
      make_mesh_magnet(magnet.mesh ? *magnet.mesh : carrier, magnet.polarization);
  pose.position += rotation_matrix(pose.orientation) * body.pose.position;
  return body.source;
}

void carry_hard(const Magnet& magnet, const TriangleMesh& carrier, CarriedMagnet& carried) {
  carried.source = source_of(magnet, carrier, carried.local);
  if (magnet.engine == "cells")
    carried.source = std::make_shared<CellMagnet>(*carried.source, magnet.density, 3.0);
}

// A body that magnetises: spheres as point dipoles unless something more is asked for.
void carry_soft(const Magnet& magnet, const TriangleMesh& carrier, CarriedMagnet& carried) {
  const Team one;
  const double chi = magnet.susceptibility;
  const bool cells = magnet.response == "explicit";
  carried.saturation = magnet.saturation;
  if (magnet.shape == "sphere") {
    carried.soft = soft_sphere(magnet.radius, chi, std::max(magnet.resolution, 1));  // checks
    carried.radius = magnet.radius;
    carried.polarizability = sphere_polarizability(magnet.radius, chi);
    if (magnet.resolution <= 1 && !cells && magnet.saturation == 0.0) carried.soft = nullptr;
  } else if (magnet.shape == "cuboid") {
    carried.soft = soft_cuboid(one, magnet.size, chi,
                               magnet.resolution == 0 ? 8 : magnet.resolution, magnet.focus);
  } else if (magnet.shape == "cylinder") {
    carried.soft = soft_cylinder(one, magnet.radius, magnet.height, magnet.inner_radius, chi,
                                 magnet.resolution == 0 ? 8 : magnet.resolution);
  } else {
    const SoftMesh made = soft_mesh(one, magnet.mesh ? *magnet.mesh : carrier, chi,
                                    magnet.resolution == 0 ? 500 : magnet.resolution);
    carried.soft = made.shape;
    carried.local.position += rotation_matrix(carried.local.orientation) * made.pose.position;
  }
  if (cells) carried.cells = explicit_cells(*carried.soft, magnet.density);
}

// Where many spheres are in the field of many faces or cells, the field is expanded once: that
// takes as long as some twenty evaluations of all faces at this bound, and as 1,400 of all cells
// for 100 spheres, however many cells.
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
    const std::string where = "magnets[" + std::to_string(i) + "]";
    check_fields(magnet, where);
    check_shape(magnet, where);
    const RigidPose in_mesh{magnet.position, magnet.orientation.normalized()};
    const Stand stand = find_stand(scene, magnet.body, in_mesh, where + ".body");
    const TriangleMesh& mesh = *scene.carriers[stand.carrier].mesh;
    CarriedMagnet carried;
    carried.carrier = stand.carrier;
    carried.local = stand.local;
    try {
      if (magnet.susceptibility != 0.0)
        carry_soft(magnet, mesh, carried);
      else
        carry_hard(magnet, mesh, carried);
    } catch (const InvalidInput& error) {
      throw InvalidInput(where + "." + error.what());
    }
    model.magnets.push_back(std::move(carried));
  }
  const auto panels = [](const CarriedMagnet& carried) { return carried.soft != nullptr; };
  if (std::any_of(model.magnets.begin(), model.magnets.end(), panels)) {
    for (std::size_t i = 0; i < model.magnets.size(); ++i) {
      CarriedMagnet& carried = model.magnets[i];
      if (!carried.source && !carried.soft)
        carried.soft = soft_sphere(carried.radius, scene.magnets[i].susceptibility, 1);
    }
  }
  expand_fields(model);
}

double pole_at(const MagneticModel& model, Index carrier, const Vec3& point) {
  double nearest = 1.3,
         pole = 0.0;  // a little beyond the ball that holds the magnet, for what encloses it
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
    (magnet.soft ? soft_names : hard_names).push_back("magnets[" + std::to_string(i) + "]");
    if (magnet.soft)
      soft.push_back({magnet.soft, pose, magnet.saturation});
    else
      hard.push_back({magnet.source, pose});
  }
  soft_names.insert(soft_names.end(), hard_names.begin(), hard_names.end());
  check_apart(soft, hard, soft_names);
}

}  // namespace loomstone
