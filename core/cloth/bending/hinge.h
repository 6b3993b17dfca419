// Hinges are the interior edges of a mesh. A HingeSet computes the dihedral angle at each hinge,
// its rate and its gradient [Bridson2003], and converts hinge moments to vertex forces. The angle
// lies in [-pi, pi]. If a fold passes through itself, the angle jumps between pi and -pi.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/aligned.h"
#include "core/base/bytes.h"
#include "core/base/own_rows.h"
#include "core/base/types.h"
#include "core/mesh/adjacency.h"
#include "core/parallel/team.h"

namespace loomstone {

// Scratch memory for angles, rates and gradients at given positions and velocities. HingeSet
// documents the layout.
struct HingeValues {
  AlignedDoubles difference;              // theta minus rest angle [rad]
  AlignedDoubles half_sine, half_cosine;  // sine and cosine of theta / 2
  AlignedDoubles rate;                    // [rad/s]
  AlignedDoubles gradient;                // u = d theta / d x [rad/m]

  // Input from which the values were computed: the positions of those vertices that belong to
  // hinges, and the list of batches.
  Points x;
  std::vector<Index> batches;
  bool has_gradient = false;

  std::size_t bytes() const {
    return bytes_of(difference, half_sine, half_cosine, rate, gradient, x, batches);
  }
};

// Scratch memory for a range of rows: the batches that contain its hinges, and the hinges of each
// chunk of rows_per_block rows.
struct HingeRange {
  Index begin = -1, end = -1;
  std::vector<Index> batches;
  // Start of each chunk in `hinges`, and the hinges of each chunk, ascending.
  std::vector<Index> chunk_start, hinges;
  // (hinges x 4) row of each vertex within the chunk; rows_per_block if the vertex lies outside it.
  std::vector<std::uint8_t> places;

  std::size_t bytes() const { return bytes_of(batches, chunk_start, hinges, places); }
};

// The hinges of a mesh with their rest angles. Kernels process batches of eight hinges. In
// HingeValues, scalars of hinge e are at index e. Component k of the gradient with respect to
// vertex j of hinge e is at index 16 e + 4 j + k.
class HingeSet {
 public:
  HingeSet() = default;
  // `rest_angles` has one entry per hinge [rad].
  HingeSet(Index n_vertices, std::vector<Hinge> hinges, std::vector<double> rest_angles);

  Index n_hinges() const { return static_cast<Index>(hinges_.size()); }
  Index n_batches() const { return (n_hinges() + 7) / 8; }
  const std::vector<Hinge>& hinges() const { return hinges_; }
  const std::vector<double>& rest_angles() const { return rest_angles_; }
  // The hinges at each vertex. Item 4 e + j means that the vertex is the j-th vertex of hinge e.
  const Incidence& of_vertices() const { return of_vertices_; }

  // Fills `range` for rows [begin, end). Does nothing if `range` is already filled for these rows.
  void find_range(Index begin, Index end, HingeRange& range) const;

  // Computes the angles of the listed batches, the gradients u if with_gradient is true, and the
  // rates if v is given. Rates require with_gradient. Without v, values that were already computed
  // for these batches at the same positions are reused. The result is bitwise identical for any
  // list and any number of threads.
  void evaluate(const Team& team, const std::vector<Index>& batches, const Points& x,
                const Points* v, bool with_gradient, HingeValues& values) const;

  // Subtracts sum_e moment_e u_e,i from the force on each row i of the range. u_e,i is the gradient
  // of the angle of hinge e with respect to vertex i. Hinges are added in ascending order.
  void gather(const Team& team, const HingeValues& values, const AlignedDoubles& moment,
              const HingeRange& range, RowsOut force) const;

  // Number of hinges with a zero-area triangle. These hinges exert no force. `values` must contain
  // the gradients of all hinges.
  Index count_degenerate(const HingeValues& values) const;

  std::size_t bytes() const {
    return bytes_of(hinges_, rest_angles_, vertices_, rest_lanes_, of_vertices_, runs_);
  }

 private:
  bool keeps(const Points& x, const Points& kept) const;
  void keep(const Points& x, Points& kept) const;

  std::vector<Hinge> hinges_;
  std::vector<double> rest_angles_;
  std::vector<Index> vertices_;  // (batches x 4 x 8) hinge vertices
  AlignedDoubles rest_lanes_;    // (batches x 8) rest angles [rad]
  Incidence of_vertices_;
  std::vector<std::array<Index, 2>> runs_;  // ranges [begin, end) of vertices with hinges
  Index n_kept_ = 0;                        // number of vertices in runs_
};

// Returns the dihedral angle of each hinge at positions x [rad]; 0 for hinges with a zero-area
// triangle.
std::vector<double> measure_angles(const std::vector<Hinge>& hinges, const Points& x);

}  // namespace loomstone
