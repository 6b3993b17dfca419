#include "core/magnetics/fast_sums/treecode.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/message.h"
#include "core/base/simd.h"
#include "core/magnetics/fast_sums/dual_tree.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

constexpr double k = mu0 / (4.0 * pi);
constexpr Index leaf_size = 32;  // must not exceed points_per_block
constexpr Index n_samples = 128;

// Two cells are far apart if the sum of their radii is less than `opening` times the distance
// between their centres.
struct Setting {
  int order;
  double opening;
  // Relative error of forces, rounded up. It was measured on 1e5 dipoles with random moments on a
  // lattice with random displacements of up to half its spacing along each axis
  // (docs/experiments/magnetics.md).
  double error;
};
constexpr Setting settings[] = {{3, 0.7, 2e-2},  {4, 0.65, 7e-3},   {5, 0.6, 2.5e-3},
                                {6, 0.55, 8e-4}, {7, 0.55, 3.5e-4}, {9, 0.55, 9e-5},
                                {9, 0.52, 6e-5}, {9, 0.5, 4e-5},    {10, 0.45, 8e-6},
                                {11, 0.4, 1e-6}, {13, 0.4, 1e-7},   {14, 0.35, 7e-9}};
constexpr int n_settings = 12;
constexpr double spare = 0.75;  // safety factor, because other dipole sets can have larger errors
// Minimum number of observers for which controlled() first tests a setting on the leaves that
// contain samples. This test evaluates at most n_samples leaves, whatever the number of observers.
// If the setting is not accurate enough, the test saves a whole pass.
constexpr Index worth_a_look = 200000;

// Returns 1 for each cell that contains any of the given rows, and 0 for the other cells.
std::vector<std::uint8_t> cells_of(const PointTree& tree, const std::vector<Index>& rows) {
  std::vector<std::uint8_t> wanted(tree.order.size(), 0), cells(tree.cells.size(), 0);
  for (const Index row : rows) wanted[row] = 1;
  for (std::size_t c = cells.size(); c-- > 0;) {
    const PointCell& cell = tree.cells[c];
    if (!cell.leaf())
      cells[c] = cells[cell.children[0]] | cells[cell.children[1]];
    else
      cells[c] = std::any_of(tree.order.begin() + cell.begin, tree.order.begin() + cell.end,
                             [&](Index row) { return wanted[row] != 0; });
  }
  return cells;
}

// Stores rows [begin, end) as coordinate arrays, padded to a multiple of eight with the last row.
// Returns the padded number of rows.
Index columns_of(const Points& rows, Index begin, Index end, double* columns) {
  const Index n = end - begin, padded = (n + n_lanes - 1) / n_lanes * n_lanes;
  for (Index i = 0; i < padded; ++i)
    for (int c = 0; c < 3; ++c) columns[c * padded + i] = rows(begin + std::min(i, n - 1), c);
  return padded;
}

double distance(const Points& a, const Points& b) {
  return (a - b).norm() / std::max(b.norm(), 1e-300);
}
double distance(const Gradients& a, const Gradients& b) {
  return (a - b).norm() / std::max(b.norm(), 1e-300);
}

template <class Rows>
Rows some(const Rows& rows, const std::vector<Index>& chosen) {
  Rows out(chosen.size(), rows.cols());
  for (std::size_t i = 0; i < chosen.size(); ++i) out.row(i) = rows.row(chosen[i]);
  return out;
}

std::vector<Index> samples_of(Index n) {
  std::vector<Index> rows;
  const Index count = std::min(n, n_samples);
  for (Index i = 0; i < count; ++i)
    rows.push_back(static_cast<Index>(static_cast<std::int64_t>(i) * n / count));
  return rows;
}

void check_sum_tolerance(double tolerance) {
  if (!(tolerance >= 1e-10 && tolerance <= 0.1))
    fail<InvalidInput>("tolerance must be in [1e-10, 0.1] [1], got {}", tolerance);
}

