#include "core/collision/response/untangling.h"

#include <algorithm>

#include "core/collision/response/term_entries.h"

namespace loomstone {

namespace {

// Relative speed along `way_out` [thickness/s], and largest motion in one step [thickness]. The
// speed is low compared with free motion, so that surfaces are not thrown apart. A sheet that has
// passed through by 50 thicknesses returns within half a second.
constexpr double speed = 100.0, longest = 0.5;

double way_in_step(const Piercing& piercing, double step) {
  return std::min(speed * step, longest) * piercing.thickness;
}

}  // namespace

void untangling_terms(const CollisionModel& model, const Tangle& tangle,
                      const ContactInputs& inputs, ExtraTerms& terms) {
  for (const Piercing& p : tangle.piercings) {
    if (p.way_out.isZero(0.0)) continue;
    ExtraTerm term;
    set_entries(model, p.vertices, p.weights, inputs, term);
    if (term.n_entries == 0) continue;
    // A spring along `way_out` whose rest position is the target of this step.
    term.hessian = model.contact_stiffness * p.way_out * p.way_out.transpose();
    term.gradient = -model.contact_stiffness * way_in_step(p, inputs.step) * p.way_out;
    terms.push_back(term);
  }
}

std::vector<ImpulseContact> untangling_impulses(const Tangle& tangle, const Impulses& impulses,
                                                const Points& x0, const Points& x1, double step) {
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
    c.target = c.normal.dot(start) + way_in_step(p, step);
    c.largest_change = travel.norm() + way_in_step(p, step);
    all.push_back(c);
  }
  return all;
}

}  // namespace loomstone
