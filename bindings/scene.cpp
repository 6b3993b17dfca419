// Binds the descriptions of scenes, cloths, obstacles and their parts.
#include "core/sim/scene/scene.h"

#include "bindings/descriptions.h"

namespace loomstone {

void bind_scene(py::module_& m) {
  bind_description<ClothMaterial>(m, "ClothMaterial",
                                  "Material of a cloth. Axis 1 is weft and axis 2 is warp. Cloth "
                                  "is a surface, so stiffness is in N/m.");
  bind_description<StrainLimit, 3>(
      m, "StrainLimit",
      "Limits of the strain U - I (F = R U) along weft, along warp and in shear. The first "
      "three fields may be\n"
      "given by position.");
  bind_description<LimitOptions>(m, "LimitOptions", "Options for enforcing strain limits.");
  bind_description<Cloth>(m, "Cloth", "A piece of cloth: mesh, material, pins and strain limits.");
  bind_description<Obstacle>(m, "Obstacle",
                             "A surface that cloth cannot pass. It is static, is moved by "
                             "keyframes, or is deformed by a vertex sequence.");
  bind_description<Attachment>(m, "Attachment",
                               "Two-way coupling that ties cloth vertices to a rigid body. It "
                               "needs an implicit or asynchronous integrator; others raise "
                               "Unsupported.");
  bind_description<Magnet>(m, "Magnet",
                           "A magnet or magnetisable body that is carried by a rigid body or an "
                           "obstacle, which may carry several.");
  bind_description<Coil>(m, "Coil",
                         "A winding on a body or an obstacle, with a given current or a circuit.");
  bind_description<Bearing>(m, "Bearing",
                            "Restricts a rigid body to rotation about an axis through its centre.");
  bind_description<Air>(m, "Air", "Aerodynamic drag on each triangle, in air at rest or in wind.");
  bind_description<Scene>(m, "Scene",
                          "Complete description of what is simulated, in its initial state.");
}

}  // namespace loomstone
