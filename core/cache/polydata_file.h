// One temporal PolyData dataset in VTKHDF layout (VTK File Formats, "VTKHDF", version 2.0).
// Triangles and constant fields are stored once, and other fields for every frame. Points are
// stored for the first frame, and for every frame in which they differ from those of the preceding
// frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/cache/hdf5_file.h"

namespace loomstone {

inline const std::string polydata_root = "/VTKHDF";  // group of the dataset in the file
inline constexpr std::int64_t table_block = 1024;    // rows per chunk of a table

// A field on points or cells. If `constant` is not null, it points to the values, which are stored
// once; otherwise every frame has its own values.
struct PolyDataField {
  std::string name;
  Number type = Number::Float64;
  int components = 1;
  std::string unit, meaning;
  const void* constant = nullptr;
  // Value, such as "TCoords", of the HDF5 attribute `Attribute`, which tells viewers how to use the
  // field; empty: no attribute.
  std::string role = {};
};

// The points and triangles of a file. Each point is a copy of a vertex. The first n_vertices points
// are the vertices themselves, in order; further points repeat vertices.
struct PolyDataMesh {
  std::int64_t n_vertices = 0;
  std::vector<Index> vertices;  // (points) vertex of each point
  Triangles triangles;          // point of each corner
  int compression = 0;          // deflate level of points and varying fields, 0 to 9
};

// Writes a PolyData file. A frame is written in two phases, so that a process killed at any moment
// leaves a file whose first NSteps frames are complete. First, stage() appends the data of the
// frame, and file().flush() writes them to the file. Then commit() adds the time of the frame and
// increments the attribute NSteps, the frame count. A second file().flush() writes both to the
// file. If writing a frame fails, the caller may write the same frame again.
class PolyDataWriter {
 public:
  PolyDataWriter(const std::string& path, PolyDataMesh mesh,
                 const std::vector<PolyDataField>& point_fields,
                 const std::vector<PolyDataField>& cell_fields);
  Hdf5File& file() { return file_; }

  // `positions` has a row for each vertex. `point_values` and `cell_values` have one pointer for
  // each field that is not constant, in the order in which the constructor received the fields. The
  // values of a field on points have a row for each vertex, not for each point.
  void stage(std::int64_t frame, const Points& positions,
             const std::vector<const void*>& point_values,
             const std::vector<const void*>& cell_values);
  void commit(std::int64_t frame, double time);

 private:
  struct Table {  // one row per frame
    Hdf5Rows rows;
    std::int64_t stride;  // every column of row k contains k * stride, or 1 in NumberOfParts
    int columns;
  };
  struct Values {
    Hdf5Rows rows;
    std::int64_t rows_per_frame;
    std::size_t row_bytes;
    bool on_points;
  };
  void create_cells(const Triangles& triangles);
  void create_fields(const std::string& group, const std::vector<PolyDataField>& fields,
                     std::int64_t n_rows);
  void create_table(const std::string& path, std::int64_t stride, int columns);
  Values create_values(const std::string& path, const PolyDataField& field, std::int64_t n_rows);
  void stage_tables(std::int64_t frame);
  void put(Values& values, std::int64_t block, const void* rows);

  Hdf5File file_;
  PolyDataMesh mesh_;
  Hdf5Rows times_, point_offsets_;
  std::vector<Table> tables_;
  Values points_;
  std::vector<Values> values_;  // fields that vary over frames: on points, then on cells
  // A block of points contains the positions of one frame and of all directly following frames with
  // the same positions. stored_ contains the positions of the last committed block. staged_
  // contains those of a block that stage() has added and commit() has not committed yet.
  Points stored_, staged_;
  // Numbers of blocks of points: the committed blocks, and all blocks including a staged one.
  std::int64_t n_blocks_ = 0, n_staged_blocks_ = 0;
  std::vector<unsigned char> rows_of_points_;  // scratch memory of put()
};

// Reads files written by PolyDataWriter.
class PolyDataReader {
 public:
  explicit PolyDataReader(const Hdf5File& file);
  std::int64_t n_vertices() const { return n_vertices_; }
  const Triangles& triangles() const { return triangles_; }  // vertex of each corner
  const std::vector<double>& times() const { return times_; }
  // constant_indices() and constant_numbers() read a constant field, for example "CellData/cloth".
  // A field of indices must have at least `n_rows` rows, of which the first `n_rows` are returned.
  // A field of numbers must have exactly `n_rows` rows. Otherwise, the functions throw CacheError.
  std::vector<Index> constant_indices(const std::string& field, std::int64_t n_rows) const;
  std::vector<double> constant_numbers(const std::string& field, std::int64_t n_rows,
                                       int components) const;
  Points positions(std::int64_t frame) const;
  // read_at_vertices() and read_at_cells() read the values of `field` in a frame.
  void read_at_vertices(const std::string& field, const RowFormat& format, std::int64_t frame,
                        void* values) const;
  void read_at_cells(const std::string& field, const RowFormat& format, std::int64_t frame,
                     void* values) const;

 private:
  struct Block {  // consecutive rows
    std::int64_t first, count;
  };
  void read(const std::string& field, const RowFormat& format, Block block, void* values) const;
  void read_triangles();

  const Hdf5File* file_;
  std::int64_t n_points_ = 0, n_vertices_ = 0;
  Triangles triangles_;
  std::vector<double> times_;
};

}  // namespace loomstone
