#include "core/magnetics/fast_sums/expanded_mesh.h"

#include <cmath>

namespace loomstone {

ExpandedMesh::ExpandedMesh(std::shared_ptr<const Polyhedron> mesh, double tolerance)
    : mesh_(std::move(mesh)), field_(std::make_unique<FaceGroups>(mesh_), tolerance) {
  for (const ExpandedField::Cube& cube : field_.cubes()) {
    const double radius = 1.000001 * std::sqrt(3.0) * cube.half,
                 depth = cube.child < 0 ? mesh_->depth(cube.centre) : 0.0;
    places_.push_back(depth > radius    ? Place::inside
                      : depth < -radius ? Place::outside
                                        : Place::cut);
  }
}

// Adds the polarization J at points inside the magnet, where B = mu0 H + J.
void ExpandedMesh::add_polarization(const double* points, Index n, double* field) const {
  for (Index i = 0; i < n; ++i) {
    const Vec3 point(points[i], points[n + i], points[2 * n + i]);
    const Index leaf = field_.leaf_at(point);
    if (leaf < 0 || places_[leaf] == Place::outside) continue;
    if (places_[leaf] == Place::inside || mesh_->depth(point) > 0.0)
      for (int c = 0; c < 3; ++c) field[c * n + i] += mesh_->polarization()[c];
  }
}

void ExpandedMesh::field_and_gradient_block(const double* points, Index n, Quantity quantity,
                                            double* field, double* gradient) const {
  field_.field_and_gradient_block(points, n, field, gradient);
  if (quantity == Quantity::flux_density) add_polarization(points, n, field);
}

void ExpandedMesh::field_block(const double* points, Index n, Quantity quantity,
                               double* field) const {
  field_.field_block(points, n, field);
  if (quantity == Quantity::flux_density) add_polarization(points, n, field);
}

}  // namespace loomstone
