// Binds magnetisable bodies, whose magnetisation is induced by the field around them.
#include "bindings/descriptions.h"
#include "bindings/recipes.h"
#include "core/base/message.h"
#include "core/magnetics/induction/linear_magnetization.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/team.h"

namespace loomstone {

namespace {

SoftBody soft_body(SoftShapePtr shape, double saturation, const RigidPose& pose = {}) {
  if (!(saturation >= 0.0) || !std::isfinite(saturation))
    fail<InvalidInput>("saturation must be >= 0 [T], got {}", saturation);
  if (saturation > 0.0 && !(shape->susceptibility() > 0.0))
    fail<InvalidInput>("saturation must be 0 [T] unless susceptibility is > 0, got {}", saturation);
  return {std::move(shape), pose, saturation};
}

// Returns a copy of a body with the given susceptibility.
SoftBody with_susceptibility(const SoftBody& b, double susceptibility) {
  check_susceptibility(susceptibility);
  const py::gil_scoped_release release;
  return soft_body(b.shape->with_susceptibility(susceptibility), b.saturation, b.pose);
}

// Binds the methods that return copies of a body with another pose or susceptibility.
void bind_copies(py::class_<SoftBody>& c) {
  c.def(
      "at",
      [](const SoftBody& b, const py::object& position, const py::object& orientation) {
        const RigidPose pose = checked_pose(as_vector<Vec3>(position, {"position", "m"}),
                                            as_vector<Vec4>(orientation, "orientation"));
        return SoftBody{b.shape, pose, b.saturation};
      },
      py::arg("position"), py::arg("orientation") = py::make_tuple(1.0, 0.0, 0.0, 0.0),
      "Returns a copy with centre (3) [m] and quaternion (w, x, y, z), which is normalised.");
  c.def("with_susceptibility", &with_susceptibility, py::arg("susceptibility"),
        "Returns a copy with another susceptibility >= -1 [1]. Results that depend on the shape "
        "only are reused.");
  c.def(
      "moved",
      [](const SoftBody& b, const py::object& by) {
        return SoftBody{
            b.shape,
            checked_pose(b.pose.position + as_vector<Vec3>(by, {"by", "m"}), b.pose.orientation),
            b.saturation};
      },
      py::arg("by"), "Returns a copy displaced by a vector (3) [m].");
  c.def(
      "rotated",
      [](const SoftBody& b, const py::object& by) {
        const Vec4 turn = quaternion_from_rotation_vector(as_vector<Vec3>(by, {"by", "rad"}));
        return SoftBody{b.shape,
                        checked_pose(b.pose.position, quaternion_product(turn, b.pose.orientation)),
                        b.saturation};
      },
      py::arg("by"),
      "Returns a copy rotated about its own centre by a rotation vector (3) in world axes [rad].");
}

void bind_soft_body(py::module_& m) {
  py::class_<SoftBody> c(
      m, "SoftBody",
      "Body at a pose that is magnetised by the field around it. Immutable; created by the "
      "functions soft_... of\n"
      "loomstone.magnetics.");
  c.def_property_readonly(
      "position", [](const SoftBody& b) { return b.pose.position; }, "(3) centre [m]");
  c.def_property_readonly(
      "orientation", [](const SoftBody& b) { return b.pose.orientation; },
      "(4) quaternion (w, x, y, z) from body axes to world axes");
  c.def_property_readonly(
      "susceptibility", [](const SoftBody& b) { return b.shape->susceptibility(); },
      "susceptibility chi [1]");
  c.def_property_readonly(
      "saturation", [](const SoftBody& b) { return b.saturation; },
      "saturation polarization mu0 M_s [T]; 0: no saturation");
  c.def_property_readonly(
      "volume", [](const SoftBody& b) { return b.shape->volume(); }, "volume of the body [m^3]");
  c.def(
      "__eq__", [](const SoftBody& a, const SoftBody& b) { return equal(a, b); },
      py::is_operator());
  c.def(py::pickle(
      [](const SoftBody& b) {
        return py::make_tuple(state_of(b.shape->recipe()), b.pose.position, b.pose.orientation,
                              b.saturation);
      },
      [](const py::tuple& state) {
        const SourceRecipe recipe = recipe_of(state[0].cast<py::tuple>());
        return SoftBody{make_soft_shape(team_of(0), recipe), pose_of(state, 1),
                        state[3].cast<double>()};
      }));
  c.def("__repr__", [](const SoftBody& b) {
    const auto position = py::str(py::cast(b.pose.position).attr("tolist")());
    return "SoftBody(" + b.shape->recipe().kind + ", position=" + position.cast<std::string>() +
           " m, susceptibility=" +
           py::repr(py::cast(b.shape->susceptibility())).cast<std::string>() + ")";
  });
  bind_copies(c);
}

void bind_shapes(py::module_& m) {
  m.def(
      "soft_sphere",
      [](double radius, double susceptibility, double saturation, int degree) {
        return soft_body(soft_sphere(radius, susceptibility, degree), saturation);
      },
      py::kw_only(), py::arg("radius"), py::arg("susceptibility"), py::arg("saturation") = 0.0,
      py::arg("degree") = 0);
  m.def(
      "soft_cuboid",
      [](const py::object& size, double susceptibility, double saturation, int cells, double focus,
         int threads) {
        const Vec3 edges = as_vector<Vec3>(size, "size");
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return soft_body(soft_cuboid(team, edges, susceptibility, cells, focus), saturation);
      },
      py::kw_only(), py::arg("size"), py::arg("susceptibility"), py::arg("saturation") = 0.0,
      py::arg("cells") = 16, py::arg("focus") = 0.0, py::arg("threads") = 0);
  m.def(
      "soft_cylinder",
      [](double radius, double height, double susceptibility, double inner_radius,
         double saturation, int cells, int threads) {
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return soft_body(soft_cylinder(team, radius, height, inner_radius, susceptibility, cells),
                         saturation);
      },
      py::kw_only(), py::arg("radius"), py::arg("height"), py::arg("susceptibility"),
      py::arg("inner_radius") = 0.0, py::arg("saturation") = 0.0, py::arg("cells") = 8,
      py::arg("threads") = 0);
  m.def(
      "soft_mesh",
      [](const TriangleMesh& mesh, double susceptibility, double saturation, int panels,
         int threads) {
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        const SoftMesh made = soft_mesh(team, mesh, susceptibility, panels);
        return soft_body(made.shape, saturation, made.pose);
      },
      py::arg("mesh"), py::kw_only(), py::arg("susceptibility"), py::arg("saturation") = 0.0,
      py::arg("panels") = 1500, py::arg("threads") = 0);
}

void bind_induced_fields(py::module_& m) {
  m.def(
      "induce",
      [](const std::vector<SoftBody>& soft, const std::vector<MagneticBody>& by,
         const py::object& field, double tolerance, int threads) {
        const Vec3 uniform = as_vector<Vec3>(field, "field");
        const Team team = team_of(threads);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < soft.size(); ++i) names.push_back(formatted("soft[{}]", i));
        for (std::size_t i = 0; i < by.size(); ++i) names.push_back(formatted("by[{}]", i));
        Induction result;
        {
          const py::gil_scoped_release release;
          check_apart(soft, by, names);
          result = induce(team, soft, by, uniform, tolerance);
        }
        return py::make_tuple(result.bodies, result.residual, result.iterations);
      },
      py::arg("soft"), py::arg("by"), py::arg("field"), py::arg("tolerance"),
      py::arg("threads") = 0);
  m.def(
      "explicit_response",
      [](const SoftBody& body, double density, const std::vector<MagneticBody>& by,
         const py::object& field) {
        return explicit_response(body, explicit_cells(*body.shape, density), by,
                                 as_vector<Vec3>(field, "field"));
      },
      py::arg("body"), py::arg("density"), py::arg("by"), py::arg("field"));
}

}  // namespace

void bind_soft_bodies(py::module_& m) {
  bind_soft_body(m);
  bind_shapes(m);
  bind_induced_fields(m);
}

}  // namespace loomstone
