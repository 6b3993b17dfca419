#include "core/sim/step/user_writes.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "core/base/message.h"
#include "core/base/same_bits.h"

namespace loomstone {

namespace {

[[noreturn]] void refuse(const std::string& what, const Points& table, Index row,
                         const std::string& wanted) {
  std::ostringstream out;
  out << what << " must be " << wanted << ", got (" << table.row(row)
      << "); correct it before the next step";
  throw InvalidInput(out.str());
}

void check_rows(const Model& model, const Points& table, const char* name,
                const std::vector<std::uint8_t>* used) {
  if (table.allFinite()) return;
  for (std::size_t vertex = 0; vertex < model.row_of_vertex.size(); ++vertex) {
    const Index row = model.row_of_vertex[vertex];
    if ((used && !(*used)[row]) || table.row(row).allFinite()) continue;
    refuse(formatted("{} of vertex {} (row {})", name, vertex, row), table, row, "finite");
  }
}

void check_bodies(const Points& table, const char* name) {
  for (Index b = 0; b < table.rows(); ++b)
    if (!table.row(b).allFinite()) refuse(formatted("{} of body {}", name, b), table, b, "finite");
}

}  // namespace

void UserWrites::watch(const State& state) {
  if (watching_) return;
  watching_ = true;
  remember(state);
}

void UserWrites::check(const Model& model, const State& state) const {
  if (!watching_) return;  // setters have checked their values
  check_rows(model, state.cloth.x, "positions", nullptr);
  check_rows(model, state.cloth.v, "velocities", nullptr);
  check_rows(model, state.external_force, "external_forces", nullptr);
  check_bodies(state.body_force, "external_body_forces");
  check_bodies(state.body_torque, "external_body_torques");
  check_rows(model, state.pin_target, "pin_targets", &state.pin_override);
  for (std::size_t o = 0; o < state.pose_override.size(); ++o) {
    if (!state.pose_override[o]) continue;
    const std::string name = formatted(" of obstacle {}", o);
    const Index row = static_cast<Index>(o);
    if (!state.pose_position.row(row).allFinite())
      refuse("obstacle_positions" + name, state.pose_position, row, "finite");
    const double norm = state.pose_orientation.row(row).norm();
    if (!(std::abs(norm - 1.0) <= 1e-6))
      fail<InvalidInput>(
          "obstacle_orientations{} must be a unit quaternion (w, x, y, z), got norm {}; normalise "
          "it",
          name, norm);
  }
}

UserWrites::Kind UserWrites::settle(const RowLayout& layout, State& state) {
  if (watching_)
    note(!same_bits(x_, state.cloth.x)   ? Positions
         : !same_bits(v_, state.cloth.v) ? Velocities
                                         : Table);
  if (!layout.single()) {
    const Communicator& ranks = layout.communicator();
    written_ = static_cast<Kind>(ranks.maximum(written_));
    if (written_ != Nothing) {
      gather_rows(layout, state.cloth.x), gather_rows(layout, state.cloth.v);
      for (Points* table : {&state.external_force, &state.pin_target})
        if (ranks.maximum(table->rows()) > 0) gather_rows(layout, state.made(*table));
      const auto from_rank_0 = [&](auto& table) {
        ranks.broadcast(table.data(),
                        static_cast<std::size_t>(table.size()) * sizeof(*table.data()), 0);
      };
      from_rank_0(state.pin_override), from_rank_0(state.pose_override);
      from_rank_0(state.pose_position), from_rank_0(state.pose_orientation);
      from_rank_0(state.body_force), from_rank_0(state.body_torque);
      ranks.broadcast(&state.target_time, sizeof state.target_time, 0);
    }
  }
  remember(state);
  return std::exchange(written_, Nothing);
}

void UserWrites::remember(const State& state) {
  if (!watching_) return;
  x_ = state.cloth.x;
  v_ = state.cloth.v;
}

void gather_rows(const RowLayout& layout, Points& rows) {
  if (layout.single() || rows.rows() == 0) return;
  Points wide = Points::Zero(layout.n_rows(), 3);  // the layout also has rows of rigid bodies
  wide.topRows(rows.rows()) = rows;
  layout.gather(wide.data(), 3);
  rows = wide.topRows(rows.rows());
}

}  // namespace loomstone
