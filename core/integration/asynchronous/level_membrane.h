// Membrane whose triangles are sorted by the levels of nested steps, finest first. Each level is a
// range of batches of eight triangles. The triangles that have an event at the same time are those
// of the finest levels, so they form the first batches.
#pragma once

#include <vector>

#include "core/cloth/cloth_model.h"
#include "core/integration/asynchronous/element_steps.h"

namespace loomstone {

class LevelMembrane {
 public:
  // Raises entries of `levels` (m) where necessary, so that all triangles of a batch have the same
  // level.
  LevelMembrane(const ClothModel& model, const ElementSteps& steps,
                const std::vector<LimitModes>& limits, std::vector<std::uint8_t>& levels);

  // Triangles of the levels >= first.
  std::vector<Index> triangles_from(int first) const;
  int finest() const { return static_cast<int>(batch_end_.size()) - 1; }
  // Finest level of the triangles at each vertex (n).
  const std::vector<std::uint8_t>& vertex_levels() const { return vertex_levels_; }

  // Computes the forces of the levels >= first at x. Viscous forces depend on the strain rate of
  // the velocities v. If v is null, they depend on the mean strain rate since the last call that
  // included the level. step_of (levels) contains the step of each level [s]. Without viscosity,
  // forces at the end of an interval are reused at the start of the next one if positions are the
  // same.
  void measure(const Team& team, int first, const Points& x, const Points* v,
               const std::vector<double>& step_of);
  // Returns, for each triangle (m), the highest phase in which each of its limit modes has been
  // since the last call; empty without a limit potential.
  std::vector<LimitPhases> take_phases();
  // Impulse on a vertex in an event of the levels >= first [N s]. Each triangle of these levels
  // contributes the step of its level times the sum of its force and its fraction of the load (3)
  // on the vertex [N].
  Vec3 impulse(Index vertex, int first, const double* load,
               const std::vector<double>& step_of) const {
    double sum[3] = {0.0, 0.0, 0.0};
    for (Index s = slot_start_[vertex]; s < slot_start_[vertex + 1]; ++s) {
      const Slot& slot = slots_[s];
      if (slot.level < first) break;
      const double* f = forces_.data() + slot.force;
      const double h = step_of[slot.level];
      for (int d = 0; d < 3; ++d) sum[d] += h * (f[8 * d] + slot.share * load[d]);
    }
    return {sum[0], sum[1], sum[2]};
  }

 private:
  // `order` lists the triangles in the order of the batches, as sort_by_level() returns it.
  LevelMembrane(const ClothModel& model, const ElementSteps& steps, std::vector<Index> order,
                const std::vector<std::uint8_t>& levels);

  struct Slot {
    Index force;   // index in forces_ of the x component; y and z follow with a stride of 8
    int level;     // level of the triangle
    double share;  // fraction of the vertex's mass that the triangle contributes [1]
  };
  void find_rates(const Team& team, int level, const Points& x, double step);

  Membrane membrane_;
  std::vector<Index> order_;    // triangles in the order of the batches
  std::vector<Index> batches_;  // indices of all batches: 0, 1, 2, ...
  // (levels) End of the batches of each level. Batches of the finest level come first.
  std::vector<Index> batch_end_;
  std::vector<Index> slot_start_;
  std::vector<Slot> slots_;  // triangles at each vertex, finest level first
  std::vector<std::uint8_t> vertex_levels_;
  std::vector<double> forces_;
  // Positions at the last call of measure() that computed the forces of all levels; unused if the
  // membrane is viscous.
  Points known_x_;
  // Bits of the limit phases that have been entered, see membrane::Tables; empty without a limit
  // potential.
  std::vector<std::uint8_t> entered_;
  // The next three members are used only if the membrane is viscous.
  // (levels) Vertices of the triangles of each level.
  std::vector<std::vector<Index>> vertices_of_;
  // (levels) Positions (n x 3) at the last event of each level [m].
  std::vector<Points> last_;
  // (n x 3) Mean velocities since the last event of a level [m/s]; see find_rates().
  Points rates_;
};

}  // namespace loomstone
