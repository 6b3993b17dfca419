#include "core/sim/step/limits_with_contacts.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

namespace loomstone {

namespace {

// Maximum number of certifications before the first fallback. Our choice.
constexpr int max_rounds = 4;
constexpr int max_fallbacks = 4;
constexpr int max_passes = 16;    // passes over triangles per fallback
constexpr double aimed_at = 0.9;  // target excess of a fallback, as a fraction of the margin
// If fallbacks withhold more than this fraction of ConstrainReport::requested, the part is divided
// (see bisection.h for exceptions).
constexpr double much_motion = 0.01;
// If the solve limits strain, too, sweeps are undone if they would add more energy to the cloth
// than this fraction of the largest kinetic energy so far or of the kinetic energy before the
// sweeps, whichever is larger. In very short parts, the correction of a small excess would give
// vertices very large velocities. Our choice.
constexpr double gained_by_sweeps = 0.1;

// A strain mode (weft, warp, shear) of a triangle: the amount by which the strain in this mode
// exceeds the nearer of its two limits (negative: within the limits), and the tolerated excess [1].
struct Mode {
  double excess, margin;
};

// Kinetic energy of vertices and bodies to which the fraction s of given changes of velocity is
// applied: before + s linear + s^2 square [J].
struct KineticEnergy {
  double before = 0.0, linear = 0.0, square = 0.0;

  double after() const { return before + linear + square; }
  void add(double mass, const Vec3& velocity, const Vec3& change) {
    before += 0.5 * mass * velocity.squaredNorm();
    linear += mass * velocity.dot(change);
    square += 0.5 * mass * change.squaredNorm();
  }
  void add(const Mat3& inertia, const Vec3& velocity, const Vec3& change) {
    before += 0.5 * velocity.dot(inertia * velocity);
    linear += velocity.dot(inertia * change);
    square += 0.5 * change.dot(inertia * change);
  }
  // Returns the largest fraction s in [0, 1] at which the energy is at most `most` [J]. `most` must
  // not be less than `before`.
  double largest_share(double most) const {
    if (after() <= most) return 1.0;
    const double root = std::sqrt(linear * linear + 4.0 * square * (most - before));
    return std::clamp((root - linear) / (2.0 * square), 0.0, 1.0);
  }
};

class Constraining {
 public:
  Constraining(const ConstrainInputs& inputs, Points& x1, FreeBodies& bodies)
      : in_(inputs), x1_(x1), bodies_(bodies), given_up_(inputs.cloth->strain_limits.size(), 0) {}

  ConstrainReport run() {
    ConstrainReport done = enforce();
    done.stopped_for_limits = done.withheld_for_limits > much_motion * done.requested;
    done.broke_limits = breaks();
    return done;
  }

 private:
  ConstrainReport enforce() {
    limit(in_.loaded);
    report_.requested = parallel_sum(*in_.team, in_.cloth->n_vertices, [&](Index i) {
      return (*in_.inverse_mass)[i] > 0.0 ? (x1_.row(i) - in_.x0->row(i)).norm() : 0.0;
    });
    if (!in_.collision) return report_;
    if (in_.repelled) in_.collision->repel(motion(), *in_.repelled, in_.h, x1_, bodies_);
    const bool limits_hold = in_.limiter && in_.limits_hold;
    if (limits_hold) give_up();
    certify();
    if (!limits_hold || report_.touched.empty()) return report_;
    while (report_.rounds < max_rounds && check(x1_)) {
      keep_best();
      for (Index i = 0; i < in_.cloth->n_vertices; ++i)
        if (x1_.row(i) != target_.row(i)) held_[i] = 1;
      std::vector<Index> list;
      for (Index i = 0; i < in_.cloth->n_vertices; ++i)
        if (held_[i]) list.push_back(i);
      limit(list);
      certify();
    }
    for (int i = 0; i < max_fallbacks && check(x1_); ++i) {
      keep_best();
      if (!fall_back()) break;
      certify();
    }
    if (check(x1_)) {
      keep_best();
      x1_ = best_x1_;
      bodies_ = best_bodies_;
      best_report_.limits.sweeps = report_.limits.sweeps,
      best_report_.limits.evaluations = report_.limits.evaluations;
      best_report_.limit_seconds = report_.limit_seconds;
      best_report_.limit_waiting = report_.limit_waiting;
      best_report_.rounds = report_.rounds, best_report_.fallbacks = report_.fallbacks;
      report_ = best_report_;
    }
    return report_;
  }

