// Detects and checks what users write into State between two steps, and shares it among ranks.
#pragma once

#include <algorithm>

#include "core/parallel/row_layout.h"
#include "core/sim/model/model.h"
#include "core/sim/model/state.h"

namespace loomstone {

// Scratch between two steps; none of it decides the future.
class UserWrites {
 public:
  // From now on users hold views of the tables, which are compared before every step.
  void watch(const State& state);
  bool watching() const { return watching_; }
  // Kinds of writes since the last step; each kind includes those before it.
  enum Kind { Nothing, Table, Velocities, Positions };
  void note(Kind kind) { written_ = std::max(written_, kind); }  // through a call

  // Throws InvalidInput naming the first entry that cannot be simulated.
  void check(const Model& model, const State& state) const;
  // Takes every row from the rank that owns it and poses from rank 0. Returns what was written on
  // any rank. Collective.
  Kind settle(const RowLayout& layout, State& state);
  void remember(const State& state);  // the state a step left

 private:
  bool watching_ = false;
  Kind written_ = Nothing;
  Points x_, v_;  // (n x 3) as the last step left them, while watching
};

// Refreshes (n x 3) cloth rows from their owners. Collective.
void gather_rows(const RowLayout& layout, Points& rows);

}  // namespace loomstone
