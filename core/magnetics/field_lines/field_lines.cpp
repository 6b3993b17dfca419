#include "core/magnetics/field_lines/field_lines.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/message.h"
#include "core/magnetics/forces/overlap.h"
#include "core/magnetics/sources/charged_panels.h"

namespace loomstone {

namespace {

constexpr double largest_turn = 0.1;  // approximate largest turn between output points [rad]
// Largest turn of the tangent in a step [rad]. It does not limit steps that are shorter than the
// allowed error of a step (LineOptions::tolerance). At this turn, the error of cubic interpolation
// is 3e-4 of the radius of curvature.
constexpr double coarsest = 0.6;
// A line ends if it has moved by less than `least_move` times the allowed error in `steps_to_move`
// steps. Without this rule, a line would turn endlessly near a point where the field vanishes. Such
// points exist beside charged panels.
constexpr int steps_to_move = 64;
constexpr double least_move = 64.0;
// Largest number of attempted steps of a line in one direction, at tolerances of 1e-5 or more. At
// smaller tolerances, run() allows more steps. The limit matters for induced bodies: at distances
// below the size of a panel, the field shows the pattern of the panels, and lines through weak
// fields may never end.
constexpr double most_steps = 1000.0;

constexpr std::array<std::array<double, 6>, 6> stages = {{
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
}};
constexpr std::array<double, 7> error_weights = {
    71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

// Minimum thickness of the layer around a body with charged panels, as a fraction of the body's
// radius [1]. The field so close to the surface shows the pattern of the panels, and lines would
// wind along the borders of panels. A line that enters the layer therefore ends at the nearest
// surface point.
constexpr double layer_thickness = 2e-3;

struct Solid {
  const Source* source;
  RigidPose pose;
  Mat3 rotation;
  double layer = 0.0;  // thickness of the layer [m]

  explicit Solid(const MagneticBody& body)
      : source(body.source.get()), pose(body.pose), rotation(rotation_matrix(pose.orientation)) {
    const ChargedPanels* const charged = source->charged_panels();
    if (!charged) return;
    // The panels of a curved surface are flat, so their centres lie below it.
    double deepest = 0.0;
    for (const FlatPanel& panel : charged->set().panels)
      deepest = std::max(deepest, source->depth(panel.centre));
    layer = std::max(layer_thickness * source->radius(), 2.0 * deepest);
  }
  bool holds(const Vec3& point) const { return depth(point) > 0.0; }
  bool nearly_holds(const Vec3& point) const { return layer > 0.0 && depth(point) > -layer; }
  Vec3 on_surface(const Vec3& point) const {
    const Vec3 local = rotation.transpose() * (point - pose.position);
    return point + source->depth(local) * (rotation * outward_normal(*source, local));
  }

 private:
  double depth(const Vec3& point) const {
    const Vec3 local = rotation.transpose() * (point - pose.position);
    const bool far = local.norm() > source->radius() * (1.0 + 1e-9) + layer;
    return far ? -INFINITY : source->depth(local);
  }
};

// State of a line that is being traced in one direction.
struct Tracer {
  Vec3 x = Vec3::Zero(), tangent = Vec3::Zero();  // current position, and tangent at the seed
  double sign = 1.0, step = 0.0, length = 0.0;
  Vec3 mark = Vec3::Zero();            // position when n_steps was last a multiple of steps_to_move
  int n_steps = 0;                     // number of accepted steps
  Index origin = 0;                    // index of the seed
  bool inside = false, close = false;  // inside: in a body; close: in a layer or the body within it
  bool away = false, done = false;     // away: has been far from its seed; done: has ended
  LineEnd end = LineEnd::length;
  std::vector<Vec3> points;
  std::array<Vec3, 7> k = zeros();  // tangents at the stages

  static std::array<Vec3, 7> zeros() {
    std::array<Vec3, 7> all;
    all.fill(Vec3::Zero());
    return all;
  }

  void stop(LineEnd why) { done = true, end = why; }
};

Vec3 hermite(const Vec3& a, const Vec3& da, const Vec3& b, const Vec3& db, double h, double t) {
  const double s = t * t * (3.0 - 2.0 * t);
  return (1.0 - s) * a + s * b + h * t * (1.0 - t) * ((1.0 - t) * da - t * db);
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 edge = b - a;
  const double length2 = edge.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * edge).norm();
}

class LineTracing {
 public:
  LineTracing(const Team& team, const std::vector<MagneticBody>& bodies, const LineOptions& options)
      : team_(team), bodies_(bodies), options_(options) {
    for (const MagneticBody& body : bodies)
      if (body.source->box()) solids_.emplace_back(body);
  }