  MotionInputs motion() const { return {*in_.x0, *in_.inverse_mass, *in_.tangle}; }

  // Returns whether the limits of some cloth are satisfied at the start of the part (x0) but not at
  // its end (x1).
  bool breaks() {
    if (!in_.limiter || !in_.limits_hold) return false;
    if (limiting_held() && report_.touched.empty()) return false;
    std::fill(given_up_.begin(), given_up_.end(), 0);
    if (!check(x1_)) return false;
    std::vector<std::uint8_t> broken(given_up_.size(), 0);
    for (const Index t : beyond_) broken[in_.cloth->strain_limit_of[t]] = 1;
    check(*in_.x0);
    for (const Index t : beyond_) broken[in_.cloth->strain_limit_of[t]] = 0;
    return std::any_of(broken.begin(), broken.end(), [](std::uint8_t b) { return b != 0; });
  }

  void limit(const std::vector<Index>& held) {
    if (!in_.limiter) return;
    const auto start = std::chrono::steady_clock::now();
    const double waiting = in_.ranks->traffic().waiting;
    const Points wanted = x1_;
    LimitReport done = in_.limiter->enforce(*in_.team, in_.seed, held, x1_);
    bool taken_back = done.beyond > 0 && in_.limits_hold && take_back(wanted);
    if (x1_ != wanted) {
      const Points at_rest = report_.at_rest;
      const ClothEnergy before = in_.energy(wanted, at_rest);
      keep_kinetic_energy(wanted, held);
      const ClothEnergy after = in_.energy(x1_, report_.at_rest);
      const double limited = before.total() - after.total();
      const double scale = std::max(in_.largest_kinetic, before.kinetic);
      if (in_.limits_in_solve && -limited > gained_by_sweeps * scale)
        x1_ = wanted, report_.at_rest = at_rest, taken_back = true;
      else
        report_.limited += limited;
    }
    if (taken_back) {
      const LimitReport left = in_.limiter->measure(*in_.team, x1_);
      done.excess = left.excess, done.beyond = left.beyond, done.worst = left.worst,
      done.broken = left.broken;
    }
    const int sweeps = report_.limits.sweeps + done.sweeps;
    const std::int64_t evaluations = report_.limits.evaluations + done.evaluations;
    report_.limits = done;
    report_.limits.sweeps = sweeps;
    report_.limits.evaluations = evaluations;
    report_.limit_waiting += in_.ranks->traffic().waiting - waiting;
    report_.limit_seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  // Returns whether limits act in the solve and cloth k is not limited by its edges instead.
  bool limited_in_solve(std::size_t k) const {
    const ClothModel& cloth = *in_.cloth;
    const Index row = cloth.strain_limit_of[cloth.first_triangle[k]];
    return in_.limits_in_solve && (row < 0 || !cloth.strain_limits[row].edge);
  }

  // If the corrections of a cloth by sweeps would increase its kinetic energy too much, adds a
  // fraction of them to `at_rest`, so that this fraction does not change velocities. Skips cloths
  // whose limits act in the solve. The kinetic energy may rise to the value at which the whole
  // cloth has the speed of the fastest vertex that sweeps do not move, because prescribed vertices
  // pull cloth along. x1_ and `wanted` are the positions with and without the corrections.
  void keep_kinetic_energy(const Points& wanted, const std::vector<Index>& held) {
    const ClothModel& cloth = *in_.cloth;
    Points& at_rest = report_.at_rest;
    std::vector<std::uint8_t> unmoved(cloth.n_vertices, 0);
    for (const Index i : held) unmoved[i] = 1;
    for (std::size_t k = 0; k + 1 < cloth.first_vertex.size(); ++k) {
      if (limited_in_solve(k)) continue;
      if (at_rest.rows() == 0) at_rest = Points::Zero(cloth.n_vertices, 3);
      double mass = 0.0, speed = 0.0;
      KineticEnergy energy;
      for (Index i = cloth.first_vertex[k]; i < cloth.first_vertex[k + 1]; ++i) {
        const double m = cloth.mass[i];
        mass += m;
        if (unmoved[i] || !((*in_.inverse_mass)[i] > 0.0)) {
          speed = std::max(speed, (wanted.row(i) - in_.x0->row(i)).norm() / in_.h);
          continue;
        }
        const Vec3 v =
            (in_.v->row(i) + (wanted.row(i) - in_.x->row(i) - at_rest.row(i)) / in_.h).transpose();
        energy.add(m, v, (x1_.row(i) - wanted.row(i)).transpose() / in_.h);
      }
      const double share =
          energy.largest_share(std::max(energy.before, 0.5 * mass * speed * speed));
      if (share == 1.0) continue;
      for (Index i = cloth.first_vertex[k]; i < cloth.first_vertex[k + 1]; ++i)
        at_rest.row(i) += (1.0 - share) * (x1_.row(i) - wanted.row(i));
    }
  }

  // Reduces the changes of velocity that follow from the corrections of a certification if these
  // changes would give too much kinetic energy to the vertices and bodies that certification moved.
  // In a very short part, the correction of a small gap would give them large velocities. Used only
  // in scenes with strain limits and contacts in the solve, because their parts become very short.
  // The kinetic energy may rise to the value at which all moved vertices and bodies have the speed
  // of the fastest scripted vertex. All changes are reduced in proportion, so they still conserve
  // momentum. `bodies` and `at_rest` are the values before the certification.
  void keep_energy_of_impacts(const FreeBodies& bodies, const Points& at_rest) {
    const auto rest = [](const Points& points, Index i) {
      return points.rows() > 0 ? Vec3(points.row(i).transpose()) : Vec3(Vec3::Zero());
    };
    const auto change = [&](Index i) -> Vec3 {
      return ((x1_.row(i) - target_.row(i)).transpose() - rest(report_.at_rest, i) +
              rest(at_rest, i)) /
             in_.h;
    };
    double mass = 0.0;
    KineticEnergy energy;
    for (Index i = 0; i < in_.cloth->n_vertices; ++i) {
      if (x1_.row(i) == target_.row(i) || !((*in_.inverse_mass)[i] > 0.0)) continue;
      const Vec3 v = in_.v->row(i).transpose() +
                     ((target_.row(i) - in_.x->row(i)).transpose() - rest(at_rest, i)) / in_.h;
      energy.add(in_.cloth->mass[i], v, change(i));
      mass += in_.cloth->mass[i];
    }
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const FreeBody &body = bodies[i], &now = bodies_[i];
      if (now.moved == body.moved && now.turned == body.turned) continue;
      energy.add(1.0 / body.inverse_mass, body.velocity + body.moved / in_.h,
                 (now.moved - body.moved) / in_.h);
      energy.add(Mat3(body.inverse_inertia.inverse()), body.angular_velocity + body.turned / in_.h,
                 (now.turned - body.turned) / in_.h);
      mass += 1.0 / body.inverse_mass;
    }
    const double of_scripts = 0.5 * mass * in_.scripted_speed * in_.scripted_speed;
    const double share = energy.largest_share(std::max(energy.before, of_scripts));
    if (share == 1.0) return;
    if (report_.at_rest.rows() == 0) report_.at_rest = Points::Zero(in_.cloth->n_vertices, 3);
    for (Index i = 0; i < in_.cloth->n_vertices; ++i)
      if (x1_.row(i) != target_.row(i))
        report_.at_rest.row(i) += (1.0 - share) * in_.h * change(i).transpose();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      bodies_[i].moved = bodies[i].moved + share * (bodies_[i].moved - bodies[i].moved);
      bodies_[i].turned = bodies[i].turned + share * (bodies_[i].turned - bodies[i].turned);
    }
  }