SourceTree source_tree(const DipoleSet& by) {
  SourceTree source{make_point_tree(by.positions(), leaf_size), {}, {}, {}, 0};
  source.positions = ordered(by.positions(), source.tree);
  source.moments = ordered(by.moments(), source.tree);
  return source;
}

bool few(const DipoleSet& by, Index observers) {
  return static_cast<double>(by.positions().rows()) * observers <= most_direct_pairs;
}

// Tries ever more accurate settings until the error meets the tolerance. pass(setting, cells)
// returns the relative error at the samples. The ratio of this error to the predicted one is
// assumed to be the same for the next setting. With many observers, each setting is first tested on
// the cells that contain samples. The setting that meets the tolerance is then applied to all
// cells. Returns false if no setting meets the tolerance.
template <class Pass>
bool controlled(double tolerance, const PointTree& observers, const std::vector<Index>& samples,
                Pass&& pass) {
  const bool look = static_cast<Index>(observers.order.size()) >= worth_a_look;
  std::vector<std::uint8_t> cells;  // empty: all cells
  if (look) cells = cells_of(observers, samples);
  double wanted = spare * tolerance;
  for (int i = 0; i < n_settings; ++i) {
    if (settings[i].error > wanted) continue;
    const double error = pass(settings[i], cells);
    if (error <= tolerance) {
      if (look) pass(settings[i], {});
      return true;
    }
    wanted = spare * settings[i].error * tolerance / error;
  }
  return false;
}

// Buffers for the points of a leaf. `own` contains the moments at these points. `field` and
// `gradient` are due to far cells, divided by mu0 / 4 pi. `near` (field or gradient) and
// `near_force` are due to near leaves.
struct LeafValues {
  alignas(64) double points[3 * leaf_size], own[3 * leaf_size], field[3 * leaf_size],
      gradient[6 * leaf_size], near[6 * leaf_size], near_force[3 * leaf_size];
};

}  // namespace

