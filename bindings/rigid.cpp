// Binds the description of rigid bodies, and the mass properties of bodies and meshes.
#include "core/rigid/rigid_body.h"

#include "bindings/descriptions.h"

namespace loomstone {

void bind_rigid(py::module_& m) {
  bind_description<RigidBody>(m, "RigidBody",
                              "A rigid body that moves under gravity, contact and other forces, in "
                              "two-way coupling with cloth.");
  py::class_<MassProperties> c(
      m, "MassProperties",
      "Mass, centre of mass and inertia of a closed mesh with uniform density.");
  c.def_readonly("volume", &MassProperties::volume, "volume of the mesh [m^3]");
  c.def_readonly("mass", &MassProperties::mass, "mass of the body [kg]");
  c.def_readonly("centre", &MassProperties::centre, "(3) centre of mass in mesh coordinates [m]");
  c.def_readonly("inertia", &MassProperties::inertia,
                 "(3 x 3) inertia about the centre of mass, in mesh axes [kg m^2]");
  c.def("__repr__", [](const MassProperties& self) {
    return "MassProperties(mass=" + py::str(py::cast(self.mass)).cast<std::string>() +
           ", centre=" + py::str(py::cast(self.centre).attr("tolist")()).cast<std::string>() + ")";
  });
  m.def(
      "mass_properties",
      [](const TriangleMesh& mesh, In<"kg/m^3"> density) { return mass_properties(mesh, density); },
      py::arg("mesh"), py::arg("density"),
      "Returns the MassProperties of a closed mesh with a uniform density [kg/m^3]. Raises "
      "InvalidInput if the mesh is open or inside out.");
  m.def(
      "mass_properties", [](const RigidBody& body) { return mass_properties(body); },
      py::arg("body"), "Returns the MassProperties of a RigidBody with a mesh.");
}

}  // namespace loomstone