  // If certification or a fallback has withheld some of the corrections in `at_rest`, subtracts the
  // withheld part from them. Thus, the withholding does not change velocities either.
  void withhold_at_rest(const std::vector<WithheldMotion>& withheld) {
    Points& at_rest = report_.at_rest;
    for (const WithheldMotion& motion : withheld) {
      if (motion.vertex >= at_rest.rows()) continue;
      auto row = at_rest.row(motion.vertex);
      const double square = row.squaredNorm();
      if (square > 0.0) row *= 1.0 - std::clamp(row.dot(motion.displacement) / square, 0.0, 1.0);
    }
  }

  // Returns whether limiting has satisfied the limits and no later impulses move vertices.
  // In this case, no check is needed until certification moves vertices.
  bool limiting_held() const { return report_.limits.broken.empty() && !in_.repelled; }

  // Marks the loaded vertices in held_. Gives up the cloths that exceed their limits before
  // certification: later rounds do not limit these cloths, and their excess is reported. Possible
  // causes are scripted motion that leaves no room, or too few sweeps.
  void give_up() {
    held_.assign(in_.cloth->n_vertices, 0);
    for (const Index i : in_.loaded) held_[i] = 1;
    if (limiting_held()) return;
    check(x1_);
    for (const Index t : beyond_) given_up_[in_.cloth->strain_limit_of[t]] = 1;
    for (Index t = 0; t < in_.cloth->triangles.rows(); ++t)
      if (const Index row = in_.cloth->strain_limit_of[t]; row >= 0 && given_up_[row])
        for (int c = 0; c < 3; ++c) held_[in_.cloth->triangles(t, c)] = 1;
  }