  void run(std::vector<Tracer>& lines) {
    std::vector<Tracer*> active;
    for (Tracer& line : lines) {
      line.points.push_back(line.x);
      line.inside = holder(line.x, &Solid::holds) != nullptr;
      line.close = holder(line.x, &Solid::nearly_holds) != nullptr;
      line.step = 1e-3 * options_.extent;
      active.push_back(&line);
    }
    directions(active, 0, [](const Tracer& line) { return line.x; });
    for (Tracer* line : active) line->tangent = line->k[0];
    const double most = most_steps * std::max(1.0, std::pow(1e-5 / options_.tolerance, 0.2));
    for (int round = 0; round < most; ++round) {
      std::erase_if(active, [](const Tracer* line) { return line->done; });
      if (active.empty()) return;
      for (int stage = 1; stage <= 6; ++stage)
        directions(active, stage, [stage](const Tracer& line) {
          Vec3 at = line.x;
          for (int i = 0; i < stage; ++i) at += line.step * stages[stage - 1][i] * line.k[i];
          return at;
        });
      for (Tracer* line : active)
        if (!line->done) advance(*line);
    }
    for (Tracer* line : active)
      if (!line->done) line->stop(LineEnd::length);
  }

 private:
  using Test = bool (Solid::*)(const Vec3&) const;
  const Solid* holder(const Vec3& point, Test holds) const {
    for (const Solid& solid : solids_)
      if ((solid.*holds)(point)) return &solid;
    return nullptr;
  }

  // Ends a line that enters a body (`holds` is &Solid::holds) or the layer of a body (`holds` is
  // &Solid::nearly_holds) at a parameter t in (low, high]. The point at(high) must lie in the body
  // or layer. Returns the point of entry into the body, or the point of the body's surface that is
  // nearest to the entry into the layer.
  template <class At>
  Vec3 end_at_body(Tracer& line, double low, double high, Test holds, At&& at) const {
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (holder(at(middle), holds) ? high : low) = middle;
    }
    line.stop(LineEnd::body);
    const Vec3 point = at(high);
    return holds == &Solid::holds ? point : holder(point, holds)->on_surface(point);
  }

  // Evaluates one stage of all lines: the unit vector along or against the field at the position
  // at(line). Ends lines at points where the field vanishes or is not finite.
  template <class At>
  void directions(const std::vector<Tracer*>& lines, int stage, At&& at) {
    Points x(lines.size(), 3);
    for (std::size_t i = 0; i < lines.size(); ++i) x.row(i) = at(*lines[i]).transpose();
    Points field = magnetic_field(team_, bodies_, x, "B");
    field.rowwise() += options_.uniform.transpose();
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const double size = field.row(i).norm();
      if (!(size > 0.0) || !std::isfinite(size)) {
        lines[i]->stop(LineEnd::no_field);
        continue;
      }
      lines[i]->k[stage] = lines[i]->sign / size * field.row(i).transpose();
    }
  }

