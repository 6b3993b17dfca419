#include "core/magnetics/interaction.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/simd.h"
#include "core/magnetics/cells.h"
#include "core/magnetics/constants.h"
#include "core/magnetics/gauss.h"

namespace loomstone {

namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

// What is integrated, in the axes of the body whose field acts: force, then torque about the other's centre over its
// radius.
struct Integrand {
  const Source& by;
  const std::vector<Panel>& panels;
  RigidPose pose;  // of the integrated body in the axes of `by`
  Mat3 rotation;
  double radius;

  // Values at the points of a tensor rule on [u0, u1] x [v0, v1], times the area; nu x nv columns.
  void evaluate(const Panel& panel, const double* from, const double* size, int nu, int nv, Vec6* values) const {
    const GaussRule &ru = gauss_rule(nu), &rv = gauss_rule(nv);
    const Index n = nu * nv, padded = (n + n_lanes - 1) / n_lanes * n_lanes;
    alignas(64) double x[3 * points_per_block], h[3 * points_per_block];
    PanelSample samples[points_per_block];
    for (Index i = 0; i < padded; ++i) {
      const Index k = std::min(i, n - 1);
      samples[i] = panel.at(from[0] + size[0] * 0.5 * (1.0 + ru.nodes[k / nv]),
                            from[1] + size[1] * 0.5 * (1.0 + rv.nodes[k % nv]));
      const Vec3 point = pose.position + rotation * samples[i].position;
      for (int c = 0; c < 3; ++c) x[c * padded + i] = point[c];
    }
    by.field_block(x, padded, Quantity::mu0_field_strength, h);
    for (Index i = 0; i < n; ++i) {
      const Vec3 field(h[i], h[padded + i], h[2 * padded + i]);
      const Vec3 force = samples[i].charge * field + (rotation * samples[i].current).cross(field);
      values[i].head<3>() = force;
      values[i].tail<3>() = (rotation * samples[i].position).cross(force) / radius;
    }
  }
};

// Part of a panel with its integral and the error each direction adds.
struct Leaf {
  Index panel;
  double from[2], size[2];
  Vec6 value;
  double error[2];
};

// Error of the rule in one direction from the Legendre coefficients of the values summed over the other.
double rule_error(const Vec6* sums, const GaussRule& rule) {
  double largest = 0.0, last = 0.0;
  for (int degree = 0; degree < rule.n; ++degree) {
    Vec6 coefficient = Vec6::Zero();
    for (int i = 0; i < rule.n; ++i) {
      double p = 1.0, before = 0.0;
      for (int k = 1; k <= degree; ++k) {
        const double next = ((2.0 * k - 1.0) * rule.nodes[i] * p - (k - 1.0) * before) / k;
        before = p;
        p = next;
      }
      coefficient += rule.weights[i] * p * sums[i];
    }
    const double size = (degree + 0.5) * coefficient.norm();
    largest = std::max(largest, size);
    if (degree >= rule.n - 2) last = std::max(last, size);
  }
  return largest > 0.0 ? 2.0 * last * last / largest : 0.0;
}

void integrate(const Integrand& integrand, int n, Leaf& leaf) {
  const Panel& panel = integrand.panels[leaf.panel];
  const int nu = n, nv = panel.line() ? 1 : n;
  const GaussRule &ru = gauss_rule(nu), &rv = gauss_rule(nv);
  Vec6 values[points_per_block], along_u[most_gauss_points], along_v[most_gauss_points];
  integrand.evaluate(panel, leaf.from, leaf.size, nu, nv, values);
  const double share = 0.25 * leaf.size[0] * leaf.size[1];  // weights add up to 2 in each direction
  leaf.value.setZero();
  for (int i = 0; i < nu; ++i) along_u[i].setZero();
  for (int k = 0; k < nv; ++k) along_v[k].setZero();
  for (int i = 0; i < nu; ++i) {
    for (int k = 0; k < nv; ++k) {
      along_u[i] += share * rv.weights[k] * values[i * nv + k];
      along_v[k] += share * ru.weights[i] * values[i * nv + k];
    }
    leaf.value += ru.weights[i] * along_u[i];
  }
  leaf.error[0] = rule_error(along_u, ru);
  leaf.error[1] = nv > 1 ? rule_error(along_v, rv) : 0.0;
}

struct Total {
  Vec6 value = Vec6::Zero();
  double error = 0.0, absolute = 0.0;
};

Total total_of(const std::vector<Leaf>& leaves) {
  Total t;
  for (const Leaf& leaf : leaves) {
    t.value += leaf.value;
    t.error += leaf.error[0] + leaf.error[1];
    t.absolute += leaf.value.norm();
  }
  return t;
}

// Halves leaves whose error is above their share until the whole is below the tolerance.
Total adapt(const Integrand& integrand, double tolerance, double least) {
  // Points a direction: more pay where more digits are wanted.
  const int n = tolerance >= 1e-3 ? 5 : tolerance >= 1e-6 ? 7 : 10;
  std::vector<Leaf> leaves(integrand.panels.size());
  Index evaluations = 0;
  for (Index p = 0; p < static_cast<Index>(leaves.size()); ++p) {
    leaves[p] = Leaf{p, {0.0, 0.0}, {1.0, 1.0}, Vec6::Zero(), {0.0, 0.0}};
    integrate(integrand, n, leaves[p]);
    evaluations += n * n;
  }
  for (;;) {
    const Total total = total_of(leaves);
    const double size = std::max(total.value.head<3>().norm(), total.value.tail<3>().norm());
    // Where the parts cancel altogether, 1e-6 of them is zero.
    const double goal = tolerance * std::max({size, least, 1e-6 * total.absolute});
    if (total.error <= goal || evaluations > most_evaluations) return total;
    const double share = 0.5 * goal / static_cast<double>(leaves.size());
    const std::size_t count = leaves.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (leaves[i].error[0] + leaves[i].error[1] <= share) continue;
      const int axis = leaves[i].error[0] >= leaves[i].error[1] ? 0 : 1;
      leaves[i].size[axis] *= 0.5;
      Leaf other = leaves[i];
      other.from[axis] += other.size[axis];
      integrate(integrand, n, leaves[i]);
      integrate(integrand, n, other);
      leaves.push_back(other);
      evaluations += 2 * n * n;
    }
  }
}