  // Moves each cloth back to its positions before the sweeps if, after the sweeps, it exceeds its
  // limits and its excess is not smaller than before. If scripted motion leaves the limits no
  // room, sweeps only concentrate strain in corners. Limit phases then spread the strain again in
  // the next part, with large forces. If limits act in the solve, a cloth that exceeds its limits
  // both at the start of the part and after the sweeps is therefore moved back even if its excess
  // is smaller. Returns whether any cloth is moved back.
  bool take_back(const Points& wanted) {
    std::vector<std::uint8_t> worse(in_.cloth->strain_limits.size(), 0), stayed = worse;
    if (in_.limits_in_solve) {
      check(*in_.x0);
      for (const Index t : beyond_) stayed[in_.cloth->strain_limit_of[t]] = 1;
    }
    check(wanted);
    const std::vector<double> before = squares_;
    check(x1_);
    for (const Index t : beyond_) {
      const Index row = in_.cloth->strain_limit_of[t];
      worse[row] = stayed[row] || squares_[row] >= before[row];
    }
    for (Index t = 0; t < in_.cloth->triangles.rows(); ++t)
      if (const Index row = in_.cloth->strain_limit_of[t]; row >= 0 && worse[row])
        for (int c = 0; c < 3; ++c)
          x1_.row(in_.cloth->triangles(t, c)) = wanted.row(in_.cloth->triangles(t, c));
    return std::any_of(worse.begin(), worse.end(), [](std::uint8_t w) { return w != 0; });
  }

  // Stores the certified state if its excess is the least so far. The stored state is used if no
  // certified state satisfies the limits. Must be called only after check(x1_).
  void keep_best() {
    const double excess = std::accumulate(squares_.begin(), squares_.end(), 0.0);
    if (excess >= least_excess_) return;
    least_excess_ = excess;
    best_x1_ = x1_;
    best_bodies_ = bodies_;
    best_report_ = report_;
  }

  void certify() {
    target_ = x1_;
    const bool keeps_energy = in_.limiter && !in_.repelled;
    const FreeBodies before = keeps_energy ? bodies_ : FreeBodies();
    const Points at_rest = keeps_energy ? report_.at_rest : Points();
    CertifyReport done = in_.collision->certify(*in_.collision_team, motion(), x1_, bodies_);
    const bool may_move = done.impacts > 0;
    withhold_at_rest(done.withheld);
    if (may_move && keeps_energy) keep_energy_of_impacts(before, at_rest);
    done.impacts += report_.certified.impacts;
    done.merge(report_.certified.withheld);
    report_.certified = std::move(done);
    for (Index i = 0; may_move && i < in_.cloth->n_vertices; ++i)
      if (x1_.row(i) != target_.row(i)) report_.touched.push_back(i);
    ++report_.rounds;
  }

  // Returns mode k (weft, warp, shear) of a triangle with this strain.
  Mode mode(const Vec3& strain, Index triangle, int k) const {
    const StrainLimit& limit = in_.cloth->strain_limits[in_.cloth->strain_limit_of[triangle]];
    const std::array<double, 3> most = {limit.weft, limit.warp, limit.shear};
    const std::array<double, 3> least = {limit.weft_min, limit.warp_min, limit.least_shear()};
    const double above = strain[k] - most[k], below = least[k] - strain[k];
    return above >= below ? Mode{above, limit_margin(most[k])}
                          : Mode{below, limit_margin(least[k])};
  }

