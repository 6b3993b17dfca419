// Bending in parts, each with the triangles of one level of nested steps and their neighbours.
#pragma once

#include <memory>
#include <vector>

#include "core/cloth/cloth_model.h"
#include "core/parallel/team.h"

namespace loomstone {

// The triangles of the model with one bending element, and the edges of their mesh.
struct BendingMesh {
  const ClothModel::BendingPart& part;
  EdgeTable edges;
  std::vector<Index> triangles;  // index in the model of each triangle of the part

  BendingMesh(const ClothModel& model, const ClothModel::BendingPart& part);
};

// The bending of some triangles of a mesh, which act at the same times.
class BendingGroup {
 public:
  // acting: triangles of the part, ascending
  BendingGroup(const BendingMesh& mesh, const std::vector<Index>& acting);

  const std::vector<Index>& vertices() const { return vertices_; }
  double eigenvalue(const Vector& mass) const;  // largest of M^-1 K at rest [1/s^2]
  double damping() const { return damping_; }   // largest beta [s]

  // A kick of length h [s]. Damping acts on the velocities at its start, or on the mean velocities
  // over the time since the last kick.
  struct Kick {
    double h, since;
    bool start;
  };
  // Adds the forces at x times inverse_mass times h to v (n x 3).
  void kick(const Team& team, const Kick& kick, const Vector& inverse_mass, const Points& x,
            Points& v);
  // Positions of the vertices at the last kick; used with damping only.
  Points& last() { return last_; }

 private:
  std::vector<Index> vertices_;
  std::unique_ptr<Bending> bending_;
  double damping_ = 0.0;
  Points x_, last_, rate_, force_;
};

// Longest steps of bending on its own (m) [s]: h (h + 2 beta) lambda = 4 safety^2. Triangles of a
// patch have one lambda, that of the bending of the patch and its neighbours. Infinity without
// bending.
Vector bending_steps(const ClothModel& model, const std::vector<BendingMesh>& meshes,
                     double safety);

// Gives the triangles of each patch the shortest step of the patch, so that few triangles have
// neighbours with other steps.
void equalise_patches(Vector& steps);

// Groups of all bending parts by the level of their triangles.
struct LevelGroups {
  std::vector<BendingGroup> groups;
  std::vector<std::uint8_t> level;  // (groups)

  LevelGroups() = default;
  LevelGroups(const std::vector<BendingMesh>& meshes, const std::vector<std::uint8_t>& levels);
};

}  // namespace loomstone
