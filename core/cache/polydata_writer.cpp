// VTK requires all groups, attributes and tables of the VTKHDF layout, even those that contain only
// zeros. If one is missing, VTK silently shows an empty mesh, or step 0 at every step.
#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "core/cache/polydata_file.h"

namespace loomstone {

namespace {

// Number of frames for which space for points and fields is allocated at once in a file without
// compression. Large blocks make changes of the file's structure rare. Unused space is a hole in
// the file and takes no disk space.
constexpr std::int64_t frames_per_block = 16;

std::string below(std::string group, const std::string& name) {
  return group.append("/").append(name);
}

std::size_t bytes_of(Number type) {
  return type == Number::UInt8 ? 1 : type == Number::Int32 ? 4 : 8;
}

}  // namespace

PolyDataWriter::PolyDataWriter(const std::string& path, PolyDataMesh mesh,
                               const std::vector<PolyDataField>& point_fields,
                               const std::vector<PolyDataField>& cell_fields)
    : file_(Hdf5File::create(path)), mesh_(std::move(mesh)) {
  const auto n_points = static_cast<std::int64_t>(mesh_.vertices.size());
  file_.create_group(polydata_root);
  file_.write_text_attribute(polydata_root, "Type", "PolyData");
  file_.write_attribute(polydata_root, "Version", std::array<std::int64_t, 2>{2, 0});
  file_.write_array(polydata_root + "/NumberOfPoints", Number::Int64, {1}, &n_points);
  create_cells(mesh_.triangles);

  const std::string steps = polydata_root + "/Steps";
  file_.create_group(steps);
  file_.write_attribute(steps, "NSteps", std::array<std::int64_t, 1>{0});
  times_ = file_.create_rows(steps + "/Values", {Number::Float64, 1}, {table_block});
  file_.describe(steps + "/Values", "s", "time of each frame");
  point_offsets_ = file_.create_rows(steps + "/PointOffsets", {Number::Int64, 1}, {table_block});
  create_table(steps + "/PartOffsets", 0, 1);
  create_table(steps + "/NumberOfParts", 0, 1);
  create_table(steps + "/CellOffsets", 0, 4);
  create_table(steps + "/ConnectivityIdOffsets", 0, 4);

  const PolyDataField points{"Points", Number::Float64, 3, "m",
                             "positions; row PointOffsets[k] is the first of frame k"};
  points_ = create_values(polydata_root + "/Points", points, n_points);
  std::vector<PolyDataField> with_vertex = point_fields;
  with_vertex.push_back({"vertex", Number::Int32, 1, "1",
                         "vertex that the point shows; vertices on seams of uv have several points",
                         mesh_.vertices.data()});
  create_fields("PointData", with_vertex, n_points);
  create_fields("CellData", cell_fields, mesh_.triangles.rows());
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
    const std::string group = below(polydata_root, kind);
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
                                   const std::vector<PolyDataField>& fields, std::int64_t n_rows) {
  const std::string offsets = below(polydata_root, "Steps/").append(group).append("Offsets");
  file_.create_group(below(polydata_root, group));
  file_.create_group(offsets);
  for (const PolyDataField& field : fields) {
    const std::string path = below(below(polydata_root, group), field.name);
    if (field.constant) {
      const auto shape = field.components == 1
                             ? std::vector<std::int64_t>{n_rows}
                             : std::vector<std::int64_t>{n_rows, field.components};
      file_.write_array(path, field.type, shape, field.constant);
      file_.describe(path, field.unit, field.meaning);
    } else {
      values_.push_back(create_values(path, field, n_rows));
      values_.back().on_points = group == "PointData";
    }
    if (!field.role.empty()) file_.write_text_attribute(path, "Attribute", field.role);
    create_table(below(offsets, field.name), field.constant ? 0 : n_rows, 1);
  }
}

// A compressed chunk contains one frame, so that later frames do not rewrite it.
PolyDataWriter::Values PolyDataWriter::create_values(const std::string& path,
                                                     const PolyDataField& field,
                                                     std::int64_t n_rows) {
  const std::int64_t frames = mesh_.compression > 0 ? 1 : frames_per_block;
  const RowStorage storage{std::max<std::int64_t>(n_rows * frames, 1), mesh_.compression};
  Values values{file_.create_rows(path, {field.type, field.components}, storage), n_rows,
                bytes_of(field.type) * static_cast<std::size_t>(field.components), true};
  file_.describe(path, field.unit, field.meaning);
  return values;
}

void PolyDataWriter::create_table(const std::string& path, std::int64_t stride, int columns) {
  tables_.push_back(
      {file_.create_rows(path, {Number::Int64, columns}, {table_block}), stride, columns});
}

// Appends the row of a frame to all tables and to PointOffsets. Every row of NumberOfParts, the
// table with index 1, contains 1.
void PolyDataWriter::stage_tables(std::int64_t frame) {
  for (Table& table : tables_) {
    const std::int64_t entry = &table == &tables_[1] ? 1 : frame * table.stride;
    const std::vector<std::int64_t> row(static_cast<std::size_t>(table.columns), entry);
    table.rows.resize(frame + 1);
    table.rows.write(frame, 1, row.data());
  }
  const std::int64_t first = (n_staged_blocks_ - 1) * points_.rows_per_frame;
  point_offsets_.resize(frame + 1);
  point_offsets_.write(frame, 1, &first);
}

// Writes a block of rows. For a field on points, `rows` contains one row for each vertex, and each
// point receives the row of its vertex.
void PolyDataWriter::put(Values& values, std::int64_t block, const void* rows) {
  const void* written = rows;
  if (values.on_points && values.rows_per_frame > mesh_.n_vertices) {
    rows_of_points_.resize(mesh_.vertices.size() * values.row_bytes);
    for (std::size_t point = 0; point < mesh_.vertices.size(); ++point)
      std::memcpy(rows_of_points_.data() + point * values.row_bytes,
                  static_cast<const unsigned char*>(rows) +
                      static_cast<std::size_t>(mesh_.vertices[point]) * values.row_bytes,
                  values.row_bytes);
    written = rows_of_points_.data();
  }
  values.rows.resize((block + 1) * values.rows_per_frame);
  values.rows.write(block * values.rows_per_frame, values.rows_per_frame, written);
}

void PolyDataWriter::stage(std::int64_t frame, const Points& positions,
                           const std::vector<const void*>& point_values,
                           const std::vector<const void*>& cell_values) {
  const auto bytes = static_cast<std::size_t>(positions.size()) * sizeof(double);
  const bool same =
      n_blocks_ > 0 && (bytes == 0 || std::memcmp(positions.data(), stored_.data(), bytes) == 0);
  n_staged_blocks_ = n_blocks_ + (same ? 0 : 1);
  if (!same) {
    staged_ = positions;
    put(points_, n_blocks_, positions.data());
  }
  stage_tables(frame);
  std::size_t field = 0;
  for (const void* rows : point_values) put(values_[field++], frame, rows);
  for (const void* rows : cell_values) put(values_[field++], frame, rows);
}

// If the time of this frame begins a new chunk, the file is flushed before the frame count is
// written. The chunk must exist in the file before the count makes it readable.
void PolyDataWriter::commit(std::int64_t frame, double time) {
  times_.resize(frame + 1);
  times_.write(frame, 1, &time);
  if (frame % table_block == 0) file_.flush();
  file_.update_attribute(polydata_root + "/Steps", "NSteps", frame + 1);
  if (n_staged_blocks_ > n_blocks_) stored_.swap(staged_);
  n_blocks_ = n_staged_blocks_;
}

}  // namespace loomstone
