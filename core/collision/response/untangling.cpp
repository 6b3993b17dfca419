#include "core/collision/response/untangling.h"

#include <algorithm>

#include "core/collision/response/term_entries.h"

namespace loomstone {

namespace {

// Speed at which a piercing edge is moved relative to the triangle [thickness/s], and the largest
// motion at this speed in one step [thickness]. The speed is low compared with free motion, so that
// surfaces are not thrown apart. At this speed, a sheet that has passed 50 thicknesses through
// another returns in half a second if steps are no longer than 5 ms.
constexpr double speed = 100.0, longest = 0.5;
// Largest relative acceleration of edge and triangle that a term causes [m/s^2]. Our choice.
// Stronger forces at neighbouring piercings work against each other and against the membrane:
// without this bound, crossed sheets with a membrane stiffness of 1e5 N/m take up to twice as long
// to part.
constexpr double largest_acceleration = 1000.0;

// Returns the distance by which the edge moves along `way_out` relative to the triangle in this
// step [m]. The edge moves at `speed`, but by at most `longest`. If the surfaces retract faster,
// the edge moves with them.
double way_in_step(const Piercing& piercing, const RetractedMotion& motion, double step) {
  const double way = std::min(speed * step, longest) * piercing.thickness;
  if (motion.velocity.rows() == 0) return way;
  Vec3 velocity = Vec3::Zero();
  for (std::size_t i = 0; i < piercing.vertices.size(); ++i)
    velocity += piercing.weights[i] * motion.velocity.row(piercing.vertices[i]).transpose();
  return std::max(way, step * piercing.way_out.dot(velocity));
}

// Returns the stiffness of the spring that moves the edge by `way` [N/m].
double spring_stiffness(const CollisionModel& model, const Piercing& piercing, double way,
                        const Vector& inverse_mass) {
  double inverse = 0.0;  // sum of w^2 / m [1/kg]
  for (int i = 0; i < 5; ++i)
    inverse += piercing.weights[i] * piercing.weights[i] * inverse_mass[piercing.vertices[i]];
  return std::min(model.contact_stiffness, largest_acceleration / (inverse * way));
}

}  // namespace

void untangling_terms(const CollisionModel& model, const Tangle& tangle,
                      const ContactInputs& inputs, ExtraTerms& terms) {
  if (tangle.empty()) return;
  const Points v0 = inputs.v0.all(static_cast<Index>(inputs.x0.rows()));
  const RetractedMotion motion =
      retracted_motion(model, tangle, inputs.inverse_mass, inputs.x0, v0, inputs.step);
  for (const Piercing& p : tangle.piercings) {
    if (p.way_out.isZero(0.0)) continue;
    ExtraTerm term;
    set_entries(model, p.vertices, p.weights, inputs, term);
    if (term.n_entries == 0) continue;
    // The term is a spring along `way_out` whose force vanishes after a displacement by `way`.
    const double way = way_in_step(p, motion, inputs.step);
    const double stiffness = spring_stiffness(model, p, way, inputs.inverse_mass);
    term.hessian = stiffness * p.way_out * p.way_out.transpose();
    term.gradient = -stiffness * way * p.way_out;
    terms.push_back(term);
  }
  for (Index v = 0; v < motion.acceleration.rows(); ++v) {
    if (motion.acceleration.row(v).isZero(0.0)) continue;
    ExtraTerm term;
    term.entries[0] = {model.rows.row[v], false, 1.0, Vec3::Zero()};
    term.n_entries = 1;
    term.gradient = -motion.acceleration.row(v).transpose() / inputs.inverse_mass[v];
    terms.push_back(term);
  }
}

std::vector<ImpulseContact> untangling_impulses(const Tangle& tangle, const RetractedMotion& motion,
                                                const Impulses& impulses, const Points& x0,
                                                const Points& x1, double step) {
  std::vector<ImpulseContact> all;
  for (const Piercing& p : tangle.piercings) {
    if (p.way_out.isZero(0.0)) continue;
    ImpulseContact c;
    c.vertices = p.vertices;
    c.weights = p.weights;
    c.normal = p.way_out;
    if (!impulses.prepare(c, x0, x1, 0.0)) continue;
    Vec3 start = Vec3::Zero(), travel = Vec3::Zero();
    for (int i = 0; i < 5; ++i) {
      start += p.weights[i] * x0.row(p.vertices[i]).transpose();
      travel += p.weights[i] * (x1.row(p.vertices[i]) - x0.row(p.vertices[i])).transpose();
    }
    const double way = way_in_step(p, motion, step);
    c.target = c.normal.dot(start) + way;
    c.largest_change = travel.norm() + way;
    all.push_back(c);
  }
  return all;
}

}  // namespace loomstone
