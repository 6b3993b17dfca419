// Field of a rigid source with many parts (charged faces or dipoles), evaluated at many points by
// an octree of local expansions. The octree is built once in the axes of the source and refined
// towards the parts. Each leaf cube has one local expansion for the field of all parts except the
// nearest, from multipole-to-local translations as in treecode.h ([GreengardRokhlin1987],
// [Dehnen2002]). The nearest parts are summed exactly, eight at a time. Outside the octree, a
// multipole expansion of the whole source is used.
#pragma once

#include "core/magnetics/fast_sums/source_groups.h"

namespace loomstone {

class ExpandedField {
 public:
  // `tolerance` is the tolerated error of field and gradient at a point, relative to their largest
  // values at the same distance from the source [1]. It must be in [3e-7, 0.1].
  ExpandedField(std::unique_ptr<SourceGroups> source, double tolerance);
  // The next three functions compute mu0 H [T], its gradient [T/m] or both at one block of points
  // (see points_per_block). The value at a point does not depend on the other points.
  void field_and_gradient_block(const double* points, Index n, double* field,
                                double* gradient) const;
  void field_block(const double* points, Index n, double* field) const;
  void gradient_block(const double* points, Index n, double* gradient) const;

  struct Cube {
    Vec3 centre;
    double half;               // half the edge length [m]
    Index child = -1;          // first of eight children, -1 for a leaf
    Index local = -1;          // index of a leaf's local expansion; -1 for other cubes
    Index begin = 0, end = 0;  // range of a leaf's near groups in `nearest_`
  };
  const std::vector<Cube>& cubes() const { return cubes_; }
  // Returns the index of the leaf cube that contains a point, or -1 outside the octree.
  Index leaf_at(const Vec3& point) const;

 private:
  struct Cluster {  // node of a binary tree of the parts
    Vec3 centre;
    double radius;  // radius of the bounding sphere about the centre [m]
    Index children[2] = {-1, -1};
    Index group = -1;  // index of the group of a leaf, -1 for other nodes
  };
  struct Sorted {
    std::vector<TaylorExpansion::Far> far;
    std::vector<Index> near;
  };

  Index add_cluster(std::vector<Index>& parts, std::size_t begin, std::size_t end);
  void divide(Index cube, const std::vector<Index>& candidates,
              const std::vector<double>& inherited);
  Sorted sorted(const Vec3& centre, double radius, const std::vector<Index>& candidates,
                bool leaf) const;

  std::unique_ptr<SourceGroups> source_;
  TaylorExpansion expansion_;
  double opening_;
  std::vector<Cluster> clusters_;    // the first one is the root
  std::vector<double> moments_;      // multipole moments of each cluster
  std::vector<double> group_radii_;  // radius of each group [m]
  std::vector<Cube> cubes_;          // nodes of the octree, the root first
  std::vector<double> locals_;       // local expansion of each leaf
  std::vector<Index> nearest_;       // groups near each leaf
};

}  // namespace loomstone
