// Contents of the frame files in addition to the VTKHDF layout: the group /loomstone. It contains
// the version and kind of the file and, for example, names, metadata, reports, coil currents and
// looks.
#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/report.h"
#include "core/cache/file_format.h"
#include "core/cache/hdf5_file.h"

namespace loomstone::frame_layout {

// Version of the layout, stored in the attribute `format` of the group /loomstone. It increases
// whenever a reader of the current version would misinterpret new files, for example if a meaning
// or unit changes. Additional columns and datasets do not increase it, because readers find columns
// by name and use defaults for missing columns.
inline constexpr FileFormat format = {"file", 3, 3, "run the scene again"};

inline const std::string run_file = "run.vtkhdf", bodies_file = "bodies.vtkhdf";
inline const std::string group = "/loomstone";
inline const std::string run_kind = "run", bodies_kind = "bodies";

// Dataset of the coil currents, one row per frame. Present only if the scene has coils.
inline const std::string currents = group + "/coil_currents";

// Group with the looks (colours, roughness and textures) of the surfaces. Present only if a surface
// has a look.
inline const std::string looks = group + "/looks";

// A row of the table of frames.
struct FrameRow {
  // Number of the last successful step: report.step or, after a failed step, report.step - 1.
  std::int64_t step = 0;
  StepReport report;
};

template <class Value>
constexpr Number number_of() {
  if constexpr (std::is_floating_point_v<Value>) return Number::Float64;
  return sizeof(Value) == 8 ? Number::Int64 : Number::Int32;
}

// Returns one column for each number of a report, named by its path. `start` is the offset of the
// report within a row [bytes].
inline std::vector<Column> report_columns(std::size_t start) {
  std::vector<Column> columns;
  const StepReport report;
  for_each_number(report, [&](const std::string& path, const auto& each, const auto& value) {
    const auto offset =
        reinterpret_cast<const char*>(&value) - reinterpret_cast<const char*>(&report);
    columns.push_back({path, number_of<std::remove_cvref_t<decltype(value)>>(),
                       start + static_cast<std::size_t>(offset), each.unit, each.meaning});
  });
  return columns;
}

inline RowFormat frame_format() {
  auto columns = report_columns(offsetof(FrameRow, report));
  columns.insert(columns.begin(), {"frame_step", Number::Int64, offsetof(FrameRow, step), "1",
                                   "number of the last successful step"});
  return {.columns = columns, .bytes = sizeof(FrameRow)};
}

}  // namespace loomstone::frame_layout
