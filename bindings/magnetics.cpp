// Binds magnets and currents at given poses, with their fields, potentials, field lines, forces,
// energies and inductances. Also binds the moments that fields induce in spheres, and the cells
// into which magnets are divided.
#include <optional>

#include "bindings/descriptions.h"
#include "bindings/recipes.h"
#include "core/base/message.h"
#include "core/magnetics/fast_sums/treecode.h"
#include "core/magnetics/field_lines/field_lines.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/forces/charge_error.h"
#include "core/magnetics/forces/overlap.h"
#include "core/magnetics/induction/induced_dipoles.h"
#include "core/magnetics/induction/mutual_inductance.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/magnetics/sources/sphere.h"
#include "core/parallel/team.h"

namespace loomstone {

namespace {

MagneticBody at_origin(SourcePtr source) { return {std::move(source), {}}; }

py::array_t<double> as_tensors(const Gradients& rows) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(rows.rows()), py::ssize_t{3}, py::ssize_t{3}});
  std::copy_n(rows.data(), rows.size(), array.mutable_data());
  return array;
}

void bind_body(py::module_& m) {
  py::class_<MagneticBody> c(
      m, "MagneticBody",
      "Magnet or current at a pose. Immutable; created by the functions of loomstone.magnetics.");
  c.def_property_readonly(
      "position", [](const MagneticBody& b) { return b.pose.position; }, "(3) centre [m]");
  c.def_property_readonly(
      "orientation", [](const MagneticBody& b) { return b.pose.orientation; },
      "(4) quaternion (w, x, y, z) from body axes to world axes");
  c.def_property_readonly("moment", &MagneticBody::moment,
                          "(3) dipole moment in world axes [A m^2]");
  c.def_property_readonly(
      "radius", [](const MagneticBody& b) { return b.source->radius(); },
      "radius of a ball about the centre that contains the body [m]");
  c.def(
      "at",
      [](const MagneticBody& b, const py::object& position, const py::object& orientation) {
        return MagneticBody{b.source, checked_pose(as_vector<Vec3>(position, {"position", "m"}),
                                                   as_vector<Vec4>(orientation, "orientation"))};
      },
      py::arg("position"), py::arg("orientation") = py::make_tuple(1.0, 0.0, 0.0, 0.0),
      "Returns a copy with centre (3) [m] and quaternion (w, x, y, z), which is normalised.");
  c.def(
      "moved",
      [](const MagneticBody& b, const py::object& by) {
        return MagneticBody{
            b.source,
            checked_pose(b.pose.position + as_vector<Vec3>(by, {"by", "m"}), b.pose.orientation)};
      },
      py::arg("by"), "Returns a copy displaced by a vector (3) [m].");
  c.def(
      "rotated",
      [](const MagneticBody& b, const py::object& by) {
        const Vec4 turn = quaternion_from_rotation_vector(as_vector<Vec3>(by, {"by", "rad"}));
        return MagneticBody{
            b.source, checked_pose(b.pose.position, quaternion_product(turn, b.pose.orientation))};
      },
      py::arg("by"),
      "Returns a copy rotated about its own centre by a rotation vector (3) in world axes [rad].");
  c.def(
      "__eq__", [](const MagneticBody& a, const MagneticBody& b) { return equal(a, b); },
      py::is_operator());
  c.def(py::pickle(
      [](const MagneticBody& b) {
        return py::make_tuple(state_of(b.source->recipe()), b.pose.position, b.pose.orientation);
      },
      [](const py::tuple& state) {
        return MagneticBody{make_source(recipe_of(state[0].cast<py::tuple>())), pose_of(state, 1)};
      }));
  c.def("__repr__", [](const MagneticBody& b) {
    const auto text = [](const Vec3& v) {
      return py::str(py::tuple(py::cast(v).attr("tolist")())).cast<std::string>();
    };
    return "MagneticBody(position=" + text(b.pose.position) + " m, moment=" + text(b.moment()) +
           " A m^2)";
  });
}

