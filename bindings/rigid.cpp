// Rigid bodies as the user describes them, and their mass.
#include "core/rigid/rigid_body.h"

#include "bindings/descriptions.h"

namespace loomstone {

void bind_rigid(py::module_& m) {
  bind_description<RigidBody>(m, "RigidBody",
                              "A solid body that moves, falls, and feels the cloth.");
  py::class_<MassProperties> c(m, "MassProperties",
                               "Mass, centre and inertia of a closed mesh of uniform density.");
  c.def_readonly("mass", &MassProperties::mass, "[kg]");
  c.def_readonly("centre", &MassProperties::centre, "(3) in the mesh's frame [m]");
  c.def_readonly("inertia", &MassProperties::inertia,
                 "(3 x 3) about the centre, mesh axes [kg m^2]");
  c.def("__repr__", [](const MassProperties& self) {
    return "MassProperties(mass=" + py::str(py::cast(self.mass)).cast<std::string>() +
           ", centre=" + py::str(py::cast(self.centre).attr("tolist")()).cast<std::string>() + ")";
  });
  m.def(
      "mass_properties",
      [](const TriangleMesh& mesh, In<"kg/m^3"> density) { return mass_properties(mesh, density); },
      py::arg("mesh"), py::arg("density"),
      "MassProperties of a closed mesh at a density [kg/m^3]; InvalidInput when open or inside "
      "out.");
}

}  // namespace loomstone
