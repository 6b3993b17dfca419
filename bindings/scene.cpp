// Descriptions: scenes, cloths, obstacles and their parts.
#include "core/sim/scene/scene.h"

#include "bindings/descriptions.h"

namespace loomstone {

void bind_scene(py::module_& m) {
  bind_description<ClothMaterial>(
      m, "ClothMaterial",
      "What a cloth is made of; axes 1 = weft, 2 = warp. A surface, so stiffness is in N/m.");
  bind_description<StrainLimit, 3>(m, "StrainLimit",
                                   "How far cloth may strain along weft, warp and in shear: U - I "
                                   "with F = R U, in weft/warp axes. The first three may be\n"
                                   "given without their names.");
  bind_description<LimitOptions>(m, "LimitOptions",
                                 "How strain limits are enforced, step by step.");
  bind_description<Cloth>(m, "Cloth", "A piece of cloth: mesh, material, and what holds it.");
  bind_description<Obstacle>(
      m, "Obstacle",
      "A surface that cloth cannot pass: static, moved by keyframes, or a vertex sequence.");
  bind_description<Attachment>(m, "Attachment",
                               "Ties cloth vertices to a rigid body, both ways. Implicit "
                               "integrators only: others refuse it (Unsupported).");
  bind_description<Magnet>(m, "Magnet",
                           "What makes a rigid body or an obstacle magnetic; give several for one "
                           "that carries several.");
  bind_description<Coil>(m, "Coil",
                         "A winding on a body or an obstacle, with a given current or a circuit.");
  bind_description<Bearing>(
      m, "Bearing", "Lets a rigid body turn about an axis through its centre, and nothing else.");
  bind_description<Air>(m, "Air", "Drag of air at rest or in wind, per triangle.");
  bind_description<Scene>(m, "Scene", "Everything a simulation starts from.");
}

}  // namespace loomstone
