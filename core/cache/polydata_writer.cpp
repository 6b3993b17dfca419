// VTKHDF requires all groups, attributes and tables written here, even if they contain only zeros.
// If one is missing, VTK silently shows an empty mesh, or step 0 at every step.
#include <algorithm>
#include <array>

#include "core/cache/polydata_file.h"

namespace loomstone {

namespace {

// Number of frames allocated at once. Large blocks make allocations rare, so a process is unlikely
// to be killed during one. The unused remainder is a hole in the file and takes no disk space.
constexpr std::int64_t frames_per_block = 16;
constexpr std::int64_t table_block = 1024;  // rows per chunk of a table

const std::string root = "/VTKHDF";

std::string below(std::string group, const std::string& name) {
  return group.append("/").append(name);
}

}  // namespace

PolyDataWriter::PolyDataWriter(const std::string& path, std::int64_t n_points,
                               const Triangles& triangles,
                               const std::vector<PolyDataField>& point_fields,
                               const std::vector<PolyDataField>& cell_fields)
    : file_(Hdf5File::create(path)) {
  file_.create_group(root);
  file_.write_text_attribute(root, "Type", "PolyData");
  file_.write_attribute(root, "Version", std::array<std::int64_t, 2>{2, 0});
  file_.write_array(root + "/NumberOfPoints", Number::Int64, {1}, &n_points);
  create_cells(triangles);

  const std::string steps = root + "/Steps";
  file_.create_group(steps);
  file_.write_attribute(steps, "NSteps", std::array<std::int64_t, 1>{0});
  times_ = file_.create_rows(steps + "/Values", {Number::Float64, 1}, table_block);
  create_table(steps + "/PartOffsets", 0, 1);
  create_table(steps + "/NumberOfParts", 0, 1);
  create_table(steps + "/PointOffsets", n_points, 1);
  create_table(steps + "/CellOffsets", 0, 4);
  create_table(steps + "/ConnectivityIdOffsets", 0, 4);

  const auto block = [](std::int64_t rows) {
    return std::max<std::int64_t>(rows * frames_per_block, 1);
  };
  values_.push_back(
      {file_.create_rows(root + "/Points", {Number::Float64, 3}, block(n_points)), n_points});
  create_fields("PointData", point_fields, n_points, values_);
  create_fields("CellData", cell_fields, triangles.rows(), values_);
}

// VTKHDF requires all four kinds of cells. Polygons contain the triangles; the other kinds are
// empty.
void PolyDataWriter::create_cells(const Triangles& triangles) {
  const std::int64_t n_triangles = triangles.rows(), n_corners = triangles.size(), none = 0;
  std::vector<std::int64_t> connectivity(triangles.data(), triangles.data() + n_corners), offsets;
  for (std::int64_t triangle = 0; triangle <= n_triangles; ++triangle)
    offsets.push_back(3 * triangle);
  for (const std::string kind : {"Vertices", "Lines", "Polygons", "Strips"}) {
    const bool ours = kind == "Polygons";
    const std::string group = below(root, kind);
    file_.create_group(group);
    file_.write_array(group + "/NumberOfCells", Number::Int64, {1}, ours ? &n_triangles : &none);
    file_.write_array(group + "/NumberOfConnectivityIds", Number::Int64, {1},
                      ours ? &n_corners : &none);
    file_.write_array(group + "/Connectivity", Number::Int64, {ours ? n_corners : 0},
                      connectivity.data());
    file_.write_array(group + "/Offsets", Number::Int64, {ours ? n_triangles + 1 : 1},
                      offsets.data());
  }
}

void PolyDataWriter::create_fields(const std::string& group,
                                   const std::vector<PolyDataField>& fields, std::int64_t n_rows,
                                   std::vector<Values>& values) {
  const std::string offsets = below(root, "Steps/").append(group).append("Offsets");
  file_.create_group(below(root, group));
  file_.create_group(offsets);
  for (const PolyDataField& field : fields) {
    const std::string path = below(below(root, group), field.name);
    if (field.constant) {
      const auto shape = field.components == 1
                             ? std::vector<std::int64_t>{n_rows}
                             : std::vector<std::int64_t>{n_rows, field.components};
      file_.write_array(path, field.type, shape, field.constant);
    } else {
      const std::int64_t block = std::max<std::int64_t>(n_rows * frames_per_block, 1);
      values.push_back({file_.create_rows(path, {field.type, field.components}, block), n_rows});
    }
    create_table(below(offsets, field.name), field.constant ? 0 : n_rows, 1);
  }
}

void PolyDataWriter::create_table(const std::string& path, std::int64_t stride, int columns) {
  tables_.push_back(
      {file_.create_rows(path, {Number::Int64, columns}, table_block), stride, columns});
}

// Extends all tables by a block of frames. Readers ignore rows beyond NSteps, so the whole block is
// filled at once. NumberOfParts is 1 in all rows.
void PolyDataWriter::set_aside_frames() {
  const std::int64_t first = n_set_aside_, count = frames_per_block;
  for (Table& table : tables_) {
    table.rows.resize(first + count);
    std::vector<std::int64_t> rows;
    for (std::int64_t frame = first; frame < first + count; ++frame)
      rows.insert(rows.end(), table.columns, frame * table.stride);
    if (&table == &tables_[1]) rows.assign(rows.size(), 1);
    table.rows.write(first, count, rows.data());
  }
  for (Values& values : values_) values.rows.resize((first + count) * values.rows_per_frame);
  n_set_aside_ += count;
}

void PolyDataWriter::stage(std::int64_t frame, const Points& points,
                           const std::vector<const void*>& point_values,
                           const std::vector<const void*>& cell_values) {
  if (frame >= n_set_aside_) set_aside_frames();
  std::size_t field = 0;
  const auto put = [&](const void* data) {
    Values& values = values_[field++];
    values.rows.write(frame * values.rows_per_frame, values.rows_per_frame, data);
  };
  put(points.data());
  for (const void* data : point_values) put(data);
  for (const void* data : cell_values) put(data);
}

// Steps/Values must have exactly NSteps rows, so it grows together with the frame count. A new
// block is flushed first, because it must exist in the file before the frame count makes it
// readable.
void PolyDataWriter::commit(std::int64_t frame, double time) {
  times_.resize(frame + 1);
  times_.write(frame, 1, &time);
  if (frame % table_block == 0) file_.flush();
  file_.update_attribute(root + "/Steps", "NSteps", frame + 1);
}

}  // namespace loomstone