  void advance(Tracer& line) {
    const double h = line.step, allowed = options_.tolerance * options_.extent;
    Vec3 y = line.x, error = Vec3::Zero();
    for (int i = 0; i < 6; ++i) y += h * stages[5][i] * line.k[i];
    for (int i = 0; i < 7; ++i) error += h * error_weights[i] * line.k[i];
    const double turn = std::acos(std::clamp(line.k[0].dot(line.k[6]), -1.0, 1.0));
    // A line has a corner where it crosses a surface. The turn is therefore not limited in steps
    // shorter than the allowed error.
    const double share =
        std::max(error.norm() / allowed, h > allowed ? std::pow(turn / coarsest, 5) : 0.0);
    const double factor = std::clamp(0.9 * std::pow(std::max(share, 1e-10), -0.2), 0.2, 4.0);
    if (share > 1.0) {
      line.step *= factor;
      if (line.step < 1e-12 * options_.extent) line.stop(LineEnd::no_field);
      return;
    }
    line.step = std::min(h * factor, 0.25 * options_.extent);
    if (line.n_steps++ % steps_to_move == 0) {
      if (line.n_steps > 1 && (line.x - line.mark).norm() < least_move * allowed)
        return line.stop(LineEnd::no_field);
      line.mark = line.x;
    }
    const int parts = std::max(1, static_cast<int>(std::ceil(turn / largest_turn)));
    const Vec3 seed = line.points.front();
    Vec3 before = line.x;
    for (int part = 1; part <= parts && !line.done; ++part) {
      const auto at = [&](double t) { return hermite(line.x, line.k[0], y, line.k[6], h, t); };
      Vec3 point = part == parts ? y : at(static_cast<double>(part) / parts);
      const bool inside = holder(point, &Solid::holds) != nullptr,
                 close = holder(point, &Solid::nearly_holds) != nullptr;
      const double from = static_cast<double>(part - 1) / parts,
                   to = static_cast<double>(part) / parts;
      if (close && !line.close)
        point = end_at_body(line, from, to, &Solid::nearly_holds, at);
      else if (inside && !line.inside)
        point = end_at_body(line, from, to, &Solid::holds, at);
      line.inside = inside, line.close = close;
      line.length += (point - before).norm();
      // The second term accounts for the deviation of chords from the curve.
      const double near = 20.0 * allowed + 0.2 * largest_turn * (point - before).norm();
      if (!line.done && line.away && line.k[6].dot(line.tangent) > 0.9 &&
          distance_to_segment(seed, before, point) < near) {
        point = seed;
        line.stop(LineEnd::closed);
      }
      line.away |= (point - seed).norm() > 3.0 * near;
      if (!line.done && (point - options_.centre).norm() > options_.extent)
        line.stop(LineEnd::left);
      if (!line.done && line.length > options_.length) line.stop(LineEnd::length);
      line.points.push_back(point);
      before = point;
    }
    line.x = y;
    line.k[0] = line.k[6];
  }

  const Team& team_;
  const std::vector<MagneticBody>& bodies_;
  const LineOptions& options_;
  std::vector<Solid> solids_;
};

}  // namespace

std::pair<Vec3, double> bounding_ball(const std::vector<MagneticBody>& bodies) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const MagneticBody& body : bodies) {
    const Vec3 reach = Vec3::Constant(body.source->radius());
    low = low.cwiseMin(body.pose.position - reach);
    high = high.cwiseMax(body.pose.position + reach);
  }
  if (bodies.empty()) return {Vec3::Zero(), 0.0};
  const Vec3 centre = 0.5 * (low + high);
  double radius = 0.0;
  for (const MagneticBody& body : bodies)
    radius = std::max(radius, (body.pose.position - centre).norm() + body.source->radius());
  return {centre, radius};
}

Vector magnetic_depth(const std::vector<MagneticBody>& bodies, const ConstPointsRef& points) {
  Vector deepest = Vector::Constant(points.rows(), -INFINITY);
  for (const MagneticBody& body : bodies) {
    if (!body.source->box()) continue;
    const Mat3 back = rotation_matrix(body.pose.orientation).transpose();
    for (Index i = 0; i < points.rows(); ++i)
      deepest[i] = std::max(
          deepest[i], body.source->depth(back * (points.row(i).transpose() - body.pose.position)));
  }
  return deepest;
}

