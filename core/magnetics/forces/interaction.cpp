#include "core/magnetics/forces/interaction.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/base/message.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/forces/cuboid_pair.h"
#include "core/magnetics/forces/overlap.h"
#include "core/magnetics/forces/panel_quadrature.h"
#include "core/magnetics/forces/panel_wrench.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

// Returns the force on the dipoles of `on` and the torque about the centre of `on`, in world axes.
Wrench on_dipoles(const MagneticBody& on, const MagneticBody& by) {
  const DipoleSet& set = *on.source->dipoles();
  const Mat3 rotation = rotation_matrix(on.pose.orientation);
  const Index n = static_cast<Index>(set.positions().rows());
  Points x(n, 3);
  for (Index i = 0; i < n; ++i)
    x.row(i) = (on.pose.position + rotation * set.positions().row(i).transpose()).transpose();
  const Points field = magnetic_field(Team{}, {by}, x, "B");
  const Gradients gradient = magnetic_gradient(Team{}, {by}, x);
  Wrench w;
  for (Index i = 0; i < n; ++i) {
    const Vec3 m = rotation * set.moments().row(i).transpose();
    const Vec3 force = Eigen::Map<const Mat3>(gradient.row(i).data()) * m;
    w.force += force;
    w.torque +=
        m.cross(field.row(i).transpose()) + (x.row(i).transpose() - on.pose.position).cross(force);
  }
  return w;
}

// Applies moved_outside(), with the source of `solid`, to points in world axes (n x 3) [m].
void move_outside(const MagneticBody& solid, Points& x) {
  const Mat3 rotation = rotation_matrix(solid.pose.orientation);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Vec3 inside = in_axes(solid.pose, x.row(i).transpose());
    const Vec3 outside = moved_outside(*solid.source, inside);
    if (outside != inside) x.row(i) = (solid.pose.position + rotation * outside).transpose();
  }
}

// Returns the force on the surface charge of `on` and the torque about the centre of `on`, in world
// axes.
Wrench on_charges(const MagneticBody& on, const MagneticBody& by) {
  const std::vector<PanelSample> charges = on.source->charges();
  Points local(charges.size(), 3), x(charges.size(), 3);
  for (std::size_t i = 0; i < charges.size(); ++i) local.row(i) = charges[i].position.transpose();
  place_points(on.pose, local, x);
  Points outside = x;
  move_outside(by, outside);
  const Points field = magnetic_field(Team{}, {by}, outside, "B");
  Wrench w;
  for (std::size_t i = 0; i < charges.size(); ++i) {
    const Vec3 force = charges[i].charge * field.row(i).transpose();
    w.force += force;
    w.torque += (x.row(i).transpose() - on.pose.position).cross(force);
  }
  return w;
}

// Replaces the source of a body by its Source::panel_means(), whose field is cheaper to evaluate.
// Returns the body unchanged if panel_means() is null.
MagneticBody with_panel_means(const MagneticBody& body) {
  const SourcePtr means = body.source->panel_means();
  return {means ? means : body.source, body.pose};
}

Wrench integrated(const MagneticBody& on, const MagneticBody& by, double tolerance, double least) {
  if (on.source->induced()) {
    if (!by.source->induced()) return on_charges(on, by);
    const std::optional<PlacedCharges> mine = mean_charges(on), others = mean_charges(by);
    if (mine && others) return panel_wrench(*mine, *others);
    return on_charges(with_panel_means(on), with_panel_means(by));
  }
  if (on.source->dipoles()) return on_dipoles(on, by);
  if (const std::optional<Wrench> closed = parallel_cuboid_wrench(on, by)) {
    const double size = std::max(closed->force.norm(), closed->torque.norm() / on.source->radius());
    if (closed->error <= tolerance * std::max(size, least)) return *closed;
  }
  const std::vector<Panel> panels = on.source->panels();
  const RigidPose pose = relative_pose(on.pose, by.pose);
  const PanelIntegral total = integrate_panels(
      {*by.source, panels, pose, on.source->radius(), PanelQuantity::wrench}, tolerance, least);
  const Mat3 to_world = rotation_matrix(by.pose.orientation);
  return {to_world * total.value.head<3>(), to_world * total.value.tail<3>() * on.source->radius(),
          total.error};
}

