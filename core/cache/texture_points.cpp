#include "core/cache/texture_points.h"

#include <numeric>

namespace loomstone {

TexturePoints texture_points(Index n_vertices, const Triangles& triangles,
                             const Points2& corner_uv) {
  TexturePoints made;
  made.vertices.resize(static_cast<std::size_t>(n_vertices));
  std::iota(made.vertices.begin(), made.vertices.end(), 0);
  const std::vector<Index> plain = made.vertices;
  std::vector<Vec2> uv(plain.size(), Vec2::Zero());
  std::vector<bool> has_uv(plain.size(), false);
  std::vector<Index> next(plain.size(), -1);  // next point of the same vertex; -1: none
  made.triangles = triangles;
  for (Eigen::Index corner = 0; corner < triangles.size(); ++corner) {
    const Vec2 wanted = corner_uv.row(corner);
    Index& point = made.triangles.data()[corner];
    if (!has_uv[static_cast<std::size_t>(point)]) {
      has_uv[static_cast<std::size_t>(point)] = true;
      uv[static_cast<std::size_t>(point)] = wanted;
      continue;
    }
    const Index vertex = point;
    while (uv[static_cast<std::size_t>(point)] != wanted) {
      const Index following = next[static_cast<std::size_t>(point)];
      if (following < 0) {
        const auto added = static_cast<Index>(uv.size());
        next[static_cast<std::size_t>(point)] = added;
        next.push_back(-1);
        uv.push_back(wanted);
        has_uv.push_back(true);
        made.vertices.push_back(vertex);
      }
      point = next[static_cast<std::size_t>(point)];
    }
  }
  if (made.vertices.size() > 2 * plain.size()) return {false, triangles, plain, Points2(0, 2)};
  made.textured = true;
  made.uv.resize(static_cast<Eigen::Index>(uv.size()), 2);
  for (std::size_t point = 0; point < uv.size(); ++point)
    made.uv.row(static_cast<Eigen::Index>(point)) = uv[point].transpose();
  return made;
}

}  // namespace loomstone
