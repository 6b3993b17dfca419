// A hard magnet with many faces. Its field comes from an octree of local expansions
// (expanded_field.h), which is built only once, because the magnet is rigid and its magnetisation
// is constant.
#pragma once

#include "core/magnetics/fast_sums/expanded_field.h"

namespace loomstone {

class ExpandedMesh final : public Source {
 public:
  // `tolerance` is the tolerated error of field and gradient at a point, relative to their largest
  // values at the same distance from the surface [1]. It must be in [3e-7, 0.1].
  ExpandedMesh(std::shared_ptr<const Polyhedron> mesh, double tolerance);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override {
    field_.gradient_block(points, n, gradient);
  }
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
  // Position of a cube relative to the surface; cut: the surface may pass through the cube.
  enum class Place { outside, inside, cut };

  void add_polarization(const double* points, Index n, double* field) const;

  std::shared_ptr<const Polyhedron> mesh_;
  ExpandedField field_;
  std::vector<Place> places_;  // place of each cube of the octree; meaningful for leaf cubes only
};

}  // namespace loomstone
