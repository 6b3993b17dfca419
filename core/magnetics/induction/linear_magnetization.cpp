#include "core/magnetics/induction/linear_magnetization.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/message.h"
#include "core/magnetics/forces/cells.h"
#include "core/magnetics/forces/sphere_series.h"
#include "core/magnetics/induction/coupled_response.h"
#include "core/magnetics/induction/gmres.h"
#include "core/magnetics/sources/constants.h"

namespace loomstone {

namespace {

constexpr int most_rounds = 50;

// Chooses the degree of the solid harmonics of each sphere, unless the user has given it. Then
// forms pairs of spheres, and rotates the z axes of both spheres of a pair onto their line of
// centres, because translations of harmonics along z are cheap. Pairs with smaller gaps are formed
// first; the gap is measured in radii of the sphere that comes first in `soft`. Each sphere belongs
// to at most one pair.
void prepare_spheres(std::vector<SoftBody>& soft, const std::vector<MagneticBody>& hard,
                     double tolerance) {
  struct Near {
    double gap;
    std::size_t i, k;
    bool operator<(const Near& other) const {
      return std::tie(gap, i, k) < std::tie(other.gap, other.i, other.k);
    }
  };
  std::vector<Near> pairs;
  std::vector<int> degrees(soft.size());
  for (std::size_t i = 0; i < soft.size(); ++i) degrees[i] = soft[i].shape->sphere_degree();
  std::vector<SoftBody> result = soft;
  for (std::size_t i = 0; i < soft.size(); ++i) {
    if (degrees[i] < 0) continue;
    const double radius = soft[i].shape->radius();
    int degree = 2;
    for (const MagneticBody& body : hard)
      degree = std::max(
          degree, degree_of(sphere_decay(radius, distance_to_source(body, soft[i].pose.position)),
                            tolerance));
    for (std::size_t k = 0; k < soft.size(); ++k) {
      if (k == i) continue;
      const double distance = (soft[k].pose.position - soft[i].pose.position).norm();
      if (degrees[k] >= 0) {
        degree = std::max(
            degree, degree_of(sphere_decay(radius, soft[k].shape->radius(), distance), tolerance));
        if (i < k) pairs.push_back({(distance - radius - soft[k].shape->radius()) / radius, i, k});
      } else {
        const double away =
            distance_to_source({soft[k].shape->solid(), soft[k].pose}, soft[i].pose.position);
        degree = std::max(degree, degree_of(sphere_decay(radius, away), tolerance));
      }
    }
    if (degrees[i] == 0)
      result[i].shape = soft_sphere(radius, soft[i].shape->susceptibility(), degree);
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> turned(soft.size(), false);
  for (const Near& pair : pairs) {
    if (turned[pair.i] || turned[pair.k]) continue;
    turned[pair.i] = turned[pair.k] = true;
    const Vec3 axis = (soft[pair.k].pose.position - soft[pair.i].pose.position).normalized();
    const Vec3 half = axis.z() >= 0.0 ? Vec3(axis + Vec3::UnitZ()) : Vec3(Vec3::UnitZ() - axis);
    // A half turn about the bisector of the z axis and the line of centres maps the z axis onto the
    // line. Of the line's two directions, the one with z >= 0 is used.
    const Vec3 about = half.normalized();
    result[pair.i].pose.orientation = result[pair.k].pose.orientation =
        Vec4(0.0, about.x(), about.y(), about.z());
  }
  soft = std::move(result);
}

Vector joined(const std::vector<Vector>& parts) {
  Eigen::Index n = 0;
  for (const Vector& part : parts) n += part.size();
  Vector all(n);
  n = 0;
  for (const Vector& part : parts) all.segment(n, part.size()) = part, n += part.size();
  return all;
}

std::vector<Vector> parted(const Vector& all, const std::vector<Vector>& like) {
  std::vector<Vector> parts;
  Eigen::Index at = 0;
  for (const Vector& part : like) parts.push_back(all.segment(at, part.size())), at += part.size();
  return parts;
}

// Updates the effective susceptibility of `now` if the body can saturate. The demagnetisation
// factor of the body follows from the volume means of the applied field (`applied`) and of the
// magnetisation (`moment` / volume). Returns false if the susceptibility is not changed. This is so
// if the new value equals the old one within the tolerance, or if the body cannot saturate or is
// not magnetised.
bool saturate(const SoftBody& original, SoftBody& now, const Vec3& applied, const Vec3& moment,
              double tolerance) {
  if (original.saturation == 0.0) return false;
  const double polarization = mu0 * moment.norm() / now.shape->volume();
  if (polarization == 0.0) return false;
  const double chi = original.shape->susceptibility(), field = applied.dot(moment.normalized());
  // Let H_0 be the applied field, N the demagnetisation factor and M_s the saturation
  // magnetisation. H = H_0 - N M and M = chi H / (1 + chi H / M_s) give
  //   N y^2 + (1/chi + h - N) y - 1/chi = 0
  // with y = 1 - M / M_s and h = H_0 / M_s. The effective susceptibility M / H is chi y. There
  // are two expressions for the positive root. Each branch below uses the one without cancellation.
  // Both also hold for infinite chi (ideal iron).
  const double before = now.shape->susceptibility();
  const double n = (field - polarization / before) / polarization;
  const double b = 1.0 / chi + field / original.saturation - n;
  const double root = std::sqrt(std::max(b * b + 4.0 * n / chi, 0.0));
  const double effective = b >= 0.0 ? 2.0 / (b + root) : chi * ((root - b) / (2.0 * n));
  // The root is not valid if the field opposes the magnetisation. The value is therefore clamped.
  const double wanted = std::clamp(effective, std::min(1e-12, chi), chi);
  if (wanted == before || std::abs(wanted - before) <= tolerance * before / (1.0 + before))
    return false;
  now.shape = now.shape->with_susceptibility(wanted);
  return true;
}

std::vector<double> susceptibilities(const std::vector<SoftBody>& bodies) {
  std::vector<double> result;
  for (const SoftBody& body : bodies) result.push_back(body.shape->susceptibility());
  return result;
}

}  // namespace

Induction induce(const Team& team, const std::vector<SoftBody>& given,
                 const std::vector<MagneticBody>& hard, const Vec3& field, double tolerance) {
  if (!(tolerance >= 1e-14 && tolerance <= 0.1))
    fail<InvalidInput>("tolerance must be in [1e-14, 0.1] [1], got {}", tolerance);
  if (!field.allFinite()) throw InvalidInput("field must be finite [T]");
  std::vector<SoftBody> soft = given;
  prepare_spheres(soft, hard, tolerance);
  const CoupledResponse coupling(team, soft);
  std::vector<AppliedField> fine;
  const std::vector<Vector> applied = coupling.received(hard, field, fine);
  Induction result;
  const std::vector<SoftBody> original = soft;
  const bool saturates = std::any_of(soft.begin(), soft.end(),
                                     [](const SoftBody& body) { return body.saturation > 0.0; });
  for (int round = 0; round < most_rounds; ++round) {
    // One sweep of block Gauss-Seidel. Each body responds to the new charge of the bodies before it
    // in the list, to the old charge of those after it and, if `driven`, to the applied field.
    // GMRES then takes fewer iterations than if all bodies responded to the old charge.
    const auto swept = [&](std::vector<Vector> charges, bool driven) {
      for (std::size_t i = 0; i < soft.size(); ++i) {
        Vector received = coupling.received(i, charges);
        if (driven) received += applied[i];
        charges[i] = soft[i].shape->response(received);
      }
      return charges;
    };
    std::vector<Vector> answers;
    for (const Vector& each : applied) answers.push_back(Vector::Zero(each.size()));
    answers = swept(answers, true);
    const auto apply = [&](const Vector& x) {
      return Vector(x - joined(swept(parted(x, answers), false)));
    };
    std::vector<Vector> charges = answers;
    if (soft.size() > 1) {
      const GmresResult solved = gmres(apply, joined(answers), tolerance, most_gmres_iterations);
      if (!(solved.residual <= tolerance))
        fail<SolverFailure>(
            "bodies that magnetise each other must reach an equilibrium, got a relative residual "
            "of {:.3g} after {} iterations; separate bodies that overlap",
            solved.residual, solved.iterations);
      charges = parted(solved.solution, answers);
      result.residual = solved.residual;
      result.iterations += solved.iterations;
    }
    result.bodies = coupling.placed(charges, fine);
    result.susceptibilities = susceptibilities(soft);
    if (!saturates) return result;
    bool changed = false;
    for (std::size_t i = 0; i < soft.size(); ++i) {
      const Vec3 mean = soft[i].shape->mean_field(applied[i] + coupling.received(i, charges));
      changed |= saturate(original[i], soft[i], mean, result.bodies[i].source->moment(),
                          std::max(tolerance, 1e-12));
    }
    if (!changed) return result;
  }
  fail<SolverFailure>(
      "saturating bodies must reach an equilibrium, got none after {} rounds; raise "
      "tolerance",
      most_rounds);
}

double saturation_energy(const SoftBody& body, double effective) {
  if (body.saturation == 0.0 || !std::isfinite(effective)) return 0.0;
  const double r = effective / body.shape->susceptibility();
  const double shape = r > 0.0 ? 1.0 - r * r + 2.0 * r * std::log(r) : 1.0;  // r = 0: ideal iron
  return -0.5 * body.saturation * body.saturation / mu0 * body.shape->volume() / effective * shape;
}

void check_apart(const std::vector<SoftBody>& soft, const std::vector<MagneticBody>& hard,
                 const std::vector<std::string>& names) {
  constexpr double rounding = 1e-6;  // tolerated depth [radii], because bodies may touch
  for (std::size_t i = 0; i < soft.size(); ++i) {
    const Points& samples = soft[i].shape->samples();
    Points world(samples.rows(), 3);
    place_points(soft[i].pose, samples, world);
    const auto check = [&](const MagneticBody& other, const std::string& name) {
      const double size = other.source->radius(), reach = size + soft[i].shape->radius();
      const Vec3 away = other.pose.position - soft[i].pose.position;
      if (away.norm() > reach) return;
      bool overlap = false;
      if (other.source->box())
        for (Eigen::Index k = 0; k < world.rows() && !overlap; ++k)
          overlap =
              other.source->depth(in_axes(other.pose, world.row(k).transpose())) > rounding * size;
      // Samples of the body cannot show an overlap with a source that has no interior or that lies
      // inside the body. The centre of a solid source and the dipoles of a source that consists of
      // dipoles are therefore tested, too. Currents are not tested.
      const SourcePtr solid = soft[i].shape->solid();
      const auto inside = [&](const Vec3& point) {
        return solid->depth(in_axes(soft[i].pose, point)) > rounding * soft[i].shape->radius();
      };
      if (other.source->box()) {
        overlap = overlap || inside(other.pose.position);
      } else if (const DipoleSet* set = other.source->dipoles()) {
        for (Eigen::Index k = 0; k < set->positions().rows() && !overlap; ++k)
          overlap = inside(other.pose.position + rotation_matrix(other.pose.orientation) *
                                                     set->positions().row(k).transpose());
      }
      if (overlap)
        fail<InvalidInput>(
            "{} must lie apart from all others, because it magnetises, but it overlaps {}; move "
            "one of them",
            names[i], name);
    };
    for (std::size_t k = 0; k < hard.size(); ++k) check(hard[k], names[soft.size() + k]);
    for (std::size_t k = 0; k < soft.size(); ++k)
      if (k != i) check({soft[k].shape->solid(), soft[k].pose}, names[k]);
  }
}

Points explicit_cells(const SoftShape& shape, double density) {
  return CellMagnet(*shape.solid(), density, 3.0).dipoles()->positions();
}

MagneticBody explicit_response(const SoftBody& body, const Points& local,
                               const std::vector<MagneticBody>& hard, const Vec3& field) {
  Points world(local.rows(), 3);
  place_points(body.pose, local, world);
  Points b = magnetic_field(Team{}, hard, world, "B");
  b.rowwise() += field.transpose();
  if (body.saturation > 0.0)
    throw InvalidInput("saturation must be 0 [T] with the explicit response");
  const double chi = body.shape->susceptibility();
  const double share = chi == -1.0 ? -1.0
                       : chi > 1.0 ? 3.0 / (3.0 / chi + 1.0)
                                   : 3.0 * chi / (3.0 + chi);
  const double volume = body.shape->volume() / static_cast<double>(local.rows());
  return {std::make_shared<DipoleSet>(
              local, Points(share * volume / mu0 * b * rotation_matrix(body.pose.orientation))),
          body.pose};
}

}  // namespace loomstone
