#include <algorithm>

#include "core/base/message.h"
#include "core/cache/polydata_file.h"

namespace loomstone {

namespace {

[[noreturn]] void damaged(const Hdf5File& file, const std::string& what) {
  fail<CacheError>("{}: the file is damaged: {}.", file.name(), what);
}

}  // namespace

PolyDataReader::PolyDataReader(const Hdf5File& file) : file_(&file) {
  const auto n_points = file.read_array<std::int64_t>(polydata_root + "/NumberOfPoints");
  if (n_points.size() != 1 || n_points[0] < 0)
    damaged(file, "NumberOfPoints is not a single number >= 0");
  n_points_ = n_points[0];
  read_triangles();

  // If the writer was killed after writing the time of a frame, but before writing the frame count,
  // the number of times is one larger than the frame count.
  const Hdf5Rows times = file.open_rows(polydata_root + "/Steps/Values", {Number::Float64, 1});
  const std::int64_t n_frames =
      std::min(file.attribute(polydata_root + "/Steps", "NSteps"), times.size());
  if (n_frames < 0 || n_frames > file.length() / 8)
    damaged(file, formatted("NSteps is {}", n_frames));
  times_.resize(static_cast<std::size_t>(n_frames));
  times.read(0, n_frames, times_.data());
}

void PolyDataReader::read_triangles() {
  const auto vertices = constant_indices("PointData/vertex", n_points_);
  for (Index vertex : vertices)
    n_vertices_ = std::max(n_vertices_, static_cast<std::int64_t>(vertex) + 1);
  for (std::size_t point = 0; point < vertices.size(); ++point)
    if (vertices[point] < 0 || (static_cast<std::int64_t>(point) < n_vertices_ &&
                                vertices[point] != static_cast<Index>(point)))
      damaged(*file_, "its points are not in the order of the vertices");
  const auto connectivity =
      file_->read_array<std::int64_t>(polydata_root + "/Polygons/Connectivity");
  if (connectivity.size() % 3 != 0) damaged(*file_, "its cells are not triangles");
  triangles_.resize(static_cast<Eigen::Index>(connectivity.size() / 3), 3);
  for (std::size_t corner = 0; corner < connectivity.size(); ++corner) {
    if (connectivity[corner] < 0 || connectivity[corner] >= n_points_)
      damaged(*file_, "a triangle refers to a missing vertex");
    triangles_.data()[corner] = vertices[static_cast<std::size_t>(connectivity[corner])];
  }
}

std::vector<Index> PolyDataReader::constant_indices(const std::string& field,
                                                    std::int64_t n_rows) const {
  auto values = file_->read_array<std::int32_t>(polydata_root + "/" + field);
  if (static_cast<std::int64_t>(values.size()) < n_rows)
    damaged(*file_, field + " has the wrong length");
  values.resize(static_cast<std::size_t>(n_rows));
  return values;
}

std::vector<double> PolyDataReader::constant_numbers(const std::string& field, std::int64_t n_rows,
                                                     int components) const {
  auto values = file_->read_array<double>(polydata_root + "/" + field);
  if (static_cast<std::int64_t>(values.size()) != n_rows * components)
    damaged(*file_, field + " has the wrong length");
  return values;
}

Points PolyDataReader::positions(std::int64_t frame) const {
  std::int64_t first = 0;
  read("Steps/PointOffsets", {Number::Int64, 1}, {frame, 1}, &first);
  Points points(n_vertices_, 3);
  read("Points", {Number::Float64, 3}, {first, n_vertices_}, points.data());
  return points;
}

void PolyDataReader::read_at_vertices(const std::string& field, const RowFormat& format,
                                      std::int64_t frame, void* values) const {
  read("PointData/" + field, format, {frame * n_points_, n_vertices_}, values);
}

void PolyDataReader::read_at_cells(const std::string& field, const RowFormat& format,
                                   std::int64_t frame, void* values) const {
  const std::int64_t n_cells = triangles_.rows();
  read("CellData/" + field, format, {frame * n_cells, n_cells}, values);
}

void PolyDataReader::read(const std::string& field, const RowFormat& format, Block block,
                          void* values) const {
  const Hdf5Rows rows = file_->open_rows(polydata_root + "/" + field, format);
  if (block.first < 0 || block.first > rows.size() - block.count)
    damaged(*file_, field + " ends before the last frame");
  rows.read(block.first, block.count, values);
}

}  // namespace loomstone