namespace {

LineOptions checked_options(const std::vector<MagneticBody>& bodies, LineOptions options) {
  if (!options.uniform.allFinite() || !options.centre.allFinite())
    throw InvalidInput("uniform [T] and centre [m] of field lines must be finite");
  if (!(options.extent >= 0.0) || !(options.length >= 0.0) || !std::isfinite(options.extent) ||
      !std::isfinite(options.length))
    fail<InvalidInput>(
        "extent [m] and length [m] of field lines must be finite and at least 0 (0: chosen from "
        "the bodies), got {} and {}",
        options.extent, options.length);
  if (!(options.tolerance >= 1e-12 && options.tolerance <= 0.1))
    fail<InvalidInput>("tolerance of field lines must be in [1e-12, 0.1], got {}",
                       options.tolerance);
  if (options.extent == 0.0)
    std::tie(options.centre, options.extent) = bounding_ball(bodies), options.extent *= 4.0;
  if (options.extent == 0.0)
    throw InvalidInput(
        "extent [m] of field lines must be > 0 if there are no bodies or only point dipoles, got "
        "0");
  if (options.length == 0.0) options.length = 20.0 * options.extent;
  return options;
}

// Returns one tracer for each requested direction from each seed. If a line is traced in both
// directions, the tracer against the field comes first.
std::vector<Tracer> tracers_from(const LineSeeds& seeds) {
  std::vector<Tracer> tracers;
  for (Index i = 0; i < seeds.points.rows(); ++i)
    for (const double sign : {-1.0, 1.0}) {
      if (seeds.way[i] * sign < 0.0) continue;
      Tracer line;
      line.x = seeds.points.row(i).transpose();
      line.sign = sign;
      line.origin = i;
      tracers.push_back(std::move(line));
    }
  return tracers;
}

// Joins the one or two tracers of each seed into one line in the direction of B.
FieldLines joined(const std::vector<Tracer>& tracers) {
  FieldLines lines;
  lines.first.push_back(0);
  std::vector<Vec3> all;
  for (std::size_t t = 0; t < tracers.size(); ++t) {
    const Tracer& line = tracers[t];
    const Tracer* onwards = line.sign > 0.0 ? &line : nullptr;
    LineEnd begin = LineEnd::seed, end = LineEnd::seed;
    if (line.sign < 0.0) {
      const bool both = t + 1 < tracers.size() && tracers[t + 1].origin == line.origin;
      if (both) ++t;
      // If one direction closes the line, the other is dropped, because it may miss the seed.
      const bool only_onwards =
          both && line.end != LineEnd::closed && tracers[t].end == LineEnd::closed;
      begin = only_onwards ? LineEnd::closed : line.end;
      if (!only_onwards) all.insert(all.end(), line.points.rbegin(), line.points.rend());
      if (both && line.end == LineEnd::closed) end = LineEnd::closed;
      if (both && line.end != LineEnd::closed) onwards = &tracers[t];
    }
    if (onwards) {
      const bool whole = onwards == &line || begin == LineEnd::closed;
      all.insert(all.end(), onwards->points.begin() + (whole ? 0 : 1), onwards->points.end());
      end = onwards->end;
    }
    lines.first.push_back(static_cast<Index>(all.size()));
    lines.begins.push_back(begin);
    lines.ends.push_back(end);
  }
  lines.points.resize(all.size(), 3);
  for (std::size_t i = 0; i < all.size(); ++i) lines.points.row(i) = all[i].transpose();
  return lines;
}

}  // namespace

FieldLines trace_field_lines(const Team& team, const std::vector<MagneticBody>& bodies,
                             const LineSeeds& seeds, const LineOptions& given) {
  check_points(seeds.points, "seeds");
  const LineOptions options = checked_options(bodies, given);
  std::vector<Tracer> tracers = tracers_from(seeds);
  LineTracing(team, bodies, options).run(tracers);
  return joined(tracers);
}

}  // namespace loomstone
