// Bending evaluated in groups of triangles. In nested steps, a group contains the triangles of one
// level or, without damping, also those of finer levels. In a queue of events, it is a single
// triangle or a run of triangles with the same step.
#pragma once

#include <memory>
#include <vector>

#include "core/cloth/cloth_model.h"
#include "core/parallel/team.h"

namespace loomstone {

// The triangles of a cloth that resists bending, and the edges of their mesh.
struct BendingMesh {
  BendingElement element;
  BendingSetup setup;
  EdgeTable edges;
  std::vector<Index> triangles;  // index in the model of each triangle of the cloth

  BendingMesh(const ClothModel& model, const ClothModel::BendingPart& part);
};

// The bending of a group of triangles whose forces act together in each event of the group.
class BendingGroup {
 public:
  // `acting` lists triangles of the mesh in ascending order. `factors` has one factor for the
  // forces of each of these triangles; empty: all factors are 1.
  BendingGroup(const BendingMesh& mesh, const std::vector<Index>& acting,
               const std::vector<double>& factors = {});

  const std::vector<Index>& vertices() const { return vertices_; }
  double eigenvalue(const Vector& mass) const;  // largest eigenvalue of M^-1 K at rest [1/s^2]
  double damping() const { return damping_; }   // largest bending damping beta [s]

  // A kick by the impulses of the forces over the time h [s]. If `start` is true, damping forces
  // depend on the present velocities. Otherwise, they depend on the mean velocities since the last
  // kick, which took place `since` [s] ago.
  struct Kick {
    double h, since;
    bool start;
  };
  // Adds the impulses of the forces at x, times inverse_mass, to the velocities v (n x 3).
  void kick(const Team& team, const Kick& kick, const Vector& inverse_mass, const Points& x,
            Points& v);
  // Positions of vertices() at the last kick [m]; used only with damping.
  Points& last() { return last_; }

 private:
  bool known_at(const Points& x) const;

  std::vector<Index> vertices_;
  std::unique_ptr<Bending> bending_;
  double damping_ = 0.0;
  bool known_ = false;  // true: force_ contains the forces at x_
  Points x_, last_, rate_, force_;
};

// Returns the longest steps h (m) that bending alone permits, for the given `safety` [s]. A patch
// is a run of 64 consecutive triangles, or fewer at the end of the mesh. All triangles of a patch
// have the same step, which satisfies h (h + 2 beta) lambda = 4 safety^2. For the bending of the
// patch and of the triangles next to it, lambda [1/s^2] is the largest eigenvalue of M^-1 K, and
// beta [s] is the largest damping. The step of triangles without bending is infinite.
Vector bending_steps(const ClothModel& model, const std::vector<BendingMesh>& meshes,
                     double safety);

// Returns, for each triangle, the mean of `steps` (m) [s] over its run of 64 consecutive triangles
// of the model. The last run may be shorter. With these means, few triangles have neighbours with a
// different step.
Vector mean_of_patches(const Vector& steps);

// Groups of the triangles of all bending meshes, by level. Groups of undamped meshes also include
// the triangles of finer levels, so at most one group of an undamped mesh acts in an event, and it
// evaluates each bending angle once. The forces of the triangles of finer levels are multiplied by
// the step of their level divided by the step of the group.
class LevelGroups {
 public:
  LevelGroups() = default;
  LevelGroups(const std::vector<BendingMesh>& meshes, const std::vector<std::uint8_t>& levels);

  // for_all() calls visit(group, level) for every group, where `level` determines the step of the
  // group. for_event() does so only for the groups that act in an event of the levels >= first.
  template <class Visit>
  void for_all(Visit&& visit) {
    for (Member& member : groups_) visit(member.group, member.level);
  }
  template <class Visit>
  void for_event(int first, Visit&& visit) {
    for (Member& member : groups_)
      if (member.coarser < first && first <= member.level) visit(member.group, member.level);
  }

 private:
  struct Member {
    BendingGroup group;
    // `level` is the group's own level. In events that include the level `coarser`, the group of
    // that level acts instead; -1: there is no such group.
    int level, coarser;
  };
  std::vector<Member> groups_;
};

}  // namespace loomstone