void bind_sources(py::module_& m) {
  const auto vec = [](const py::object& o, const char* name) { return as_vector<Vec3>(o, name); };
  m.def(
      "magnetic_cuboid",
      [vec](const py::object& size, const py::object& polarization) {
        return at_origin(
            std::make_shared<Cuboid>(vec(size, "size"), vec(polarization, "polarization")));
      },
      py::kw_only(), py::arg("size"), py::arg("polarization"));
  m.def(
      "magnetic_cylinder",
      [vec](double radius, double height, const py::object& polarization, double inner_radius) {
        return at_origin(std::make_shared<Cylinder>(
            radius, height, vec(polarization, "polarization"), inner_radius));
      },
      py::kw_only(), py::arg("radius"), py::arg("height"), py::arg("polarization"),
      py::arg("inner_radius") = 0.0);
  m.def(
      "magnetic_sphere",
      [vec](double radius, const py::object& polarization) {
        return at_origin(std::make_shared<Sphere>(radius, vec(polarization, "polarization")));
      },
      py::kw_only(), py::arg("radius"), py::arg("polarization"));
  m.def(
      "magnetic_mesh",
      [vec](const TriangleMesh& mesh, const py::object& polarization) {
        return make_mesh_magnet(mesh, vec(polarization, "polarization"));
      },
      py::arg("mesh"), py::kw_only(), py::arg("polarization"));
  m.def(
      "magnetic_dipoles",
      [](const py::object& points, const py::object& moments) {
        return at_origin(std::make_shared<DipoleSet>(as_rows<Points>(points, "points"),
                                                     as_rows<Points>(moments, "moments")));
      },
      py::arg("points"), py::arg("moments"));
  m.def(
      "magnetic_loop",
      [](double radius, double turns, double current) {
        return at_origin(std::make_shared<Loop>(radius, current, turns));
      },
      py::kw_only(), py::arg("radius"), py::arg("turns") = 1.0, py::arg("current") = 1.0);
  m.def(
      "magnetic_solenoid",
      [](double radius, double length, double turns, double current) {
        return at_origin(std::make_shared<Solenoid>(radius, length, turns, current));
      },
      py::kw_only(), py::arg("radius"), py::arg("length"), py::arg("turns"),
      py::arg("current") = 1.0);
  m.def(
      "magnetic_polyline",
      [](const py::object& vertices, double current) {
        return make_polyline(as_rows<Points>(vertices, "vertices"), current);
      },
      py::arg("vertices"), py::kw_only(), py::arg("current"));
}

void bind_fields(py::module_& m) {
  m.def(
      "magnetic_field",
      [](const std::vector<MagneticBody>& bodies, const py::object& points,
         const std::string& quantity, int threads) {
        const Points x = as_rows<Points>(points, "points");
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return magnetic_field(team, bodies, x, quantity);
      },
      py::arg("bodies"), py::arg("points"), py::arg("quantity") = "B", py::arg("threads") = 0);
  m.def(
      "magnetic_gradient",
      [](const std::vector<MagneticBody>& bodies, const py::object& points, int threads) {
        const Points x = as_rows<Points>(points, "points");
        const Team team = team_of(threads);
        Gradients rows;
        {
          const py::gil_scoped_release release;
          rows = magnetic_gradient(team, bodies, x);
        }
        return as_tensors(rows);
      },
      py::arg("bodies"), py::arg("points"), py::arg("threads") = 0);
  m.def(
      "dipole_forces",
      [](const py::object& points, const py::object& moments, const py::object& by_points,
         const py::object& by_moments, const std::optional<double>& tolerance, int threads) {
        const Points x = as_rows<Points>(points, "points"),
                     own = as_rows<Points>(moments, "moments");
        const DipoleSet on(x, own);  // validates `points` and `moments`
        const DipoleSet by(as_rows<Points>(by_points, "by_points"),
                           as_rows<Points>(by_moments, "by_moments"));
        const Team team = team_of(threads);
        Wrenches result;
        {
          const py::gil_scoped_release release;
          result = tolerance ? treecode_forces(team, x, own, by, *tolerance)
                             : dipole_forces(team, x, own, by);
        }
        return py::make_tuple(result.forces, result.torques);
      },
      py::arg("points"), py::arg("moments"), py::arg("by_points"), py::arg("by_moments"),
      py::arg("tolerance") = py::none(), py::arg("threads") = 0);
  m.def(
      "dipole_energy",
      [](const py::object& points, const py::object& moments, int threads) {
        const DipoleSet set(as_rows<Points>(points, "points"), as_rows<Points>(moments, "moments"));
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return dipole_energy(team, set);
      },
      py::arg("points"), py::arg("moments"), py::arg("threads") = 0);
}

