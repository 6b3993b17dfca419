#include "core/cloth/air.h"

#include <cmath>

namespace loomstone {

Vec3 wind_at(const Air& air, const Vec3& place, double time) {
  if (air.gust == 0.0) return air.wind;
  const double speed = air.wind.norm();
  if (speed == 0.0) return air.wind;
  // Coordinates of the place [m]: s along the wind, p horizontally across the wind, and q normal
  // to both directions.
  const Vec3 along = air.wind / speed;
  const bool vertical = along.head<2>().norm() < 1e-6;
  const Vec3 across = vertical ? Vec3(Vec3::UnitY()) : Vec3::UnitZ().cross(along).normalized();
  const double s = along.dot(place), p = across.dot(place), q = along.cross(across).dot(place);
  const double waves = 0.5 * std::sin(2.3 * time - 3.1 * s) +
                       0.3 * std::sin(5.1 * time - 4.7 * s + 1.7 * q) +
                       0.2 * std::sin(9.7 * time - 7.9 * s + 2.9 * p);
  return air.wind * (1.0 + air.gust * waves);
}

namespace {

// Area and normal of a triangle, and the velocity of the air relative to the triangle.
struct RelativeWind {
  double area = 0.0;               // current area [m^2]; 0: the other members are 0, too
  Vec3 n = Vec3::Zero();           // unit normal
  double along = 0.0;              // normal component [m/s]
  Vec3 tangential = Vec3::Zero();  // [m/s]
};

RelativeWind relative_wind(const Air& air, const DraggedSurface& surface, Index t) {
  const auto& [time, triangles, incidence, x, v] = surface;
  const Index i = triangles(t, 0), j = triangles(t, 1), k = triangles(t, 2);
  const Vec3 xi = x.row(i), xj = x.row(j), xk = x.row(k);
  const Vec3 twice = (xj - xi).cross(xk - xi);
  RelativeWind result;
  const double norm = twice.norm();
  if (norm == 0.0) return result;
  result.area = 0.5 * norm;
  result.n = twice / norm;
  const Vec3 mean_velocity = (v.row(i) + v.row(j) + v.row(k)).transpose() / 3.0;
  const Vec3 u = wind_at(air, (xi + xj + xk) / 3.0, time) - mean_velocity;
  result.along = u.dot(result.n);
  result.tangential = u - result.along * result.n;
  return result;
}

Vec3 triangle_drag(const Air& air, const DraggedSurface& surface, Index t) {
  const auto [area, n, along, tangential] = relative_wind(air, surface, t);
  return 0.5 * air.density * area *
         (air.normal_drag * std::abs(along) * along * n +
          air.tangential_drag * tangential.norm() * tangential);
}

// Calls evaluate(t) in parallel for each triangle t at the vertices in rows [begin, end).
template <class Evaluate>
void for_triangles_at(const Team& team, const DraggedSurface& surface, Index begin, Index end,
                      Evaluate&& evaluate) {
  const Incidence& around = surface.triangles_of_vertex;
  const auto n_triangles = static_cast<Index>(surface.triangles.rows());
  std::vector<std::uint8_t> needed(n_triangles, 0);
  for (Index s = around.start[begin]; s < around.start[end]; ++s) needed[around.items[s]] = 1;
  parallel_for(team, n_triangles, [&](Index t) {
    if (needed[t]) evaluate(t);
  });
}

}  // namespace

void add_drag(const Team& team, const Air& air, const DraggedSurface& surface, Index begin,
              Index end, RowsOut force) {
  if (!air.drags()) return;
  const Incidence& around = surface.triangles_of_vertex;
  Points drag(surface.triangles.rows(), 3);
  for_triangles_at(team, surface, begin, end, [&](Index t) {
    drag.row(t) = triangle_drag(air, surface, t).transpose() / 3.0;
  });
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    for (Index s = around.start[row]; s < around.start[row + 1]; ++s)
      force.row(row) += drag.row(around.items[s]);
  });
}

double drag_rate(const Team& team, const Air& air, const DraggedSurface& surface,
                 const Vector& mass, Index begin, Index end) {
  if (!air.drags() || begin == end) return 0.0;
  const Incidence& around = surface.triangles_of_vertex;
  // (m) Upper bound of the drag on a corner, divided by the relative velocity [kg/s].
  Vector drag(surface.triangles.rows());
  for_triangles_at(team, surface, begin, end, [&](Index t) {
    const auto [area, n, along, tangential] = relative_wind(air, surface, t);
    drag[t] = air.density * area / 6.0 *
              (air.normal_drag * std::abs(along) + air.tangential_drag * tangential.norm());
  });
  Vector rate = Vector::Zero(end - begin);
  parallel_for(team, end - begin, [&](Index i) {
    const Index row = begin + i;
    for (Index s = around.start[row]; s < around.start[row + 1]; ++s)
      rate[i] += drag[around.items[s]] / mass[row];
  });
  return rate.maxCoeff();
}

}  // namespace loomstone
