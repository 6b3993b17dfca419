// Detects and checks the data that users write to State between two steps, and sends them to all
// ranks.
#pragma once

#include <algorithm>

#include "core/base/bytes.h"
#include "core/parallel/row_layout.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// Records the kind of data that users have written since the last step. A checkpoint does not
// contain this record.
class UserWrites {
 public:
  // After this call, positions and velocities are compared before every step with those after the
  // preceding step, because users have views of the tables, through which they can write unnoticed.
  void watch(const State& state);
  bool watching() const { return watching_; }
  // Kind of data that users have written since the last step; Table: data other than velocities and
  // positions. If they have written data of several kinds, the last of these kinds in this list
  // counts.
  enum Kind { Nothing, Table, Velocities, Positions };
  void note(Kind kind) { written_ = std::max(written_, kind); }  // records a write

  // If watching(), throws InvalidInput for the first invalid entry. Otherwise, only setters can
  // have written, and they have checked their values.
  void check(const Model& model, const State& state) const;
  // If users have written anything on any rank, gathers the positions and velocities of cloth, the
  // forces on it and the targets of pins from the ranks that own their rows. Also broadcasts
  // overrides, poses, the target time, and the forces and torques on bodies from rank 0.
  // If watching(), Table always counts as written. Returns the Kind that counts for the data
  // written on all ranks, and forgets it. Collective.
  Kind settle(const RowLayout& layout, State& state);
  void forget() { written_ = Nothing; }  // must be called after the state is replaced
  std::size_t bytes() const { return bytes_of(x_, v_); }
  void remember(const State& state);  // copies positions and velocities if watching()

 private:
  bool watching_ = false;
  Kind written_ = Nothing;
  // (n x 3) Positions [m] and velocities [m/s] that remember() has copied; empty unless watching().
  Points x_, v_;
};

// Gathers cloth rows (n x 3) from the ranks that own them. Collective.
void gather_rows(const RowLayout& layout, Points& rows);

}  // namespace loomstone
