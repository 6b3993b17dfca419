#include "core/magnetics/forces/cells.h"

#include <algorithm>
#include <cmath>

#include "core/base/message.h"

namespace loomstone {

namespace {

constexpr std::size_t most_cells = 4000000;

const CellMagnet& checked_cells(const MagneticBody& body) {
  const CellMagnet* magnet = body.source->cell_magnet();
  if (!magnet)
    throw InvalidInput("body must have cells, got one without cells; create it with cells()");
  return *magnet;
}

CellTable table_of(const MagneticBody& body, const CellMagnet& magnet,
                   const std::vector<Index>& chosen) {
  const Mat3 rotation = rotation_matrix(body.pose.orientation);
  CellTable table{Points(chosen.size(), 3), Points(chosen.size(), 3)};
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const Cell& cell = magnet.cells()[chosen[i]];
    table.positions.row(i) = (body.pose.position + rotation * cell.position).transpose();
    table.moments.row(i) = (rotation * (cell.share * magnet.moment())).transpose();
  }
  return table;
}

}  // namespace

CellMagnet::CellMagnet(const Source& magnet, double density, double separation)
    : moment_(magnet.moment()),
      radius_(magnet.radius()),
      density_(density),
      separation_(separation),
      magnet_(std::make_shared<const SourceRecipe>(magnet.recipe())) {
  const auto box = magnet.box();
  if (!box || magnet.induced())
    throw InvalidInput(
        "body must be a solid magnet to be divided into cells, got dipoles, a current or an "
        "induced body");
  if (!(density > 0.0) || !std::isfinite(density))
    fail<InvalidInput>("density must be > 0 [1/m^3], got {}", density);
  if (!(separation >= 1.0) || !std::isfinite(separation))
    fail<InvalidInput>("separation must be >= 1 [1], got {}", separation);
  if ((box->second - box->first).prod() * density > static_cast<double>(most_cells))
    fail<InvalidInput>("density must give at most 4000000 cells, got {}; lower it",
                       (box->second - box->first).prod() * density);
  build(magnet, box->first, box->second, density);
  if (cells_.empty()) {  // without leaves, one cell represents the whole body
    cells_.push_back({box->first, box->second, 0.5 * (box->first + box->second), 1.0, {-1, -1}});
    diameter_ = std::cbrt((box->second - box->first).prod());
  }
  const double total = cells_[0].share;
  std::vector<Vec3> positions;
  for (Cell& cell : cells_) {
    cell.share /= total;
    if (cell.children[0] < 0) positions.push_back(cell.position);
  }
  Points x(positions.size(), 3), m(positions.size(), 3);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    x.row(i) = positions[i].transpose();
    m.row(i) = moment_.transpose() / static_cast<double>(positions.size());
  }
  leaves_ = DipoleSet(std::move(x), std::move(m));
}

// Adds the cells of a box and of its parts. Returns the index of the box's cell, or -1 if the box
// contains no leaf. At this stage, shares are numbers of leaves.
Index CellMagnet::build(const Source& magnet, const Vec3& low, const Vec3& high, double density) {
  const Vec3 edges = high - low, middle = 0.5 * (low + high);
  const double volume = edges.prod(), depth = magnet.depth(middle);
  if (depth < -0.5 * edges.norm()) return -1;  // entirely outside
  const Index self = static_cast<Index>(cells_.size());
  cells_.push_back({low, high, middle, 1.0, {-1, -1}});
  if (1.0 / volume >= density * (1.0 - 1e-9)) {
    diameter_ = std::cbrt(volume);
    if (depth >= 0.5 * diameter_ * (1.0 - 1e-9))
      return self;  // 1e-9 keeps leaves that rounding places slightly too close to the surface
    cells_.pop_back();
    return -1;
  }
  int axis;
  edges.maxCoeff(&axis);
  Vec3 first_high = high, second_low = low;
  first_high[axis] = second_low[axis] = middle[axis];
  Index children[2] = {build(magnet, low, first_high, density),
                       build(magnet, second_low, high, density)};
  if (children[0] < 0) std::swap(children[0], children[1]);
  if (children[0] < 0) {
    cells_.resize(self);
    return -1;
  }
  double share = 0.0;
  Vec3 mean = Vec3::Zero();
  for (const Index child : children) {
    if (child < 0) continue;
    share += cells_[child].share;
    mean += cells_[child].share * cells_[child].position;
  }
  cells_[self] = {low, high, mean / share, share, {children[0], children[1]}};
  return self;
}

