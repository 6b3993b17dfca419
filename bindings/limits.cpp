// Binds functions that compute and limit the strain of a single mesh, without a scene.
#include "core/cloth/limits/strain_limiter.h"

#include <cmath>
#include <memory>

#include "bindings/bindings.h"
#include "core/base/message.h"
#include "core/cloth/cloth_model.h"
#include "core/mesh/triangle_mesh.h"
#include "core/parallel/team.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

namespace {

std::vector<Corners2> corners_of(const TriangleMesh& mesh, const std::string& rest) {
  return rest_corners(mesh, choice_named<RestLengths>(rest, "rest") == RestLengths::Uv, "mesh");
}

void check_finite(const Points& points) {
  for (Index i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      fail<InvalidInput>("points must be finite, but row {} is not", i);
}

Points strain_of(const py::object& points, const TriangleMesh& mesh, const std::string& rest,
                 int threads) {
  const Points x = as_rows<Points>(points, {"points", "m"}, mesh.n_vertices());
  check_finite(x);
  const Team team = team_of(threads);
  const py::gil_scoped_release release;
  Points result;
  corotational_strain(team, mesh.triangles(), corners_of(mesh, rest), x, result);
  return result;
}

Vector masses_of(const py::object& masses, const TriangleMesh& mesh,
                 const std::vector<Corners2>& corners) {
  if (masses.is_none())
    return lumped_mass(mesh.n_vertices(), mesh.triangles(), corners,
                       std::vector<double>(corners.size(), 1.0));
  const auto array = numbers<double>(masses, {"masses", "kg"});
  if (array.ndim() != 1 || array.shape(0) != mesh.n_vertices())
    fail<InvalidInput>("masses must have shape ({},), got {}", mesh.n_vertices(),
                       py::str(array.attr("shape")).cast<std::string>());
  const Vector result = Eigen::Map<const Vector>(array.data(), array.size());
  for (Index i = 0; i < result.size(); ++i)
    if (!(result[i] > 0.0 && std::isfinite(result[i])))
      fail<InvalidInput>("masses must be positive and finite [kg], got {} at vertex {}", result[i],
                         i);
  return result;
}

LimitedCloth limited_cloth(const TriangleMesh& mesh, const std::string& rest,
                           const StrainLimit& strain_limit, const py::object& masses,
                           const std::vector<Index>& fixed) {
  LimitedCloth cloth;
  cloth.n_vertices = mesh.n_vertices();
  cloth.triangles = mesh.triangles();
  cloth.corners = corners_of(mesh, rest);
  cloth.limits = {strain_limit};
  cloth.limit_of.assign(mesh.n_triangles(), 0);
  cloth.mass = masses_of(masses, mesh, cloth.corners);
  cloth.prescribed.assign(mesh.n_vertices(), 0);
  for (const Index v : fixed) {
    if (v < 0 || v >= mesh.n_vertices())
      fail<InvalidInput>("fixed must be vertex indices in [0, {}], got {}", mesh.n_vertices() - 1,
                         v);
    cloth.prescribed[v] = 1;
  }
  return cloth;
}

std::pair<Points, LimitReport> limited(Points x, const LimitedCloth& cloth,
                                       const LimitOptions& options, int threads) {
  const Team team = team_of(threads);
  const py::gil_scoped_release release;
  StrainLimiter limiter(cloth, options);
  LimitReport report = limiter.enforce(team, 0, {}, x);
  return {std::move(x), report};
}

}  // namespace

std::vector<std::tuple<Index, std::string, double>> named(const std::vector<BrokenLimit>& broken) {
  constexpr const char* modes[] = {"weft", "warp", "shear"};
  std::vector<std::tuple<Index, std::string, double>> result;
  for (const BrokenLimit& each : broken)
    result.emplace_back(each.element, modes[each.mode], each.excess);
  return result;
}

void bind_limits(py::module_& m) {
  py::class_<LimitReport> c(m, "LimitReport",
                            "Record of a strain-limiting call and of the excess that remains.");
  c.def_readonly("sweeps", &LimitReport::sweeps,
                 "number of sweeps over all elements or over the active ones");
  c.def_readonly("evaluations", &LimitReport::evaluations,
                 "number of evaluations of the strain of an element or edge, before the final "
                 "check");
  c.def_readonly("excess", &LimitReport::excess,
                 "largest excess along weft, along warp and in shear [1]");
  c.def_readonly("beyond", &LimitReport::beyond,
                 "number of elements that exceed a limit by more than the tolerance");
  c.def_readonly("worst", &LimitReport::worst,
                 "index of the element with the largest excess; -1: none");
  c.def_property_readonly(
      "broken", [](const LimitReport& r) { return named(r.broken); },
      "(element, \"weft\" | \"warp\" | \"shear\", excess) for each limit that is exceeded by "
      "more than 0.01 or, if the limit is\n"
      "below 0.05, by more than a fifth of the limit and more than 1e-4. The largest excess comes "
      "first.");
  c.def("__repr__", [](const LimitReport& r) {
    return formatted("LimitReport(sweeps={}, evaluations={}, excess={}, beyond={}, worst={})",
                     r.sweeps, r.evaluations, py::str(py::cast(r.excess)).cast<std::string>(),
                     r.beyond, r.worst);
  });
  m.def("corotational_strain", &strain_of, py::arg("points"), py::arg("mesh"), py::kw_only(),
        py::arg("rest") = "uv", py::arg("threads") = 0,
        "Co-rotational strain U - I of each triangle of `mesh` with its vertices at `points` (n, "
        "3) [m]. Returns (m, 3): weft,\n"
        "warp and shear e12, half the engineering shear at small strains. rest: source of the rest "
        "lengths: \"uv\" (the pattern\n"
        "[m]) or \"mesh\" (the mesh itself).");
  m.def(
      "limit_strain",
      [](const py::object& points, const TriangleMesh& mesh, const StrainLimit& strain_limit,
         const py::object& masses, const std::vector<Index>& fixed, const LimitOptions& options,
         const std::string& rest, int threads) {
        Points x = as_rows<Points>(points, {"points", "m"}, mesh.n_vertices());
        check_finite(x);
        check_fields(options, "options");
        return limited(std::move(x), limited_cloth(mesh, rest, strain_limit, masses, fixed),
                       options, threads);
      },
      py::arg("points"), py::arg("mesh"), py::arg("strain_limit"), py::kw_only(),
      py::arg("masses") = py::none(), py::arg("fixed") = std::vector<Index>{},
      py::arg("options") = LimitOptions{}, py::arg("rest") = "uv", py::arg("threads") = 0,
      "Moves `points` (n, 3) [m], the vertices of `mesh`, so that no triangle strains beyond "
      "`strain_limit`. Returns the new\n"
      "points and a LimitReport. The change preserves linear and angular momentum, except for "
      "reactions at the vertices in `fixed`.\n"
      "masses (n) [kg]; None: a third of the area of the triangles around each vertex. fixed: "
      "indices of vertices that do not move.\n"
      "options: LimitOptions (strain_rate has no effect here).");
}

}  // namespace loomstone
