#include <algorithm>

#include "core/base/message.h"
#include "core/cache/polydata_file.h"

namespace loomstone {

namespace {

const std::string root = "/VTKHDF";

[[noreturn]] void damaged(const Hdf5File& file, const std::string& what) {
  fail<CacheError>("{}: the file is damaged: {}.", file.name(), what);
}

}  // namespace

PolyDataReader::PolyDataReader(const Hdf5File& file) : file_(&file) {
  const auto n_points = file.read_array<std::int64_t>(root + "/NumberOfPoints");
  if (n_points.size() != 1 || n_points[0] < 0) damaged(file, "NumberOfPoints is not one count");
  n_points_ = n_points[0];

  const auto connectivity = file.read_array<std::int64_t>(root + "/Polygons/Connectivity");
  if (connectivity.size() % 3 != 0) damaged(file, "its cells are not triangles");
  triangles_.resize(static_cast<Eigen::Index>(connectivity.size() / 3), 3);
  for (std::size_t corner = 0; corner < connectivity.size(); ++corner) {
    if (connectivity[corner] < 0 || connectivity[corner] >= n_points_)
      damaged(file, "a triangle names a missing vertex");
    triangles_.data()[corner] = static_cast<Index>(connectivity[corner]);
  }

  // If the writer was killed between writing the times and the frame count, there is one more time
  // than frames.
  const Hdf5Rows times = file.open_rows(root + "/Steps/Values", {Number::Float64, 1});
  const std::int64_t n_frames = std::min(file.attribute(root + "/Steps", "NSteps"), times.size());
  if (n_frames < 0 || n_frames > (std::int64_t{1} << 40)) damaged(file, "NSteps is not a count");
  times_.resize(static_cast<std::size_t>(n_frames));
  times.read(0, n_frames, times_.data());
}

std::vector<Index> PolyDataReader::constant_indices(const std::string& field,
                                                    std::int64_t n_rows) const {
  auto values = file_->read_array<std::int32_t>(root + "/" + field);
  if (static_cast<std::int64_t>(values.size()) != n_rows)
    damaged(*file_, field + " has the wrong length");
  return values;
}

std::vector<double> PolyDataReader::constant_numbers(const std::string& field, std::int64_t n_rows,
                                                     int components) const {
  auto values = file_->read_array<double>(root + "/" + field);
  if (static_cast<std::int64_t>(values.size()) != n_rows * components)
    damaged(*file_, field + " has the wrong length");
  return values;
}

Points PolyDataReader::points(std::int64_t frame) const {
  Points points(n_points_, 3);
  read("Points", Number::Float64, 3, n_points_, frame, points.data());
  return points;
}

void PolyDataReader::read(const std::string& field, Number type, int components,
                          std::int64_t rows_per_frame, std::int64_t frame, void* values) const {
  const Hdf5Rows rows = file_->open_rows(root + "/" + field, {type, components});
  if (rows.size() < (frame + 1) * rows_per_frame)
    damaged(*file_, field + " ends before the last frame");
  rows.read(frame * rows_per_frame, rows_per_frame, values);
}

}  // namespace loomstone
