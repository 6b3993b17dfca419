// Binds the descriptions of a scene and of its cloths, materials, strain limits, obstacles,
// attachments, magnets, coils, bearings and air. Other files bind rigid bodies (rigid.cpp) and
// looks (base.cpp).
#include "core/sim/scene/scene.h"

#include "bindings/descriptions.h"
#include "core/sim/scene/numbered_names.h"

namespace loomstone {

namespace {

// Returns the number of entries of argument `name`, or 0 if the argument has no length. If the
// argument is not given, returns `of_field`, the number of entries that the field has.
std::size_t length(const py::kwargs& arguments, const char* name, std::size_t of_field) {
  if (!arguments.contains(name)) return of_field;
  const auto n = PyObject_Size(py::object(arguments[name]).ptr());
  if (n < 0) PyErr_Clear();
  return n < 0 ? 0 : static_cast<std::size_t>(n);
}

// Returns the arguments. If argument `name` is an array (times x n x 3) of points at several times,
// its shape becomes (times * n x 3). An array (k x 3), an empty array, a single value and values
// that are not numbers remain unchanged. Throws InvalidInput for an array of numbers with another
// shape, for rows of different lengths, and for a unit of another dimension than length. In
// messages, the field is called `owner`.`name`, and the n points are called `points`.
py::kwargs with_rows(const py::kwargs& arguments, const std::string& owner, const char* name,
                     std::size_t times, std::size_t n, const char* points) {
  const std::string where = formatted("{}.{}", owner, name);
  const py::object plain = in_unit(arguments[name], "m", where);
  const py::object array = array_of(where, plain);
  const auto shape = array.attr("shape").cast<std::vector<std::size_t>>();
  const bool numbers =
      std::string("buif").find(array.attr("dtype").attr("kind").cast<char>()) != std::string::npos;
  if (!numbers || shape.empty() || py::len(array) == 0 || (shape.size() == 2 && shape[1] == 3))
    return arguments;
  if (shape != std::vector<std::size_t>{times, n, 3})
    fail<InvalidInput>(
        "{} must have shape (times, {}, 3) = ({}, {}, 3), or (times * {}, 3) = ({}, 3), got {}",
        where, points, times, n, points, times * n,
        py::str(array.attr("shape")).cast<std::string>());
  const py::kwargs changed(py::reinterpret_steal<py::object>(PyDict_Copy(arguments.ptr())));
  changed[name] = array.attr("reshape")(times * n, 3);
  return changed;
}

}  // namespace

py::kwargs reshaped(const char* name, const py::kwargs& arguments, const Cloth& cloth) {
  if (!arguments.contains("script_positions")) return arguments;
  return with_rows(arguments, name, "script_positions",
                   length(arguments, "script_times", cloth.script_times.size()),
                   length(arguments, "pins", cloth.pins.size()), "pins");
}

py::kwargs reshaped(const char* name, const py::kwargs& arguments, const Obstacle& obstacle) {
  if (!arguments.contains("vertex_positions")) return arguments;
  std::shared_ptr<const TriangleMesh> mesh = obstacle.mesh;
  if (arguments.contains("mesh") && !loaded(arguments["mesh"], mesh)) mesh.reset();
  return with_rows(arguments, name, "vertex_positions",
                   length(arguments, "times", obstacle.times.size()),
                   mesh ? static_cast<std::size_t>(mesh->n_vertices()) : 0, "vertices");
}

void complete(Scene& scene) { number_names(scene); }

void bind_scene(py::module_& m) {
  bind_description<ClothMaterial>(m, "ClothMaterial",
                                  "Material of a cloth. Axis 1 is weft and axis 2 is warp. Cloth "
                                  "is a surface, so stiffness is in N/m.");
  bind_description<StrainLimit, 3>(
      m, "StrainLimit",
      "Limits of the strain U - I (F = R U) along weft, along warp and in shear. The first "
      "three fields may be\n"
      "positional arguments.");
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
