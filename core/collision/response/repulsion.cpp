#include "core/collision/response/repulsion.h"

#include <algorithm>
#include <cmath>

#include "core/collision/response/impulses.h"
#include "core/collision/response/untangling.h"

namespace loomstone {

namespace {

// Distance at which contacts come to rest. It is slightly less than the thickness, so the features
// remain in contact.
constexpr double rest_gap = 0.999;  // as a fraction of the thickness
// Features whose distance is below `rest_gap` are pushed apart gradually. A step restores at most
// this fraction of the missing distance [Bridson2002], and no more than a spring with the contact
// stiffness would restore.
constexpr double largest_restored = 0.1;
constexpr int most_sweeps = 30;
constexpr double tolerance = 1e-4;  // of Impulses::solve(), relative to ImpulseContact::scale

}  // namespace

void repel(const CollisionModel& model, const MotionInputs& inputs,
           const std::vector<Contact>& contacts, double step, Points& x1, FreeBodies& bodies) {
  const Points& x0 = inputs.x0;
  RetractedMotion retracted;
  if (!inputs.tangle.retractions.empty()) {
    retracted =
        retracted_motion(model, inputs.tangle, inputs.inverse_mass, x0, (x1 - x0) / step, step);
    x1 += step * step * retracted.acceleration;
  }
  Impulses impulses(model, inputs.inverse_mass, bodies);
  std::vector<ImpulseContact> all;
  double scale = 0.0;
  for (const Contact& contact : contacts) {
    ImpulseContact c;
    c.meet(contact.vertices, contact.weights);
    c.normal = contact.normal;
    c.friction = contact.friction;
    if (!impulses.prepare(c, x0, x1, 0.0)) continue;
    Vec3 start = Vec3::Zero(), travel = Vec3::Zero();
    for (int i = 0; i < 4; ++i) {
      start += c.weights[i] * x0.row(c.vertices[i]).transpose();
      travel += c.weights[i] * (x1.row(c.vertices[i]) - x0.row(c.vertices[i])).transpose();
    }
    const double missing = rest_gap * contact.thickness - contact.distance;
    const double softly =
        std::min(largest_restored, step * step * model.contact_stiffness * c.normal_inverse_mass);
    c.target = c.normal.dot(start) + (missing > 0.0 ? softly * missing : missing);
    c.largest_change = travel.norm() + contact.thickness;
    scale = std::max(scale, travel.norm() + std::abs(c.target - c.normal.dot(start)));
    all.push_back(c);
  }
  for (ImpulseContact& c : untangling_impulses(inputs.tangle, retracted, impulses, x0, x1, step)) {
    scale = std::max(scale, c.largest_change);
    all.push_back(c);
  }
  for (ImpulseContact& c : all) c.scale = scale;
  if (scale > 0.0) impulses.solve(all, x0, x1, most_sweeps, tolerance);
}

}  // namespace loomstone
