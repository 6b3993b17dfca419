#include "core/collision/response/smooth_normals.h"

#include <cstring>
#include <limits>

namespace loomstone {

const SmoothNormals& SmoothNormals::at(const CollisionModel& model, const Points& x) {
  for (const CollisionSurface& surface : model.surfaces) {
    if (!surface.smooth) continue;
    if (empty()) {
      first_ = surface.first_vertex;  // surfaces are sorted by their vertices
      x_.setConstant(x.rows() - first_, 3, std::numeric_limits<double>::quiet_NaN());
      normals_.resize(x.rows() - first_, 3);
    }
    const Index begin = surface.first_vertex - first_;
    const double* const now = x.row(surface.first_vertex).data();
    double* const kept = x_.row(begin).data();
    const std::size_t size = 3 * sizeof(double) * static_cast<std::size_t>(surface.n_vertices);
    if (std::memcmp(kept, now, size) == 0) continue;
    std::memcpy(kept, now, size);
    auto normals = normals_.middleRows(begin, surface.n_vertices);
    normals.setZero();
    for (Index t = surface.first_triangle; t < surface.first_triangle + surface.n_triangles; ++t) {
      const auto corner = [&](int k) { return Vec3(x.row(model.triangles(t, k)).transpose()); };
      const Vec3 area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
      for (int k = 0; k < 3; ++k) normals_.row(model.triangles(t, k) - first_) += area.transpose();
    }
    normals.rowwise().normalize();
  }
  return *this;
}

}  // namespace loomstone