// Returns the dimension of the integral over a source: 2 over faces, 1 along lines, 0 for dipoles,
// and -1 for induced bodies, which supply their own quadrature points.
int dimensions(const Source& source) {
  if (source.induced()) return -1;
  if (source.dipoles()) return 0;
  for (const Panel& panel : source.panels())
    if (!panel.line()) return 2;
  return 1;
}

// Returns whether `coil` is a solenoid wound on the curved surface of `magnet`, a cylinder or ring.
bool wound_on(const Source& coil, const Source& magnet) {
  const std::optional<CircularWinding> winding = coil.winding();
  const std::optional<UniformCylinder> cylinder = magnet.uniform_cylinder();
  if (!winding || !cylinder || winding->length == 0.0) return false;
  const auto equal = [&](double radius) {
    return std::abs(winding->radius - radius) <= 1e-9 * winding->radius;
  };
  return equal(cylinder->radius) || equal(cylinder->inner_radius);
}

// Returns whether to integrate over `a`. The integral is over the body with fewer dimensions(). If
// the dimensions are equal, it is over a solenoid that is wound on the other body, because its
// field jumps where the charges of that body lie. Otherwise, it is over a cylinder rather than a
// cuboid, because the faces of the cuboid can cut the discs of the cylinder (cut_panels.h), or over
// the body with the smaller radius. Positions decide between bodies of equal radius, so the choice
// does not depend on the order of the bodies.
bool integrate_over_first(const MagneticBody& a, const MagneticBody& b) {
  const int da = dimensions(*a.source), db = dimensions(*b.source);
  if (da != db) return da < db;
  if (wound_on(*a.source, *b.source)) return true;
  if (wound_on(*b.source, *a.source)) return false;
  if (a.source->uniform_cylinder() && b.source->uniform_cuboid()) return true;
  if (a.source->uniform_cuboid() && b.source->uniform_cylinder()) return false;
  const double ra = a.source->radius(), rb = b.source->radius();
  if (ra != rb) return ra < rb;
  return std::lexicographical_compare(a.pose.position.data(), a.pose.position.data() + 3,
                                      b.pose.position.data(), b.pose.position.data() + 3);
}

// Returns the wrench on `other` that balances the wrench w on `one`.
Wrench reaction(const Wrench& w, const MagneticBody& one, const MagneticBody& other) {
  return {-w.force, -w.torque - (one.pose.position - other.pose.position).cross(w.force), w.error};
}

void check_pair(const MagneticBody& a, const MagneticBody& b) {
  if (a.source->steady() && b.source->steady()) return;
  throw InvalidInput(
      "a polyline must be closed to feel and exert forces, got ends that differ; repeat its first "
      "vertex last");
}

void check_force_tolerance(double tolerance) {
  if (!(tolerance >= 1e-12 && tolerance <= 0.1))
    fail<InvalidInput>("tolerance must be in [1e-12, 0.1] [1], got {}", tolerance);
}

// Stores in `result` the wrenches that bodies with a single dipole, such as hard spheres, exert on
// each other. Returns a mask of these bodies, which does not include any CellMagnet.
std::vector<bool> add_single_dipoles(const Team& team, const std::vector<MagneticBody>& bodies,
                                     std::vector<Wrench>& result) {
  std::vector<bool> single(bodies.size(), false);
  std::vector<Index> rows;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const DipoleSet* set = bodies[i].source->dipoles();
    single[i] = set && set->positions().rows() == 1 && !bodies[i].source->cell_magnet();
    if (single[i]) rows.push_back(static_cast<Index>(i));
  }
  Points x(rows.size(), 3), m(rows.size(), 3), arms(rows.size(), 3);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const MagneticBody& body = bodies[rows[k]];
    const Mat3 rotation = rotation_matrix(body.pose.orientation);
    arms.row(k) = (rotation * body.source->dipoles()->positions().row(0).transpose()).transpose();
    x.row(k) = body.pose.position.transpose() + arms.row(k);
    m.row(k) = body.moment().transpose();
  }
  const Wrenches each = dipole_forces(team, x, m, DipoleSet(x, m));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Vec3 force = each.forces.row(k).transpose(), arm = arms.row(k).transpose();
    result[rows[k]].force = force;
    result[rows[k]].torque = each.torques.row(k).transpose() + arm.cross(force);
  }
  return single;
}

