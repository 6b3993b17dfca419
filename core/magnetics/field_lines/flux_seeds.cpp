// Seeds of field lines such that each line represents the same flux. Surfaces of solid bodies and
// surfaces bounded by closed currents are divided into pieces. The pieces of each body are sorted
// along a space-filling curve. The magnitude of the flux is then summed over the pieces of all
// bodies, except pieces where flux enters a solid body and pieces inside another body. Of n seeds,
// seed k = 0 ... n - 1 lies on the piece at which the sum reaches the fraction (k + 1/2) / n of the
// total.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/message.h"
#include "core/magnetics/field_lines/field_lines.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

struct Piece {
  Vec3 point, area;  // centre [m] and area vector [m^2] in the axes of the source
};

constexpr int pieces_per_line = 40;

// Returns point i of a Fibonacci lattice of n points on the unit sphere.
Vec3 on_sphere(int i, int n) {
  const double z = 1.0 - (2.0 * i + 1.0) / n, turn = pi * (3.0 - std::sqrt(5.0)) * i,
               rho = std::sqrt(1.0 - z * z);
  return {rho * std::cos(turn), rho * std::sin(turn), z};
}

std::vector<Piece> sphere_pieces(double radius, int n) {
  std::vector<Piece> pieces;
  const double area = 4.0 * pi * radius * radius / n;
  for (int i = 0; i < n; ++i) pieces.push_back({radius * on_sphere(i, n), area * on_sphere(i, n)});
  return pieces;
}

std::vector<Piece> disc_pieces(double radius, int n) {
  std::vector<Piece> pieces;
  for (int i = 0; i < n; ++i) {
    const double rho = 0.98 * radius * std::sqrt((i + 0.5) / n),
                 turn = pi * (3.0 - std::sqrt(5.0)) * i;
    pieces.push_back({Vec3(rho * std::cos(turn), rho * std::sin(turn), 0.0),
                      Vec3(0.0, 0.0, pi * radius * radius / n)});
  }
  return pieces;
}

// Returns lattices of pieces on the panels. The number of pieces on a panel is about n times its
// fraction of the total area, but at least 1, and can be larger on small elongated panels.
std::vector<Piece> panel_pieces(const std::vector<Panel>& panels, int n) {
  std::vector<double> areas;
  for (const Panel& panel : panels) areas.push_back(panel.at(0.5, 0.5).area.norm());
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  std::vector<Piece> pieces;
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const Vec3 du = panels[p].at(0.51, 0.5).position - panels[p].at(0.49, 0.5).position;
    const Vec3 dv = panels[p].at(0.5, 0.51).position - panels[p].at(0.5, 0.49).position;
    // A round panel is as wide as its outer arc is long.
    const double turned = panels[p].turn * panels[p].radius1;
    const double wide = std::max({50.0 * du.norm(), std::abs(turned), 1e-300}),
                 high = std::max(50.0 * dv.norm(), 1e-300);
    const double count = n * areas[p] / total;
    const int columns = std::max(1, static_cast<int>(std::lround(std::sqrt(count * wide / high))));
    const int rows = std::max(1, static_cast<int>(std::lround(count / columns)));
    for (int i = 0; i < columns; ++i)
      for (int j = 0; j < rows; ++j) {
        const PanelSample s = panels[p].at((i + 0.5) / columns, (j + 0.5) / rows);
        pieces.push_back({s.position, s.area / (columns * rows)});
      }
  }
  return pieces;
}

// Returns pieces of a surface that spans a closed line. The surface is a fan of triangles from the
// origin of the source to the segments, shrunk by 2 % to keep clear of the line.
std::vector<Piece> fan_pieces(const std::vector<Panel>& segments, int n) {
  std::vector<Panel> fan;
  for (const Panel& segment : segments) {
    Panel triangle;
    triangle.shape = Panel::Shape::triangle;
    triangle.b = 0.98 * segment.a;
    triangle.c = 0.98 * (segment.a + segment.b);
    fan.push_back(triangle);
  }
  return panel_pieces(fan, n);
}

