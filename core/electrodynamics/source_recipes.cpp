#include "core/electrodynamics/source_recipes.h"

#include <algorithm>

#include "core/base/message.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/magnetics/sources/polyline.h"
#include "core/magnetics/sources/sphere.h"

namespace loomstone {

namespace {

// Gives access to the contents of a recipe. Throws InvalidInput if a value, mesh or inner recipe is
// missing.
class Values {
 public:
  explicit Values(const SourceRecipe& recipe) : recipe_(recipe) {}
  double number(const char* name) const { return get<double>(name); }
  int count(const char* name) const { return static_cast<int>(number(name)); }
  const Vec3& vector(const char* name) const { return get<Vec3>(name); }
  const Points& points(const char* name) const { return get<Points>(name); }
  const TriangleMesh& mesh() const { return present(recipe_.mesh.get(), "mesh"); }
  const SourceRecipe& of() const { return present(recipe_.of.get(), "of"); }

 private:
  template <class T>
  const T& get(const char* name) const {
    for (const auto& [known, value] : recipe_.values)
      if (known == name)
        if (const T* found = std::get_if<T>(&value)) return *found;
    missing(name);
  }
  template <class Part>
  const Part& present(const Part* part, const char* name) const {
    if (!part) missing(name);
    return *part;
  }
  [[noreturn]] void missing(const char* name) const {
    fail<InvalidInput>("a recipe of \"{}\" must have {}", recipe_.kind, name);
  }
  const SourceRecipe& recipe_;
};

[[noreturn]] void refuse(const SourceRecipe& recipe) {
  fail<InvalidInput>(
      "a recipe must be that of a source of loomstone.magnetics, got \"{}\" (empty: a body with "
      "induced magnetisation, which has no recipe)",
      recipe.kind);
}

bool same(const std::shared_ptr<const TriangleMesh>& a,
          const std::shared_ptr<const TriangleMesh>& b) {
  if (!a || !b) return a == b;
  return a->n_vertices() == b->n_vertices() && a->n_triangles() == b->n_triangles() &&
         a->vertices() == b->vertices() && a->triangles() == b->triangles();
}

bool same_value(const SourceRecipe::Value& a, const SourceRecipe::Value& b) {
  const auto *p = std::get_if<Points>(&a), *q = std::get_if<Points>(&b);
  if (p && q) return p->rows() == q->rows() && *p == *q;
  return a.index() == b.index() && a == b;
}

}  // namespace

bool operator==(const SourceRecipe& a, const SourceRecipe& b) {
  const auto same_entry = [](const auto& x, const auto& y) {
    return x.first == y.first && same_value(x.second, y.second);
  };
  return a.kind == b.kind &&
         std::equal(a.values.begin(), a.values.end(), b.values.begin(), b.values.end(),
                    same_entry) &&
         same(a.mesh, b.mesh) && (a.of && b.of ? *a.of == *b.of : a.of == b.of);
}

SourcePtr make_source(const SourceRecipe& recipe) {
  const Values v(recipe);
  const std::string& kind = recipe.kind;
  if (kind == "cuboid") return std::make_shared<Cuboid>(v.vector("size"), v.vector("polarization"));
  if (kind == "cylinder")
    return std::make_shared<Cylinder>(v.number("radius"), v.number("height"),
                                      v.vector("polarization"), v.number("inner_radius"));
  if (kind == "sphere")
    return std::make_shared<Sphere>(v.number("radius"), v.vector("polarization"));
  if (kind == "mesh") return std::make_shared<MeshMagnet>(v.mesh(), v.vector("polarization"));
  if (kind == "dipoles")
    return std::make_shared<DipoleSet>(v.points("points"), v.points("moments"));
  if (kind == "cells")
    return std::make_shared<CellMagnet>(*make_source(v.of()), v.number("density"),
                                        v.number("separation"));
  if (kind == "loop")
    return std::make_shared<Loop>(v.number("radius"), v.number("current"), v.number("turns"));
  if (kind == "solenoid")
    return std::make_shared<Solenoid>(v.number("radius"), v.number("length"), v.number("turns"),
                                      v.number("current"));
  if (kind == "polyline")
    return std::make_shared<Polyline>(v.points("vertices"), v.number("current"));
  refuse(recipe);
}

SoftShapePtr make_soft_shape(const Team& team, const SourceRecipe& recipe) {
  const Values v(recipe);
  const std::string& kind = recipe.kind;
  if (kind == "soft_sphere")
    return soft_sphere(v.number("radius"), v.number("susceptibility"), v.count("degree"));
  if (kind == "soft_cuboid")
    return soft_cuboid(team, v.vector("size"), v.number("susceptibility"), v.count("cells"),
                       v.number("focus"));
  if (kind == "soft_cylinder")
    return soft_cylinder(team, v.number("radius"), v.number("height"), v.number("inner_radius"),
                         v.number("susceptibility"), v.count("cells"));
  if (kind == "soft_mesh")
    return soft_mesh_shape(team, v.mesh(), v.number("susceptibility"), v.count("panels"));
  refuse(recipe);
}

}  // namespace loomstone