// Adds the wrenches between single dipoles and the other bodies, except for pairs on one carrier.
// For each of the other bodies, the field at all single dipoles on which it acts is evaluated in
// one call or taken from `known`.
void add_dipoles_in_fields(const Team& team, const std::vector<MagneticBody>& bodies,
                           const std::vector<bool>& single, const std::vector<Index>& carrier,
                           const std::vector<KnownField>& known, std::vector<Wrench>& result) {
  const auto evaluated = [&](const MagneticBody& body, const Points& x) {
    for (const KnownField& at : known)
      if (at.body.source == body.source && at.body.pose.position == body.pose.position &&
          at.body.pose.orientation == body.pose.orientation && at.points.rows() == x.rows() &&
          at.points == x)
        return at.there;
    return magnetic_field_and_gradient(team, body, x);
  };
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (single[k]) continue;
    std::vector<Index> rows;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (single[i] && (carrier.empty() || carrier[i] != carrier[k]))
        rows.push_back(static_cast<Index>(i));
    if (rows.empty()) continue;
    Points x(rows.size(), 3);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const MagneticBody& on = bodies[rows[r]];
      place_points(on.pose, on.source->dipoles()->positions(),
                   x.middleRows(static_cast<Eigen::Index>(r), 1));
    }
    const FieldAndGradient at = evaluated(bodies[k], x);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const MagneticBody& on = bodies[rows[r]];
      const Vec3 m = on.moment(), arm = x.row(r).transpose() - on.pose.position;
      Wrench w;
      w.force = Eigen::Map<const Mat3>(at.gradient.row(r).data()) * m;
      w.torque = m.cross(Vec3(at.field.row(r).transpose())) + arm.cross(w.force);
      const Wrench back = reaction(w, on, bodies[k]);
      for (const auto& [body, part] :
           {std::pair{rows[r], w}, std::pair{static_cast<Index>(k), back}}) {
        result[body].force += part.force;
        result[body].torque += part.torque;
      }
    }
  }
}

// Returns the pairs i < k of bodies on different carriers, except those with a body marked in
// `done`. If `carrier` is empty, all bodies count as being on different carriers. Throws
// InvalidInput if an open polyline and any other body are on different carriers.
std::vector<std::pair<Index, Index>> pairs_of(const std::vector<MagneticBody>& bodies,
                                              const std::vector<Index>& carrier,
                                              const std::vector<bool>& done) {
  std::vector<Index> all(bodies.size()), left;
  std::iota(all.begin(), all.end(), 0);
  std::copy_if(all.begin(), all.end(), std::back_inserter(left), [&](Index i) { return !done[i]; });
  std::vector<std::pair<Index, Index>> pairs;
  for (const Index i : all) {
    for (const Index k : done[i] ? left : all) {
      if (k <= i || (!carrier.empty() && carrier[i] == carrier[k])) continue;
      check_pair(bodies[i], bodies[k]);
      if (!done[i] && !done[k]) pairs.emplace_back(i, k);
    }
  }
  return pairs;
}

// Returns the energy of an induced body's surface charge in the potential of a hard magnet. It is
// finite even if the body and the magnet touch.
double charge_energy(const MagneticBody& induced, const MagneticBody& by) {
  const std::vector<PanelSample> charges = induced.source->charges();
  Points local(charges.size(), 3), x(charges.size(), 3);
  for (std::size_t i = 0; i < charges.size(); ++i) local.row(i) = charges[i].position.transpose();
  place_points(induced.pose, local, x);
  const Vector potential = magnetic_potential(Team{}, {by}, x);
  double energy = 0.0;
  for (std::size_t i = 0; i < charges.size(); ++i) energy += mu0 * charges[i].charge * potential[i];
  return energy;
}

bool is_current(const Source& source) {
  return !source.induced() && !source.dipoles() && source.surface().empty();
}