CellMagnet CellMagnet::expanded(double tolerance) const {
  CellMagnet result = *this;
  result.expanded_ =
      std::make_shared<ExpandedField>(std::make_unique<DipoleGroups>(leaves_, radius_), tolerance);
  return result;
}

void CellMagnet::field_block(const double* points, Index n, Quantity quantity,
                             double* field) const {
  if (expanded_) return expanded_->field_block(points, n, field);
  leaves_.field_block(points, n, quantity, field);
}

void CellMagnet::gradient_block(const double* points, Index n, double* gradient) const {
  if (expanded_) return expanded_->gradient_block(points, n, gradient);
  leaves_.gradient_block(points, n, gradient);
}

void CellMagnet::field_and_gradient_block(const double* points, Index n, Quantity quantity,
                                          double* field, double* gradient) const {
  if (expanded_) return expanded_->field_and_gradient_block(points, n, field, gradient);
  leaves_.field_and_gradient_block(points, n, quantity, field, gradient);
}

std::vector<Index> CellMagnet::front(const Vec3& low, const Vec3& high,
                                     const RigidPose& pose) const {
  const Vec3 other_middle =
      pose.position + rotation_matrix(pose.orientation) * (0.5 * (low + high));
  const double other_radius = 0.5 * (high - low).norm();
  std::vector<Index> chosen, open{0};
  while (!open.empty()) {
    const Index index = open.back();
    open.pop_back();
    const Cell& cell = cells_[index];
    const Vec3 edges = cell.high - cell.low;
    // Smallest distance at which the cell may be used if it has children [m], r_c in (6.19) of
    // [Thomaszewski2010]. A leaf may be used at any distance.
    const double wanted = separation_ * edges.maxCoeff();
    const double spheres =
        (0.5 * (cell.low + cell.high) - other_middle).norm() - 0.5 * edges.norm() - other_radius;
    if (cell.children[0] < 0 || spheres >= wanted ||
        box_distance(cell.low, cell.high, low, high, pose) >= wanted) {
      chosen.push_back(index);
      continue;
    }
    for (const int k : {1, 0})
      if (cell.children[k] >= 0) open.push_back(cell.children[k]);
  }
  return chosen;
}

CellTable cell_level(const MagneticBody& body, Index level) {
  const CellMagnet& magnet = checked_cells(body);
  std::vector<Index> chosen;
  std::vector<std::pair<Index, Index>> open{{0, 0}};
  while (!open.empty()) {
    const auto [index, depth] = open.back();
    open.pop_back();
    const Cell& cell = magnet.cells()[index];
    if (depth == level || cell.children[0] < 0) {
      chosen.push_back(index);
      continue;
    }
    for (const int k : {1, 0})
      if (cell.children[k] >= 0) open.emplace_back(cell.children[k], depth + 1);
  }
  return table_of(body, magnet, chosen);
}

CellTable cell_front(const MagneticBody& body, const MagneticBody& other) {
  const CellMagnet &magnet = checked_cells(body), &box = checked_cells(other);
  return table_of(
      body, magnet,
      magnet.front(box.cells()[0].low, box.cells()[0].high, relative_pose(other.pose, body.pose)));
}

Wrench cell_wrench(const MagneticBody& on, const MagneticBody& by) {
  const CellTable mine = cell_front(on, by), others = cell_front(by, on);
  const Wrenches each = dipole_forces(
      Team{}, mine.positions, mine.moments, DipoleSet(others.positions, others.moments),
      std::min(checked_cells(on).leaf_diameter(), checked_cells(by).leaf_diameter()));
  Wrench w;
  for (Eigen::Index i = 0; i < each.forces.rows(); ++i) {
    const Vec3 force = each.forces.row(i).transpose();
    w.force += force;
    w.torque += each.torques.row(i).transpose() +
                (mine.positions.row(i).transpose() - on.pose.position).cross(force);
  }
  return w;
}

}  // namespace loomstone
