#include "core/cloth/air.h"

#include <cmath>

namespace loomstone {

Vec3 wind_at(const Air& air, const Vec3& place, double time) {
  if (air.gust == 0.0) return air.wind;
  const double speed = air.wind.norm();
  if (speed == 0.0) return air.wind;
  const double s = air.wind.dot(place) / speed;  // coordinate along the wind [m]
  const double waves = 0.5 * std::sin(2.3 * time - 3.1 * s) +
                       0.3 * std::sin(5.1 * time - 4.7 * s + 1.7 * place.z()) +
                       0.2 * std::sin(9.7 * time - 7.9 * s + 2.9 * place.y());
  return air.wind * (1.0 + air.gust * waves);
}

namespace {
Vec3 triangle_drag(const Air& air, const DraggedSurface& surface, Index t) {
  const auto& [time, triangles, incidence, x, v] = surface;
  const Index i = triangles(t, 0), j = triangles(t, 1), k = triangles(t, 2);
  const Vec3 xi = x.row(i), xj = x.row(j), xk = x.row(k);
  const Vec3 twice = (xj - xi).cross(xk - xi);
  const double norm = twice.norm();
  if (norm == 0.0) return Vec3::Zero();
  const Vec3 n = twice / norm;
  const Vec3 mean_velocity = (v.row(i) + v.row(j) + v.row(k)).transpose() / 3.0;
  const Vec3 u = wind_at(air, (xi + xj + xk) / 3.0, time) - mean_velocity;
  const double along = u.dot(n);
  const Vec3 tangential = u - along * n;
  return 0.25 * air.density * norm *
         (air.normal_drag * std::abs(along) * along * n +
          air.tangential_drag * tangential.norm() * tangential);
}
}  // namespace

void add_drag(const Team& team, const Air& air, const DraggedSurface& surface, Index begin,
              Index end, RowsOut force) {
  if (!air.drags()) return;
  const auto n_triangles = static_cast<Index>(surface.triangles.rows());
  const std::vector<Index>& start = surface.triangles_of_vertex.start;
  const std::vector<Index>& items = surface.triangles_of_vertex.items;
  std::vector<std::uint8_t> needed(n_triangles, 0);
  for (Index s = start[begin]; s < start[end]; ++s) needed[items[s]] = 1;
  Points drag(n_triangles, 3);
  parallel_for(team, n_triangles, [&](Index t) {
    if (needed[t]) drag.row(t) = triangle_drag(air, surface, t).transpose() / 3.0;
  });
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    for (Index s = start[row]; s < start[row + 1]; ++s) force.row(row) += drag.row(items[s]);
  });
}

}  // namespace loomstone
