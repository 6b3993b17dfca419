// Field of a rigid source of many parts at many points: the space around it is divided once, in its
// own axes, into cubes that shrink towards its parts. In each the field of all parts but the
// nearest is one expansion about its middle, found as in treecode.h [GreengardRokhlin1987,
// Dehnen2002]; the nearest parts are summed exactly, eight at a time.
#pragma once

#include "core/magnetics/fast_sums/source_groups.h"

namespace loomstone {

class ExpandedField {
 public:
  // tolerance: of field and gradient, of the largest at the distance of a point from the source
  // [1]; in [3e-7, 0.1].
  ExpandedField(std::unique_ptr<SourceGroups> source, double tolerance);
  // mu0 H [T] and its gradient [T/m], as of a Source; a point's value does not depend on the points
  // beside it.
  void field_and_gradient_block(const double* points, Index n, double* field,
                                double* gradient) const;
  void field_block(const double* points, Index n, double* field) const;
  void gradient_block(const double* points, Index n, double* gradient) const;

  struct Cube {
    Vec3 centre;
    double half;               // of its edge [m]
    Index child = -1;          // the first of eight, or a leaf
    Index local = -1;          // of a leaf: its expansion
    Index begin = 0, end = 0;  // of a leaf: its nearest groups
  };
  const std::vector<Cube>& cubes() const { return cubes_; }
  Index leaf_at(const Vec3& point) const;  // -1: beyond the cubes

 private:
  struct Cluster {  // of parts
    Vec3 centre;
    double radius;  // of the ball about it that holds them [m]
    Index children[2] = {-1, -1};
    Index group = -1;  // of a leaf: its parts
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
  std::vector<Cluster> clusters_;    // the first holds all parts
  std::vector<double> moments_;      // by clusters
  std::vector<double> group_radii_;  // of their clusters [m]
  std::vector<Cube> cubes_;
  std::vector<double> locals_;
  std::vector<Index> nearest_;  // groups of the leaves, end to end
};

}  // namespace loomstone
