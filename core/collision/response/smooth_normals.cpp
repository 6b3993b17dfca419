#include "core/collision/response/smooth_normals.h"

#include <cstring>
#include <limits>

namespace loomstone {

const Points& SmoothNormals::at(const CollisionModel& model, const Points& x) {
  for (const CollisionSurface& surface : model.surfaces) {
    if (!surface.smooth) continue;
    if (x_.rows() != x.rows())
      x_.setConstant(x.rows(), 3, std::numeric_limits<double>::quiet_NaN()),
          normals_.resize(x.rows(), 3);
    const double* const now = x.row(surface.first_vertex).data();
    double* const kept = x_.row(surface.first_vertex).data();
    const std::size_t size = 3 * sizeof(double) * static_cast<std::size_t>(surface.n_vertices);
    if (std::memcmp(kept, now, size) == 0) continue;
    std::memcpy(kept, now, size);
    auto normals = normals_.middleRows(surface.first_vertex, surface.n_vertices);
    normals.setZero();
    for (Index t = surface.first_triangle; t < surface.first_triangle + surface.n_triangles; ++t) {
      const auto corner = [&](int k) { return Vec3(x.row(model.triangles(t, k)).transpose()); };
      const Vec3 area = (corner(1) - corner(0)).cross(corner(2) - corner(0));
      for (int k = 0; k < 3; ++k) normals_.row(model.triangles(t, k)) += area.transpose();
    }
    normals.rowwise().normalize();
  }
  return normals_;
}

}  // namespace loomstone
