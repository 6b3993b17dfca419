// Field of a hard magnet with many faces at many points: the space around it is divided once, in its own axes, into cubes
// that shrink towards its surface. In each the field of all faces but the nearest is one expansion about its middle, found
// as in tree_sums.h [GreengardRokhlin1987, Dehnen2002]; the nearest faces are summed exactly, eight at a time. As the magnet
// is rigid and hard, this serves for the whole of a run.
#pragma once

#include "core/magnetics/cartesian_expansion.h"
#include "core/magnetics/polyhedron.h"

namespace loomstone {

class ExpandedMesh final : public Source {
 public:
  // tolerance: of field and gradient, of the largest at the distance of a point from the surface [1]; in [3e-7, 0.1].
  ExpandedMesh(std::shared_ptr<const Polyhedron> mesh, double tolerance);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  void field_and_gradient_block(const double* points, Index n, Quantity quantity, double* field,
                                double* gradient) const override;
  void potential_block(const double* points, Index n, double* potential) const override {
    mesh_->potential_block(points, n, potential);
  }
  double radius() const override { return mesh_->radius(); }
  Vec3 moment() const override { return mesh_->moment(); }
  std::optional<std::pair<Vec3, Vec3>> box() const override { return mesh_->box(); }
  double depth(const Vec3& point) const override { return mesh_->depth(point); }
  std::vector<Panel> panels() const override { return mesh_->panels(); }
  std::vector<Panel> surface() const override { return mesh_->surface(); }

 private:
  struct Cluster {  // of faces
    Vec3 centre;
    double radius;                 // of the ball about it that holds the faces [m]
    Index children[2] = {-1, -1};
    Index group = -1;              // of a leaf: its faces
  };
  enum class Place { outside, inside, cut };
  struct Cube {
    Vec3 centre;
    double half;                   // of its edge [m]
    Index child = -1;              // the first of eight, or a leaf
    Index local = -1;              // of a leaf: its expansion
    Index begin = 0, end = 0;      // of a leaf: its nearest faces
    Place place = Place::outside;
  };
  struct Sorted {
    std::vector<CartesianExpansion::Far> far;
    std::vector<Index> near;
  };

  void group_faces();
  Index add_cluster(const std::vector<Vec3>& corners, std::vector<Index>& faces, std::size_t begin, std::size_t end);
  void add_group(const std::vector<Vec3>& corners, const Index* faces, Index n);
  void divide(Index cube, const std::vector<Index>& candidates, const std::vector<double>& inherited);
  Sorted sorted(const Vec3& centre, double radius, const std::vector<Index>& candidates, bool leaf) const;
  Place place_of(const Cube& cube) const;
  Index leaf_at(const Vec3& point) const;  // -1: beyond the cubes

  std::shared_ptr<const Polyhedron> mesh_;
  CartesianExpansion expansion_;
  double opening_;
  std::vector<Cluster> clusters_;          // the first holds all faces
  std::vector<double> moments_;            // by clusters
  std::vector<double> groups_;             // tables of eight faces each
  std::vector<double> group_radii_;        // of their clusters [m]
  std::vector<Cube> cubes_;
  std::vector<double> locals_;
  std::vector<Index> nearest_;             // groups of the leaves, end to end
};

}  // namespace loomstone