std::vector<Piece> pieces_of(const Source& source, int n) {
  if (source.spherical()) return sphere_pieces(source.radius(), n);
  if (source.box()) return panel_pieces(source.surface(), n);
  if (const auto winding = source.winding()) return disc_pieces(winding->radius, n);
  const std::vector<Panel> line = source.panels();
  if (!line.empty() && source.steady()) return fan_pieces(line, n);
  return {};
}

// Returns whether a point is inside a body other than `own`. On the surface of a magnet, this
// happens where bodies touch, and flux passes directly from one into the other.
bool held_by_another(const std::vector<MagneticBody>& bodies, const MagneticBody& own,
                     const Vec3& point) {
  for (const MagneticBody& body : bodies) {
    if (&body == &own || !body.source->box()) continue;
    const Vec3 local =
        rotation_matrix(body.pose.orientation).transpose() * (point - body.pose.position);
    if (local.norm() <= body.source->radius() && body.source->depth(local) > 0.0) return true;
  }
  return false;
}

// Returns the Morton code of a point in the cube whose coordinates range from -radius to radius.
std::uint64_t curve_place(const Vec3& point, double radius) {
  std::uint64_t place = 0;
  std::array<std::uint64_t, 3> cell;
  for (int k = 0; k < 3; ++k)
    cell[k] = static_cast<std::uint64_t>(std::clamp(0.5 * (point[k] / radius + 1.0), 0.0, 1.0) *
                                         1048575.0);
  for (int bit = 19; bit >= 0; --bit)
    for (int k = 0; k < 3; ++k) place = 2 * place + (cell[k] >> bit & 1);
  return place;
}

}  // namespace

LineSeeds flux_seeds(const Team& team, const std::vector<MagneticBody>& bodies, const Vec3& uniform,
                     Index lines) {
  if (lines < 1) fail<InvalidInput>("lines must be at least 1, got {}", lines);
  std::vector<Vec3> points;
  std::vector<double> flux;
  std::vector<std::int8_t> way;
  for (const MagneticBody& body : bodies) {
    const bool solid = body.source->box().has_value();
    std::vector<Piece> pieces = pieces_of(*body.source, pieces_per_line * lines);
    std::stable_sort(pieces.begin(), pieces.end(), [&](const Piece& a, const Piece& b) {
      return curve_place(a.point, body.source->radius()) <
             curve_place(b.point, body.source->radius());
    });
    const Mat3 rotation = rotation_matrix(body.pose.orientation);
    Points at(pieces.size(), 3);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Vec3 normal = pieces[i].area.normalized();
      const Vec3 local = pieces[i].point + (solid ? 1e-7 * body.source->radius() : 0.0) * normal;
      at.row(i) = (body.pose.position + rotation * local).transpose();
    }
    const Points field = magnetic_field(team, bodies, at, "B");
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double through = (rotation * pieces[i].area).dot(field.row(i).transpose() + uniform);
      if ((solid && through <= 0.0) || held_by_another(bodies, body, at.row(i).transpose()))
        continue;
      points.push_back(at.row(i).transpose());
      flux.push_back(std::abs(through));
      way.push_back(solid ? 1 : 0);
    }
  }
  std::partial_sum(flux.begin(), flux.end(), flux.begin());
  if (flux.empty() || !(flux.back() > 0.0))
    throw InvalidInput(
        "field lines need a surface of a magnet or a closed current to begin at, through which "
        "flux "
        "passes; give seeds");
  LineSeeds seeds;
  seeds.points.resize(lines, 3);
  for (Index k = 0; k < lines; ++k) {
    const double wanted = (k + 0.5) / lines * flux.back();
    const std::size_t i = std::lower_bound(flux.begin(), flux.end(), wanted) - flux.begin();
    seeds.points.row(k) = points[i].transpose();
    seeds.way.push_back(way[i]);
  }
  return seeds;
}

}  // namespace loomstone
