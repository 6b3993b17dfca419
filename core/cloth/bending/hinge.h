// Hinges: interior edges with the dihedral angle between their two triangles, its rate and its
// gradient [Bridson2003], and the gathering of moments about hinges into vertex forces. The angle
// lies in [-pi, pi]: a fold that passes +-pi (through itself) continues from the other side.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/aligned.h"
#include "core/base/types.h"
#include "core/mesh/adjacency.h"
#include "core/parallel/team.h"

namespace loomstone {

// Scratch: angles and gradients at some positions and velocities. HingeSet defines the entries.
struct HingeValues {
  AlignedDoubles difference;              // theta minus rest angle [rad]
  AlignedDoubles half_sine, half_cosine;  // of theta / 2 [1]
  AlignedDoubles rate;                    // [rad/s]
  AlignedDoubles gradient;                // u = d theta / d x [rad/m]

  // The positions and batches that the angles (and gradients) belong to.
  Points x;
  std::vector<Index> batches;
  bool has_gradient = false;
};

// Scratch: the batches that contain the hinges of some rows, and the hinges of each chunk of
// rows_per_block rows.
struct HingeRange {
  Index begin = -1, end = -1;
  std::vector<Index> batches;
  std::vector<Index> chunk_start, hinges;  // of each chunk, ascending
  // (hinges x 4) row of each vertex in the chunk; rows_per_block: the vertex is in another chunk
  std::vector<std::uint8_t> places;
};

// Model. Kernels compute batches of eight hinges. In HingeValues the scalars of hinge e are at e,
// component k of its gradient with respect to its vertex j is at 16 e + 4 j + k.
class HingeSet {
 public:
  HingeSet() = default;
  // rest_angles: one per hinge [rad]
  HingeSet(Index n_vertices, std::vector<Hinge> hinges, std::vector<double> rest_angles);

  Index n_hinges() const { return static_cast<Index>(hinges_.size()); }
  Index n_batches() const { return (n_hinges() + 7) / 8; }
  const std::vector<Hinge>& hinges() const { return hinges_; }
  const std::vector<double>& rest_angles() const { return rest_angles_; }
  // Item 4 hinge + j: the vertex is the hinge's j-th.
  const Incidence& of_vertices() const { return of_vertices_; }

  // Batches with a hinge that touches rows [begin, end), ascending, and the chunks; computed only
  // when the range changes.
  void find_range(Index begin, Index end, HingeRange& range) const;

  // Angles of the listed batches, gradients u if with_gradient, rates if v is given. Same bits for
  // any list and team. Values already known for the same positions are not computed again.
  void evaluate(const Team& team, const std::vector<Index>& batches, const Points& x,
                const Points* v, bool with_gradient, HingeValues& values) const;

  // force_i -= sum_e moment_e u_e,i on the rows of the range, hinges ascending.
  void gather(const Team& team, const HingeValues& values, const AlignedDoubles& moment,
              const HingeRange& range, Points& force) const;

  // Number of hinges with a triangle without area; they exert no force.
  Index count_degenerate(const HingeValues& values) const;

 private:
  std::vector<Hinge> hinges_;
  std::vector<double> rest_angles_;
  std::vector<Index> vertices_;  // (batches x 4 x 8)
  AlignedDoubles rest_lanes_;    // (batches x 8)
  Incidence of_vertices_;
};

// Angles of all hinges in the shape x [rad].
std::vector<double> measure_angles(const std::vector<Hinge>& hinges, const Points& x);

}  // namespace loomstone
