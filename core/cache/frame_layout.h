// What the frame files hold besides the VTKHDF layout: group /loomstone with format, names,
// metadata and reports.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/report.h"
#include "core/cache/hdf5_file.h"

namespace loomstone::frame_layout {

// Raise it when a reader of this version would misunderstand the file.
inline constexpr std::int64_t format = 1;

inline const std::string run_file = "run.vtkhdf", bodies_file = "bodies.vtkhdf";
inline const std::string group = "/loomstone";
inline const std::string run_kind = "run", bodies_kind = "bodies";

// The currents in the coils of a scene that has some, a row a frame.
inline const std::string currents = group + "/coil_currents";

// A row of the table of frames.
struct FrameRow {
  std::int64_t step = 0;  // of the frame; the report's own may differ
  StepReport report;
};

inline std::vector<Column> report_columns(std::size_t start = 0) {
  const auto at = [start](std::size_t offset) { return start + offset; };
  std::vector<Column> columns = {
      {"step", Number::Int64, at(offsetof(StepReport, step))},
      {"time", Number::Float64, at(offsetof(StepReport, time))},
      {"busy_least", Number::Float64, at(offsetof(StepReport, busy_least))},
      {"busy_mean", Number::Float64, at(offsetof(StepReport, busy_mean))},
      {"busy_most", Number::Float64, at(offsetof(StepReport, busy_most))},
      {"newton_iterations", Number::Int32, at(offsetof(StepReport, newton_iterations))},
      {"linear_iterations", Number::Int32, at(offsetof(StepReport, linear_iterations))},
      {"linear_residual", Number::Float64, at(offsetof(StepReport, linear_residual))},
      {"contacts", Number::Int64, at(offsetof(StepReport, contacts))},
      {"impacts", Number::Int64, at(offsetof(StepReport, impacts))},
      {"truncated", Number::Int64, at(offsetof(StepReport, truncated))},
      {"substeps", Number::Int32, at(offsetof(StepReport, substeps))},
      {"unresolved", Number::Int64, at(offsetof(StepReport, unresolved))},
      {"intersections", Number::Int64, at(offsetof(StepReport, intersections))},
      {"forced", Number::Int64, at(offsetof(StepReport, forced))},
      {"wanted_motion", Number::Float64, at(offsetof(StepReport, wanted_motion))},
      {"withheld_motion", Number::Float64, at(offsetof(StepReport, withheld_motion))},
      {"withheld", Number::Float64, at(offsetof(StepReport, withheld))},
      {"truncated_momentum", Number::Float64, at(offsetof(StepReport, truncated_momentum))},
      {"contact_acceleration", Number::Float64, at(offsetof(StepReport, contact_acceleration))},
      {"limit_sweeps", Number::Int32, at(offsetof(StepReport, limit_sweeps))},
      {"rate_sweeps", Number::Int32, at(offsetof(StepReport, rate_sweeps))},
      {"limit_rounds", Number::Int32, at(offsetof(StepReport, limit_rounds))},
      {"limit_retreats", Number::Int32, at(offsetof(StepReport, limit_retreats))},
      {"limit_evaluations", Number::Int64, at(offsetof(StepReport, limit_evaluations))},
      {"limit_excess", Number::Float64, at(offsetof(StepReport, limit_excess))},
      {"weft_excess", Number::Float64, at(offsetof(StepReport, weft_excess))},
      {"warp_excess", Number::Float64, at(offsetof(StepReport, warp_excess))},
      {"shear_excess", Number::Float64, at(offsetof(StepReport, shear_excess))},
      {"beyond_limit", Number::Int64, at(offsetof(StepReport, beyond_limit))},
      {"worst_element", Number::Int64, at(offsetof(StepReport, worst_element))},
      {"broken_limits", Number::Int64, at(offsetof(StepReport, broken_limits))},
      {"weft_strain", Number::Float64, at(offsetof(StepReport, weft_strain))},
      {"warp_strain", Number::Float64, at(offsetof(StepReport, warp_strain))},
      {"shear_strain", Number::Float64, at(offsetof(StepReport, shear_strain))},
      {"max_stretch", Number::Float64, at(offsetof(StepReport, max_stretch))},
      {"kinetic_energy", Number::Float64, at(offsetof(StepReport, kinetic_energy))},
      {"membrane_energy", Number::Float64, at(offsetof(StepReport, membrane_energy))},
      {"bending_energy", Number::Float64, at(offsetof(StepReport, bending_energy))},
      {"gravity_energy", Number::Float64, at(offsetof(StepReport, gravity_energy))},
      {"contact_energy", Number::Float64, at(offsetof(StepReport, contact_energy))},
      {"body_kinetic_energy", Number::Float64, at(offsetof(StepReport, body_kinetic_energy))},
      {"body_gravity_energy", Number::Float64, at(offsetof(StepReport, body_gravity_energy))},
      {"magnetic_energy", Number::Float64, at(offsetof(StepReport, magnetic_energy))},
      {"magnetic_substeps", Number::Int32, at(offsetof(StepReport, magnetic_substeps))},
      {"magnetic_error", Number::Float64, at(offsetof(StepReport, magnetic_error))},
      {"circuit_current", Number::Float64, at(offsetof(StepReport, circuit_current))},
      {"circuit_energy", Number::Float64, at(offsetof(StepReport, circuit_energy))},
      {"circuit_heat", Number::Float64, at(offsetof(StepReport, circuit_heat))},
      {"circuit_supply", Number::Float64, at(offsetof(StepReport, circuit_supply))},
      {"bearing_work", Number::Float64, at(offsetof(StepReport, bearing_work))}};
  for (std::size_t stage = 0; stage < stage_names.size(); ++stage)
    columns.push_back({std::string("seconds_") + stage_names[stage], Number::Float64,
                       at(offsetof(StepReport, seconds) + stage * sizeof(double))});
  return columns;
}

inline RowFormat report_format() {
  return {.columns = report_columns(), .bytes = sizeof(StepReport)};
}

inline RowFormat frame_format() {
  auto columns = report_columns(offsetof(FrameRow, report));
  columns.insert(columns.begin(), {"frame_step", Number::Int64, offsetof(FrameRow, step)});
  return {.columns = columns, .bytes = sizeof(FrameRow)};
}

}  // namespace loomstone::frame_layout