double energy_integral(const MagneticBody& on, const MagneticBody& by, double tolerance) {
  if (const DipoleSet* set = on.source->dipoles()) {
    const Mat3 rotation = rotation_matrix(on.pose.orientation);
    Points x(set->positions().rows(), 3);
    place_points(on.pose, set->positions(), x);
    const Points field = magnetic_field(Team{}, {by}, x, "B");
    double energy = 0.0;
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      energy -= field.row(i).dot((rotation * set->moments().row(i).transpose()).transpose());
    return energy;
  }
  const std::vector<Panel> surface = on.source->surface();
  // Absolute scale of the tolerance [J]: a thousandth of the energy of the total moment of `on` in
  // a typical field of `by`.
  const double least = 1e-3 * on.source->moment().norm() * by.source->moment().norm() * mu0 /
                       (4.0 * pi * std::pow(on.source->radius() + by.source->radius(), 3));
  const PanelTask task{*by.source, surface, relative_pose(on.pose, by.pose), on.source->radius(),
                       PanelQuantity::energy};
  return integrate_panels(task, tolerance, least).value[0];
}

}  // namespace

double magnetic_energy(const MagneticBody& on, const MagneticBody& by, double tolerance) {
  check_force_tolerance(tolerance);
  for (const Source* source : {on.source.get(), by.source.get()})
    if (is_current(*source))
      throw Unsupported("only magnets and dipoles have an energy here, got a current");
  for (const auto& [induced, other] : {std::pair(&on, &by), std::pair(&by, &on)}) {
    if (!induced->source->induced()) continue;
    return other->source->dipoles() ? energy_integral(*other, *induced, tolerance)
                                    : charge_energy(*induced, *other);
  }
  if (!integrate_over_first(on, by)) return energy_integral(by, on, tolerance);
  return energy_integral(on, by, tolerance);
}

double magnetic_energy(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance,
                       const std::vector<Index>& carrier) {
  check_force_tolerance(tolerance);
  const std::vector<std::pair<Index, Index>> pairs =
      pairs_of(bodies, carrier, std::vector<bool>(bodies.size(), false));
  std::vector<double> energies(pairs.size());
  const auto solve = [&](Index p) {
    energies[p] = magnetic_energy(bodies[pairs[p].first], bodies[pairs[p].second], tolerance);
  };
  parallel_tasks(team, static_cast<Index>(pairs.size()), solve);
  double total = 0.0;
  for (const double energy : energies) total += energy;
  return total;
}

Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance,
                       double least) {
  check_force_tolerance(tolerance);
  check_pair(on, by);
  if (on.source->cell_magnet() && by.source->cell_magnet()) {
    if (integrate_over_first(on, by)) return cell_wrench(on, by);
    return reaction(cell_wrench(by, on), by, on);
  }
  if (integrate_over_first(on, by)) return integrated(on, by, tolerance, least);
  return reaction(integrated(by, on, tolerance, least), by, on);
}

std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies,
                                      double tolerance, const std::vector<Index>& carrier,
                                      const std::vector<KnownField>& known) {
  check_force_tolerance(tolerance);
  std::vector<Wrench> result(bodies.size());
  const std::vector<bool> single = add_single_dipoles(team, bodies, result);
  const std::vector<std::pair<Index, Index>> pairs = pairs_of(bodies, carrier, single);
  add_dipoles_in_fields(team, bodies, single, carrier, known, result);
  // A first, rough pass finds the largest force. A second pass refines the pairs whose error is too
  // large relative to this force.
  std::vector<Wrench> on_first(pairs.size());
  const auto solve = [&](Index p, double wanted, double least) {
    on_first[p] = magnetic_wrench(bodies[pairs[p].first], bodies[pairs[p].second], wanted, least);
  };
  parallel_tasks(team, static_cast<Index>(pairs.size()),
                 [&](Index p) { solve(p, std::max(tolerance, 0.1), 0.0); });
  double largest = 0.0;
  for (const Wrench& w : result) largest = std::max(largest, w.force.norm());
  for (const Wrench& w : on_first) largest = std::max(largest, w.force.norm());
  parallel_tasks(team, static_cast<Index>(pairs.size()), [&](Index p) {
    if (on_first[p].error > tolerance * largest) solve(p, tolerance, largest);
  });
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto [i, k] = pairs[p];
    const Wrench back = reaction(on_first[p], bodies[i], bodies[k]);
    for (const auto& [body, w] : {std::pair{i, on_first[p]}, std::pair{k, back}}) {
      result[body].force += w.force;
      result[body].torque += w.torque;
      result[body].error += w.error;
    }
  }
  return result;
}

}  // namespace loomstone