void bind_treecode(py::module_& m) {
  m.def(
      "dipole_tree_field",
      [](const py::object& points, const py::object& moments, const py::object& observers,
         double tolerance, int threads) {
        const DipoleSet by(as_rows<Points>(points, "points"), as_rows<Points>(moments, "moments"));
        const Points x = as_rows<Points>(observers, "observers");
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return treecode_field(team, by, x, false, tolerance).field;
      },
      py::arg("points"), py::arg("moments"), py::arg("observers"), py::arg("tolerance"),
      py::arg("threads") = 0);
  m.def(
      "dipole_tree_gradient",
      [](const py::object& points, const py::object& moments, const py::object& observers,
         double tolerance, int threads) {
        const DipoleSet by(as_rows<Points>(points, "points"), as_rows<Points>(moments, "moments"));
        const Points x = as_rows<Points>(observers, "observers");
        const Team team = team_of(threads);
        Gradients rows;
        {
          const py::gil_scoped_release release;
          rows = treecode_field(team, by, x, true, tolerance).gradient;
        }
        return as_tensors(rows);
      },
      py::arg("points"), py::arg("moments"), py::arg("observers"), py::arg("tolerance"),
      py::arg("threads") = 0);
}

void bind_interactions(py::module_& m) {
  m.def(
      "magnetic_force",
      [](const MagneticBody& on, const MagneticBody& by, double tolerance) {
        Wrench w;
        {
          const py::gil_scoped_release release;
          check_no_overlap({on, by}, {"on", "by"});
          w = magnetic_wrench(on, by, tolerance);
          w.error += charge_error(on, by);
        }
        return py::make_tuple(w.force, w.torque, w.error);
      },
      py::arg("on"), py::arg("by"), py::arg("tolerance") = 1e-4);
  m.def(
      "magnetic_forces",
      [](const std::vector<MagneticBody>& bodies, double tolerance, int threads) {
        const Team team = team_of(threads);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < bodies.size(); ++i) names.push_back(formatted("bodies[{}]", i));
        std::vector<Wrench> wrenches;
        Vector charge;
        {
          const py::gil_scoped_release release;
          check_no_overlap(bodies, names);
          wrenches = magnetic_wrenches(team, bodies, tolerance);
          charge = charge_errors(team, bodies);
        }
        Points forces(wrenches.size(), 3), torques(wrenches.size(), 3);
        Vector errors(wrenches.size());
        for (std::size_t i = 0; i < wrenches.size(); ++i) {
          forces.row(i) = wrenches[i].force.transpose();
          torques.row(i) = wrenches[i].torque.transpose();
          errors[i] = wrenches[i].error + charge[i];
        }
        return py::make_tuple(forces, torques, errors);
      },
      py::arg("bodies"), py::arg("tolerance") = 1e-4, py::arg("threads") = 0);
}

void bind_energy(py::module_& m) {
  m.def(
      "mutual_inductance",
      [](const MagneticBody& a, const MagneticBody& b, double tolerance) {
        const py::gil_scoped_release release;
        return mutual_inductance(a, b, tolerance);
      },
      py::arg("a"), py::arg("b"), py::kw_only(), py::arg("tolerance") = 1e-6);
  m.def(
      "magnetic_potential",
      [](const std::vector<MagneticBody>& bodies, const py::object& points, int threads) {
        const Points x = as_rows<Points>(points, "points");
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return magnetic_potential(team, bodies, x);
      },
      py::arg("bodies"), py::arg("points"), py::arg("threads") = 0);
  m.def(
      "magnetic_energy",
      [](const std::vector<MagneticBody>& bodies, double tolerance, int threads) {
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return magnetic_energy(team, bodies, tolerance);
      },
      py::arg("bodies"), py::arg("tolerance") = 1e-4, py::arg("threads") = 0);
}

