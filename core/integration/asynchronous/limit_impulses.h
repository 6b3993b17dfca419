// Strain limits by impulses, [Thomaszewski2010], (4.27)-(4.30). At an event of a triangle, the
// velocities of its corners are changed to bring its strain at its next event within bounds. If its
// present strain is outside a second set of bounds, which are wider by default, positions are
// changed as well. There is one correction per event, without iterations. If no corner is
// prescribed, corrections conserve linear momentum. They do not conserve energy.
#pragma once

#include <vector>

#include "core/cloth/cloth_model.h"
#include "core/cloth/limits/limit_elements.h"
#include "core/integration/options.h"
#include "core/parallel/team.h"

namespace loomstone {

class LimitImpulses {
 public:
  LimitImpulses(const ClothModel& model, const Asynchronous& options);

  // Corrects the positions x and velocities v of the corners of a triangle. `step` is the time from
  // now to the next event of the triangle [s].
  void correct(Index triangle, double step, Points& x, Points& v);
  // Corrects, one after another, the listed triangles whose strain, as computed on entry, is out of
  // bounds or would be out of bounds at their next event. `steps` (m) contains the time from now to
  // the next event of each triangle [s].
  void correct(const Team& team, const std::vector<Index>& triangles, const Vector& steps,
               Points& x, Points& v);

 private:
  using Corners = double[9];
  // Moves the corners x of a triangle in one pass, to bring its strain within the bounds of its
  // limit. Returns false if no corner has moved.
  bool limit(Index triangle, const std::vector<limit::Bounds>& bounds, Corners& x) const;
  bool limit_edges(Index triangle, double longest, Corners& x) const;
  bool exceeds(Index triangle, double step, const Points& x, const Points& v) const;

  const ClothModel& model_;
  LimitElements elements_;
  std::vector<Index> slot_of_;  // (m) slot of each triangle in LimitElements; -1: no limits
  // (limits) Bounds of the strain at the next event, and of the present strain. The bound of a
  // limit on edges is in high[0].
  std::vector<limit::Bounds> predicted_, present_;
  std::vector<std::uint8_t> by_edges_;  // (limits) 1: limits the strain of edges
  std::vector<std::uint8_t> exceeds_;
};

}  // namespace loomstone