  // Stores in beyond_ the triangles that exceed their limits at x by more than the margin, and in
  // squares_ the sum of squared excesses for each entry of ClothModel::strain_limits. Returns
  // whether beyond_ has entries. Ignores cloths whose edges are limited instead, and cloths that
  // give_up() has marked.
  bool check(const Points& x) {
    const LimitReport seen = in_.limiter->measure(*in_.team, x);
    squares_ = seen.squares;
    const auto counts = [&](Index row) {
      return !in_.cloth->strain_limits[row].edge && !given_up_[row];
    };
    for (std::size_t row = 0; row < squares_.size(); ++row)
      if (!counts(static_cast<Index>(row))) squares_[row] = 0.0;
    beyond_.clear();
    for (const Index element : seen.broken_elements())
      if (counts(in_.cloth->strain_limit_of[element])) beyond_.push_back(element);
    return !beyond_.empty();
  }

  // Moves the corners of triangles that exceed their limits back towards the start of the part,
  // until no triangle exceeds its limits or no corner can move, in at most max_passes passes.
  // Returns false if no corner has moved.
  bool fall_back() {
    const Points wanted = x1_;
    bool any = false;
    for (int pass = 0; pass < max_passes && !beyond_.empty(); ++pass) {
      // pairs (vertex, fraction of its displacement that it keeps)
      std::vector<std::pair<Index, double>> shares;
      for (const Index t : beyond_) {
        const Corners2 rest = in_.cloth->corners[t];
        const Vec3 strain0 = corotational_strain(in_.cloth->triangles, rest, *in_.x0, t);
        const Vec3 strain1 = corotational_strain(in_.cloth->triangles, rest, x1_, t);
        double share = 1.0;
        for (int k = 0; k < 3; ++k) {
          const Mode before = mode(strain0, t, k), now = mode(strain1, t, k);
          const double aim = aimed_at * now.margin;
          if (now.excess > now.margin && before.excess < aim)
            share = std::min(share, (aim - before.excess) / (now.excess - before.excess));
        }
        if (pass >= max_passes / 2) share *= 0.5;
        // Skips triangles with a prescribed corner, because this corner cannot move back.
        bool free = true;
        for (int c = 0; c < 3; ++c)
          free = free && (*in_.inverse_mass)[in_.cloth->triangles(t, c)] > 0.0;
        if (share < 1.0 && free)
          for (int c = 0; c < 3; ++c) shares.emplace_back(in_.cloth->triangles(t, c), share);
      }
      std::sort(shares.begin(), shares.end());  // smallest share of each vertex first
      Index last = -1;
      bool moved = false;
      for (const auto& [vertex, share] : shares) {
        if (vertex == last) continue;
        last = vertex;
        x1_.row(vertex) = in_.x0->row(vertex) + share * (x1_.row(vertex) - in_.x0->row(vertex));
        moved = true;
      }
      if (!moved) break;
      any = true;
      check(x1_);
    }
    std::vector<WithheldMotion> back;
    for (Index i = 0; i < in_.cloth->n_vertices; ++i) {
      if (wanted.row(i) == x1_.row(i)) continue;
      back.push_back({i, (wanted.row(i) - x1_.row(i)).transpose(), 1.0 / (*in_.inverse_mass)[i]});
      report_.withheld_for_limits += (wanted.row(i) - x1_.row(i)).norm();
    }
    withhold_at_rest(back);
    report_.certified.merge(back);
    report_.fallbacks += any;
    return any;
  }

  const ConstrainInputs& in_;
  Points& x1_;
  FreeBodies& bodies_;
  ConstrainReport report_;
  Points target_;                       // positions that the latest certification received
  std::vector<Index> beyond_;           // triangles that the latest check() has found
  std::vector<double> squares_;         // (limits) sums of squared excesses in the latest check()
  std::vector<std::uint8_t> given_up_;  // (limits) 1: marked by give_up()
  std::vector<std::uint8_t> held_;      // (n) 1: limiting must not move the vertex
  double least_excess_ = std::numeric_limits<double>::infinity();
  Points best_x1_;
  FreeBodies best_bodies_;
  ConstrainReport best_report_;
};

}  // namespace

ConstrainReport constrain(const ConstrainInputs& inputs, Points& x1, FreeBodies& bodies) {
  return Constraining(inputs, x1, bodies).run();
}

}  // namespace loomstone