TreecodeField treecode_field(const Team& team, const DipoleSet& by, const ConstPointsRef& points,
                             bool gradient, double tolerance) {
  check_sum_tolerance(tolerance);
  check_points(points, "points");
  const Index n = static_cast<Index>(points.rows());
  const SourcePtr set(SourcePtr(), &by);
  const std::vector<MagneticBody> body{{set, {}}};
  const auto directly = [&](const ConstPointsRef& rows) -> TreecodeField {
    return {magnetic_field(team, body, rows, "B"),
            gradient ? magnetic_gradient(team, body, rows) : Gradients(), 0.0, 0};
  };
  if (few(by, n)) return directly(points);
  const std::vector<Index> samples = samples_of(n);
  Points sampled(samples.size(), 3);
  for (std::size_t i = 0; i < samples.size(); ++i) sampled.row(i) = points.row(samples[i]);
  const TreecodeField direct = directly(sampled);
  SourceTree source = source_tree(by);
  const PointTree tree = make_point_tree(points, leaf_size);
  const Points x = ordered(points, tree);
  TreecodeField result{Points(n, 3), gradient ? Gradients(n, 9) : Gradients(), 0.0, 0};
  const auto pass = [&](const Setting& setting, const std::vector<std::uint8_t>& cells) {
    const TaylorExpansion expansion(setting.order);
    source.expand(team, expansion);
    const auto write = [&](const LeafSums& leaf) {
      LeafValues v;
      const Index m = columns_of(x, leaf.cell.begin, leaf.cell.end, v.points);
      expansion.evaluate(leaf.local, leaf.cell.centre, v.points, m, v.field, v.gradient);
      dipole_field_block(leaf.near, v.points, m, v.near);
      for (Index i = 0; i < leaf.cell.end - leaf.cell.begin; ++i)
        for (int c = 0; c < 3; ++c)
          result.field(tree.order[leaf.cell.begin + i], c) =
              k * v.field[c * m + i] + v.near[c * m + i];
      if (!gradient) return;
      dipole_gradient_block(leaf.near, v.points, m, v.near);
      constexpr int place[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
      for (Index i = 0; i < leaf.cell.end - leaf.cell.begin; ++i)
        for (int c = 0; c < 9; ++c)
          result.gradient(tree.order[leaf.cell.begin + i], c) =
              k * v.gradient[place[c] * m + i] + v.near[place[c] * m + i];
    };
    DualTreeDescent(expansion, source, tree, setting.opening, cells, write).run(team);
    result.order = setting.order;
    result.error = distance(some(result.field, samples), direct.field);
    if (gradient)
      result.error =
          std::max(result.error, distance(some(result.gradient, samples), direct.gradient));
    return result.error;
  };
  if (!controlled(tolerance, tree, samples, pass)) return directly(points);
  return result;
}

Wrenches treecode_forces(const Team& team, const Points& positions, const Points& moments,
                         const DipoleSet& by, double tolerance) {
  check_sum_tolerance(tolerance);
  const Index n = static_cast<Index>(positions.rows());
  if (few(by, n)) return dipole_forces(team, positions, moments, by);
  const std::vector<Index> samples = samples_of(n);
  const Wrenches direct = dipole_forces(team, some(positions, samples), some(moments, samples), by);
  SourceTree source = source_tree(by);
  const bool mutual =
      n == by.positions().rows() && positions == by.positions() && moments == by.moments();
  const PointTree tree = mutual ? source.tree : make_point_tree(positions, leaf_size);
  const Points x = ordered(positions, tree), own = ordered(moments, tree);
  Wrenches result{Points(n, 3), Points(n, 3), Vector(n)};
  const auto pass = [&](const Setting& setting, const std::vector<std::uint8_t>& cells) {
    const TaylorExpansion expansion(setting.order);
    source.expand(team, expansion);
    const auto write = [&](const LeafSums& leaf) {
      LeafValues v;
      const Index m = columns_of(x, leaf.cell.begin, leaf.cell.end, v.points);
      columns_of(own, leaf.cell.begin, leaf.cell.end, v.own);
      expansion.evaluate(leaf.local, leaf.cell.centre, v.points, m, v.field, v.gradient);
      dipole_force_block(leaf.near, {v.points, v.own, m}, 0.0, v.near, v.near_force);
      for (Index i = 0; i < leaf.cell.end - leaf.cell.begin; ++i) {
        const auto at = [&](const double* columns, int c) { return columns[c * m + i]; };
        const Vec3 q(at(v.own, 0), at(v.own, 1), at(v.own, 2));
        Mat3 g;
        g << at(v.gradient, 0), at(v.gradient, 1), at(v.gradient, 2), at(v.gradient, 1),
            at(v.gradient, 3), at(v.gradient, 4), at(v.gradient, 2), at(v.gradient, 4),
            at(v.gradient, 5);
        const Vec3 force =
            k * (g * q) + Vec3(at(v.near_force, 0), at(v.near_force, 1), at(v.near_force, 2));
        const Vec3 field = k * Vec3(at(v.field, 0), at(v.field, 1), at(v.field, 2)) +
                           Vec3(at(v.near, 0), at(v.near, 1), at(v.near, 2));
        const Index row = tree.order[leaf.cell.begin + i];
        result.forces.row(row) = force.transpose();
        result.torques.row(row) = q.cross(field).transpose();  // (6.11) of [Thomaszewski2010]
        result.energies[row] = -q.dot(field);
      }
    };
    DualTreeDescent(expansion, source, tree, setting.opening, cells, write).run(team);
    return std::max(distance(some(result.forces, samples), direct.forces),
                    distance(some(result.torques, samples), direct.torques));
  };
  if (!controlled(tolerance, tree, samples, pass))
    return dipole_forces(team, positions, moments, by);
  if (mutual) {
    const Vec3 centre = tree.cells[0].centre;
    Vec3 left = Vec3::Zero();
    for (Index i = 0; i < n; ++i)
      left += result.torques.row(i).transpose() +
              (positions.row(i).transpose() - centre).cross(Vec3(result.forces.row(i).transpose()));
    result.torques.rowwise() -= left.transpose() / n;
  }
  return result;
}

}  // namespace loomstone
