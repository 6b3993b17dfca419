// Explicit bending forces in a step of an implicit scheme.
#pragma once

#include "core/base/bytes.h"
#include "core/base/own_rows.h"
#include "core/cloth/cloth_state.h"
#include "core/cloth/elasticity.h"
#include "core/parallel/team.h"

namespace loomstone {

class ExplicitBending {
 public:
  // If `second_order` is true and the forces at the start of the last step are known, the forces at
  // the starts of the last step and of this step are extrapolated to SchemeCoefficients::time.
  // Otherwise, the forces at the start of this step are used. With these alone, midpoint and BDF-2
  // would have order 1 and amplify oscillations more.
  explicit ExplicitBending(bool second_order) : second_order_(second_order) {}

  // Rows [begin, end) that receive forces, length of the step [s] and SchemeCoefficients::time [s].
  struct Step {
    Index begin, end;
    double length, time;
  };
  // Adds the forces to the rows of `force` [N]. If the scheme is of second order, also stores the
  // forces at the start of this step in `state` for the next step. Does nothing if bending is
  // implicit.
  void add(const Team& team, const Step& step, Elasticity& elasticity, ClothState& state,
           RowsOut force) {
    if (elasticity.implicit_bending()) return;
    const Index n = static_cast<Index>(state.x.rows());
    if (now_.rows() != n) now_ = Points::Zero(n, 3);  // rows of other ranks stay zero
    const auto each_row = [&](auto&& visit) {
      parallel_for(team, step.end - step.begin, [&](Index i) { visit(step.begin + i); });
    };
    each_row([&](Index row) { now_.row(row).setZero(); });
    elasticity.add_explicit_bending(team, state.x, state.v, step.begin, step.end, now_);
    const bool extrapolate = second_order_ && state.previous_bending.rows() == n;
    const double share = step.time / state.last_length(step.length);
    each_row([&](Index row) {
      Eigen::RowVector3d at_time = now_.row(row);
      if (extrapolate) at_time += share * (now_.row(row) - state.previous_bending.row(row));
      force.row(row) += at_time;
    });
    if (second_order_) state.previous_bending = now_;
  }
  std::size_t bytes() const { return bytes_of(now_); }

 private:
  bool second_order_;
  Points now_;  // (n x 3) forces at the start of the step [N]
};

}  // namespace loomstone