void bind_induction(py::module_& m) {
  m.def(
      "induced_moments",
      [](const py::object& points, const std::vector<double>& radii,
         const std::vector<double>& susceptibilities, const py::object& applied, double tolerance,
         int threads) {
        const Points x = as_rows<Points>(points, "points"),
                     field = as_rows<Points>(applied, "applied", x.rows());
        const Team team = team_of(threads);
        const py::gil_scoped_release release;
        return sphere_moments(team, x, radii, susceptibilities, field, tolerance);
      },
      py::arg("points"), py::arg("radii"), py::arg("susceptibilities"), py::arg("applied"),
      py::arg("tolerance") = 1e-12, py::arg("threads") = 0);
}

void bind_cells(py::module_& m) {
  m.def(
      "magnetic_cells",
      [](const MagneticBody& body, double density, double separation) {
        return MagneticBody{std::make_shared<CellMagnet>(*body.source, density, separation),
                            body.pose};
      },
      py::arg("body"), py::kw_only(), py::arg("density"), py::arg("separation") = 3.0);
  m.def(
      "magnetic_cell_level",
      [](const MagneticBody& body, Index level) {
        const CellTable table = cell_level(body, level);
        return py::make_tuple(table.positions, table.moments);
      },
      py::arg("body"), py::arg("level"));
  m.def(
      "magnetic_cell_front",
      [](const MagneticBody& body, const MagneticBody& other) {
        const CellTable table = cell_front(body, other);
        return py::make_tuple(table.positions, table.moments);
      },
      py::arg("body"), py::arg("other"));
}

void bind_lines(py::module_& m) {
  m.def(
      "magnetic_field_lines",
      [](const std::vector<MagneticBody>& bodies, Index lines, const py::object& seeds,
         const py::object& uniform, const py::object& centre, double extent, double length,
         double tolerance, int threads) {
        LineOptions options;
        options.uniform = as_vector<Vec3>(uniform, "uniform");
        options.centre = as_vector<Vec3>(centre, "centre");
        options.extent = extent, options.length = length, options.tolerance = tolerance;
        LineSeeds given;
        if (!seeds.is_none()) given.points = as_rows<Points>(seeds, "seeds");
        if (!seeds.is_none() && given.points.rows() == 0)
          throw InvalidInput("seeds [m] must contain at least one point (n, 3), got none");
        given.way.assign(given.points.rows(), 0);
        const Team team = team_of(threads);
        FieldLines found;
        {
          const py::gil_scoped_release release;
          found = trace_field_lines(
              team, bodies,
              seeds.is_none() ? flux_seeds(team, bodies, options.uniform, lines) : given, options);
        }
        const auto numbers = [](const std::vector<LineEnd>& ends) {
          std::vector<int> all;
          for (const LineEnd end : ends) all.push_back(static_cast<int>(end));
          return all;
        };
        return py::make_tuple(found.points, found.first, numbers(found.begins),
                              numbers(found.ends));
      },
      py::arg("bodies"), py::arg("lines"), py::arg("seeds"), py::arg("uniform"), py::arg("centre"),
      py::arg("extent"), py::arg("length"), py::arg("tolerance"), py::arg("threads") = 0);
  m.def(
      "magnetic_depth",
      [](const std::vector<MagneticBody>& bodies, const py::object& points) {
        return magnetic_depth(bodies, as_rows<Points>(points, "points"));
      },
      py::arg("bodies"), py::arg("points"));
}

}  // namespace

void bind_magnetics(py::module_& m) {
  bind_body(m);
  bind_sources(m);
  bind_fields(m);
  bind_treecode(m);
  bind_interactions(m);
  bind_energy(m);
  bind_induction(m);
  bind_cells(m);
  bind_lines(m);
}

}  // namespace loomstone
