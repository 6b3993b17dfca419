// Rigid bodies within an asynchronous step. A body and the cloth vertices attached to it move as
// one rigid body: impulses on the vertices act on the body. The common mass is larger than that of
// the vertices alone, so attachments do not shorten the steps of the triangles.
#pragma once

#include <vector>

#include "core/base/event_motion.h"
#include "core/integration/integrator.h"

namespace loomstone {

class AttachedBodies {
 public:
  // Begins an interval. Each body and its vertices get the common rigid motion that conserves their
  // momentum and angular momentum. Vertices that are not at their attachment points move to them
  // during the interval. `body_velocity` (rows as in finish()) contains the velocities that the
  // bodies would have after all impulses of the loads in the interval.
  void begin(const StepInputs& inputs, const Vector& mass, const Points& body_velocity,
             const Points& x, Points& v);
  // Ends the interval. Stores the velocities of the bodies in `body_velocity` (two rows for each
  // body: velocity [m/s] and angular velocity [rad/s]), and sets BodiesOfStep::end and with_cloth.
  void finish(const StepInputs& inputs, Points& body_velocity) const;

  // Applies the fraction `share` of the impulses that the loads give the body in the interval.
  void load(Index body, double share);
  // Transfers to a body the momentum that its vertices have received from impulses, and then sets
  // the velocities of the vertices to those that the motion of the body gives them. The positions
  // and the pose belong to the time `ahead` [s] after the impulses (negative: before). They are
  // changed, too, because they depend on the velocities.
  void absorb(Index body, double ahead, Points& x, Points& v);
  // Moves a body and its vertices for a duration of `time` [s].
  void drift(Index body, double time, Points& x, Points& v);

  // Vertices that are attached to a body.
  std::vector<Index> vertices(Index body) const;
  std::vector<EventBody>& all() { return bodies_; }
  Index size() const { return static_cast<Index>(bodies_.size()); }
  // Body to which a vertex is attached; -1: none.
  Index body_of(Index vertex) const { return body_of_.empty() ? -1 : body_of_[vertex]; }
  // Gives each body and all vertices attached to it the finest level (nested_steps.h) of these
  // vertices. A body without vertices gets level 0.
  void share_levels(std::vector<std::uint8_t>& vertex_levels);

 private:
  struct Tied {
    Index row;
    double mass;  // [kg]
    // Attachment point relative to the centre of mass of the body with its vertices, in body axes
    // [m].
    Vec3 local;
    // Vector from attachment point to vertex at the start of the interval, in world axes [m].
    Vec3 offset = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();  // last velocity that the body gave the vertex [m/s]
  };
  struct Own {
    std::vector<Tied> tied;
    // Centre of mass of the body alone, relative to that of the body with its vertices, in body
    // axes [m].
    Vec3 centre = Vec3::Zero();
    // Impulse [N s] and angular impulse [N m s] that the loads give the body in the interval.
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    // Velocities of the body when its vertices were last updated [m/s, rad/s].
    Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
    double elapsed = 0.0;  // time from the start of the interval to the present pose [s]
  };
  void join(Index body, Points& v);
  void place(Index body, Points* x, Points& v);

  // Each body together with its attached vertices: common mass, inertia and centre of mass.
  std::vector<EventBody> bodies_;
  std::vector<Own> own_;
  std::vector<Index> body_of_;  // (n) see body_of(); empty: nothing is attached
  double interval_ = 0.0;       // [s]
};

}  // namespace loomstone
