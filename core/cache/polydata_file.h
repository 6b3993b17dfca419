// One temporal PolyData dataset in VTKHDF layout (VTK File Formats, "VTKHDF", version 2.0).
// Triangles are stored once; points and fields are stored for every frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/cache/hdf5_file.h"

namespace loomstone {

// A field on points or cells. If `constant` is set, its values are stored once; otherwise every
// frame has its own values.
struct PolyDataField {
  std::string name;
  Number type = Number::Float64;
  int components = 1;
  const void* constant = nullptr;
};

// Writes a PolyData file. A frame is written in two phases, so that a process killed at any moment
// leaves a file whose first NSteps frames are complete. First, stage() appends the data after the
// last frame, and flush() writes it to the file. Then commit() increments the frame count, and a
// second flush() writes the count. If writing a frame fails, it may be repeated.
class PolyDataWriter {
 public:
  PolyDataWriter(const std::string& path, std::int64_t n_points, const Triangles& triangles,
                 const std::vector<PolyDataField>& point_fields,
                 const std::vector<PolyDataField>& cell_fields);
  Hdf5File& file() { return file_; }

  // `point_values` and `cell_values` have one pointer for each field that is not constant, in the
  // order in which the constructor received the fields.
  void stage(std::int64_t frame, const Points& points, const std::vector<const void*>& point_values,
             const std::vector<const void*>& cell_values);
  void commit(std::int64_t frame, double time);

 private:
  struct Table {  // one row per frame
    Hdf5Rows rows;
    std::int64_t stride;  // row k contains k * stride in every column
    int columns;
  };
  struct Values {
    Hdf5Rows rows;
    std::int64_t rows_per_frame;
  };
  void create_cells(const Triangles& triangles);
  void create_fields(const std::string& group, const std::vector<PolyDataField>& fields,
                     std::int64_t n_rows, std::vector<Values>& values);
  void create_table(const std::string& path, std::int64_t stride, int columns);
  void set_aside_frames();

  Hdf5File file_;
  std::int64_t n_set_aside_ = 0;
  Hdf5Rows times_;
  std::vector<Table> tables_;
  std::vector<Values> values_;  // points, point fields, cell fields
};

// Reads files of PolyDataWriter.
class PolyDataReader {
 public:
  explicit PolyDataReader(const Hdf5File& file);
  std::int64_t n_points() const { return n_points_; }
  const Triangles& triangles() const { return triangles_; }
  const std::vector<double>& times() const { return times_; }
  // Reads a constant field, for example "PointData/cloth".
  std::vector<Index> constant_indices(const std::string& field, std::int64_t n_rows) const;
  std::vector<double> constant_numbers(const std::string& field, std::int64_t n_rows,
                                       int components) const;
  Points points(std::int64_t frame) const;
  void read(const std::string& field, Number type, int components, std::int64_t rows_per_frame,
            std::int64_t frame, void* values) const;

 private:
  const Hdf5File* file_;
  std::int64_t n_points_ = 0;
  Triangles triangles_;
  std::vector<double> times_;
};

}  // namespace loomstone
