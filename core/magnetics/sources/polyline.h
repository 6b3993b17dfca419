// Field of a current along a polyline (Biot-Savart law).
#pragma once

#include <vector>

#include "core/magnetics/sources/source.h"

namespace loomstone {

class Polyline final : public Source {
 public:
  // `vertices` (n x 3) [m] are in order along the line. A positive current [A] flows from the first
  // to the last. The line is closed if the last vertex equals the first, or differs from it by at
  // most 1e-12 times the source's radius; it is then moved to the first. The field is infinite on
  // the wire, so distances from the wire in denominators are at least 1e-15 times the source's
  // radius.
  Polyline(Points vertices, double current);
  void field_block(const double* points, Index n, Quantity quantity, double* field) const override;
  void gradient_block(const double* points, Index n, double* gradient) const override;
  double radius() const override { return radius_; }
  Vec3 moment() const override;  // I/2 times the sum of a x b over the segments from a to b
  bool steady() const override { return closed(); }
  bool closed() const { return vertices_.row(0) == vertices_.row(vertices_.rows() - 1); }
  std::vector<Panel> panels() const override;
  SourceRecipe recipe() const override {
    return {"polyline", {{"vertices", vertices_}, {"current", current_}}, {}, {}};
  }
  const Points& vertices() const { return vertices_; }
  double current() const { return current_; }

 private:
  Points vertices_;
  double current_, radius_;
};

}  // namespace loomstone