RigidPose relative_pose(const RigidPose& of, const RigidPose& in) {
  const Vec4 back = quaternion_inverse(in.orientation);
  return {rotation_matrix(in.orientation).transpose() * (of.position - in.position),
          quaternion_product(back, of.orientation)};
}

// Force and torque about its centre on the dipoles of `on`, world axes.
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
    w.torque += m.cross(field.row(i).transpose()) + (x.row(i).transpose() - on.pose.position).cross(force);
  }
  return w;
}

Wrench integrated(const MagneticBody& on, const MagneticBody& by, double tolerance, double least) {
  if (on.source->dipoles()) return on_dipoles(on, by);
  const std::vector<Panel> panels = on.source->panels();
  const RigidPose pose = relative_pose(on.pose, by.pose);
  const Integrand integrand{*by.source, panels, pose, rotation_matrix(pose.orientation), on.source->radius()};
  const Total total = adapt(integrand, tolerance, least);
  const Mat3 to_world = rotation_matrix(by.pose.orientation);
  return {to_world * total.value.head<3>(), to_world * total.value.tail<3>() * on.source->radius(), total.error};
}

// 0: no integral, 1: along lines, 2: over faces.
int dimensions(const Source& source) {
  if (source.dipoles()) return 0;
  for (const Panel& panel : source.panels())
    if (!panel.line()) return 2;
  return 1;
}

// Whether to integrate over a: the simpler body, or the smaller; the choice does not depend on the order of the two.
bool integrate_over_first(const MagneticBody& a, const MagneticBody& b) {
  const int da = dimensions(*a.source), db = dimensions(*b.source);
  if (da != db) return da < db;
  const double ra = a.source->radius(), rb = b.source->radius();
  if (ra != rb) return ra < rb;
  return std::lexicographical_compare(a.pose.position.data(), a.pose.position.data() + 3, b.pose.position.data(),
                                      b.pose.position.data() + 3);
}

// What `other` feels when `one` feels w.
Wrench reaction(const Wrench& w, const MagneticBody& one, const MagneticBody& other) {
  return {-w.force, -w.torque - (one.pose.position - other.pose.position).cross(w.force), w.error};
}

void check_pair(const MagneticBody& a, const MagneticBody& b) {
  if (a.source->steady() && b.source->steady()) return;
  throw InvalidInput(
      "a polyline must be closed to feel and exert forces, got ends that differ; repeat its first vertex last");
}

void check_tolerance(double tolerance) {
  if (!(tolerance >= 1e-12 && tolerance <= 0.1))
    throw InvalidInput("tolerance must be in [1e-12, 0.1] [1], got " + std::to_string(tolerance));
}

// Spheres and other bodies of one dipole act on one another by one sum; returns which they are.
std::vector<bool> add_single_dipoles(const Team& team, const std::vector<MagneticBody>& bodies,
                                     std::vector<Wrench>& result) {
  std::vector<bool> single(bodies.size(), false);
  std::vector<Index> rows;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const DipoleSet* set = bodies[i].source->dipoles();
    single[i] = set && set->positions().rows() == 1 && !dynamic_cast<const CellMagnet*>(bodies[i].source.get());
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

}  // namespace

Wrench magnetic_wrench(const MagneticBody& on, const MagneticBody& by, double tolerance, double least) {
  check_tolerance(tolerance);
  check_pair(on, by);
  if (dynamic_cast<const CellMagnet*>(on.source.get()) && dynamic_cast<const CellMagnet*>(by.source.get())) {
    if (integrate_over_first(on, by)) return cell_wrench(on, by);
    return reaction(cell_wrench(by, on), by, on);
  }
  if (integrate_over_first(on, by)) return integrated(on, by, tolerance, least);
  return reaction(integrated(by, on, tolerance, least), by, on);
}

std::vector<Wrench> magnetic_wrenches(const Team& team, const std::vector<MagneticBody>& bodies, double tolerance) {
  check_tolerance(tolerance);
  std::vector<Wrench> result(bodies.size());
  const std::vector<bool> single = add_single_dipoles(team, bodies, result);
  std::vector<std::pair<Index, Index>> pairs;
  for (Index i = 0; i < static_cast<Index>(bodies.size()); ++i) {
    for (Index k = i + 1; k < static_cast<Index>(bodies.size()); ++k) {
      check_pair(bodies[i], bodies[k]);
      if (!(single[i] && single[k])) pairs.emplace_back(i, k);
    }
  }
  // First roughly, for the largest force; then what is not yet good enough.
  std::vector<Wrench> on_first(pairs.size());
  const auto solve = [&](Index p, double wanted, double least) {
    on_first[p] = magnetic_wrench(bodies[pairs[p].first], bodies[pairs[p].second], wanted, least);
  };
  parallel_tasks(team, static_cast<Index>(pairs.size()), [&](Index p) { solve(p, std::max(tolerance, 0.1), 0.0); });
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
