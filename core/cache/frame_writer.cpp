#include <array>
#include <cstdio>
#include <numeric>
#include <optional>

#include "core/base/message.h"
#include "core/cache/frame_file.h"
#include "core/cache/frame_layout.h"
#include "core/cache/look_file.h"
#include "core/cache/polydata_file.h"
#include "core/cache/texture_points.h"

namespace loomstone {

using namespace frame_layout;

namespace {

// Writes the group that identifies the file: format, kind and names.
void write_description(Hdf5File& file, const std::string& kind,
                       const std::vector<std::string>& names) {
  file.create_group(group);
  file.write_attribute(group, "format", std::array<std::int64_t, 1>{format.newest});
  file.write_text_attribute(group, "kind", kind);
  file.write_texts(group + "/names", names);
  file.write_text_attribute(group + "/names", "description", "names of the cloths or bodies");
}

void check_rows(const char* name, Eigen::Index rows, Eigen::Index expected, int columns) {
  if (rows == expected) return;
  fail<InvalidInput>(
      "frame.{} must have {} rows of {} numbers to fit the topology, got {} rows; write frames of "
      "one run only.",
      name, expected, columns, rows);
}

void check_topology(const FrameTopology& topology) {
  const auto check = [](const char* name, Eigen::Index length, Eigen::Index expected) {
    if (length != expected)
      fail<InvalidInput>("topology.{} must have {} entries, got {}.", name, expected, length);
  };
  check("corner_uv", topology.corner_uv.rows(), topology.triangles.size());
  for (Index vertex : topology.triangles.reshaped())
    if (vertex < 0 || static_cast<std::size_t>(vertex) >= topology.cloth_of_vertex.size())
      fail<InvalidInput>("topology.triangles must hold vertex indices in [0, {}), got {}.",
                         topology.cloth_of_vertex.size(), vertex);
  check("cloth_of_triangle", static_cast<Eigen::Index>(topology.cloth_of_triangle.size()),
        topology.triangles.rows());
  check("body_of_triangle", static_cast<Eigen::Index>(topology.body_of_triangle.size()),
        topology.body_triangles.rows());
  if (!topology.body_pole.empty())
    check("body_pole", static_cast<Eigen::Index>(topology.body_pole.size()),
          static_cast<Eigen::Index>(topology.body_of_vertex.size()));
  if (!topology.cloth_looks.empty())
    check("cloth_looks", static_cast<Eigen::Index>(topology.cloth_looks.size()),
          static_cast<Eigen::Index>(topology.cloth_names.size()));
  if (!topology.body_looks.empty())
    check("body_looks", static_cast<Eigen::Index>(topology.body_looks.size()),
          static_cast<Eigen::Index>(topology.body_names.size()));
  if (topology.body_corner_uv.rows() > 0)
    check("body_corner_uv", topology.body_corner_uv.rows(), topology.body_triangles.size());
  check("body_is_floor", static_cast<Eigen::Index>(topology.body_is_floor.size()),
        static_cast<Eigen::Index>(topology.body_names.size()));
}

// Returns for each point the value at its vertex. `vertices` contains the vertex of each point; see
// PolyDataMesh.
std::vector<Index> at_points(const std::vector<Index>& at_vertices,
                             const std::vector<Index>& vertices) {
  std::vector<Index> values;
  for (Index vertex : vertices) values.push_back(at_vertices[static_cast<std::size_t>(vertex)]);
  return values;
}

PolyDataWriter create_run(const std::string& path, const FrameTopology& topology,
                          const std::string& metadata, int compression) {
  const auto n_vertices = static_cast<Index>(topology.cloth_of_vertex.size());
  const TexturePoints shown = texture_points(n_vertices, topology.triangles, topology.corner_uv);
  const std::vector<Index> cloths = at_points(topology.cloth_of_vertex, shown.vertices);
  const char* cloth = "cloth, an index into /loomstone/names";
  std::vector<PolyDataField> on_points = {
      {"velocity", Number::Float64, 3, "m/s", "velocities", nullptr, "Vectors"},
      {"contact", Number::UInt8, 1, "1",
       "1: in contact, 2: on a triangle that was forced to intersect, 0: neither"},
      {"cloth", Number::Int32, 1, "1", cloth, cloths.data()}};
  if (shown.textured)
    on_points.push_back({"uv", Number::Float64, 2, "m", "rest coordinates: weft, warp",
                         shown.uv.data(), "TCoords"});
  const std::vector<PolyDataField> on_cells = {
      {"strain", Number::Float64, 3, "1", "Green strain: weft, warp, shear (E12)"},
      {"stretch", Number::Float64, 1, "1", "largest principal stretch"},
      {"cloth", Number::Int32, 1, "1", cloth, topology.cloth_of_triangle.data()},
      {"uv", Number::Float64, 6, "m", "rest coordinates (weft, warp) of the three corners",
       topology.corner_uv.data()}};
  PolyDataWriter writer(path, {n_vertices, shown.vertices, shown.triangles, compression}, on_points,
                        on_cells);
  write_description(writer.file(), run_kind, topology.cloth_names);
  const std::int64_t has_bodies = !topology.body_names.empty();
  writer.file().write_attribute(group, "has_bodies", {&has_bodies, 1});
  writer.file().write_attribute(group, "compression", std::array<std::int64_t, 1>{compression});
  writer.file().write_text(group + "/metadata", metadata);
  write_looks(writer.file(), looks, topology.cloth_looks);
  return writer;
}

PolyDataWriter create_bodies(const std::string& path, const FrameTopology& topology,
                             int compression) {
  const auto n_vertices = static_cast<std::int64_t>(topology.body_of_vertex.size());
  const char* body = "body or obstacle, an index into /loomstone/names";
  std::vector<PolyDataField> on_points = {
      {"body", Number::Int32, 1, "1", body, topology.body_of_vertex.data()}};
  if (!topology.body_pole.empty())
    on_points.push_back(
        {"pole", Number::Float64, 1, "1",
         "position between the poles of the nearest magnet: about 1 at the north pole, "
         "about -1 at the south pole, 0 away from magnets",
         topology.body_pole.data()});
  std::vector<Index> vertices(topology.body_of_vertex.size());
  std::iota(vertices.begin(), vertices.end(), 0);
  std::vector<PolyDataField> on_cells = {
      {"body", Number::Int32, 1, "1", body, topology.body_of_triangle.data()}};
  if (topology.body_corner_uv.rows() > 0)
    on_cells.push_back({"uv", Number::Float64, 6, "m", "uv of the three corners, for textures",
                        topology.body_corner_uv.data()});
  PolyDataWriter writer(path, {n_vertices, vertices, topology.body_triangles, compression},
                        on_points, on_cells);
  Hdf5File& file = writer.file();
  write_description(file, bodies_kind, topology.body_names);
  file.write_array(group + "/is_floor", Number::UInt8,
                   {static_cast<std::int64_t>(topology.body_is_floor.size())},
                   topology.body_is_floor.data());
  file.describe(group + "/is_floor", "1", "1: drawn as ground");
  write_looks(file, looks, topology.body_looks);
  return writer;
}

// Removes the temporary files in its destructor, unless publish() has renamed them.
struct Parts {
  std::string directory;
  bool published = false;
  ~Parts() {
    if (published) return;
    std::remove((directory + "/" + run_file + ".part").c_str());
    std::remove((directory + "/" + bodies_file + ".part").c_str());
  }
};

}  // namespace

struct FrameWriter::Data {
  std::string directory;
  Parts parts;
  PolyDataWriter run;
  std::optional<PolyDataWriter> bodies;
  Hdf5Rows frame_rows, current_rows;
  Eigen::Index n_vertices, n_triangles, n_body_vertices, n_coils = 0;
  std::int64_t n_frames = 0;

  // Creates the files under temporary names. publish() renames them.
  Data(const std::string& into, const FrameTopology& topology, const std::string& metadata,
       int compression)
      : directory(into),
        parts{into},
        run(create_run(into + "/" + run_file + ".part", topology, metadata, compression)) {
    if (!topology.body_names.empty())
      bodies = create_bodies(into + "/" + bodies_file + ".part", topology, compression);
    frame_rows = create_table("frames", frame_format());
    n_vertices = static_cast<Eigen::Index>(topology.cloth_of_vertex.size());
    n_triangles = topology.triangles.rows();
    n_body_vertices = static_cast<Eigen::Index>(topology.body_of_vertex.size());
  }

  Hdf5Rows create_table(const std::string& name, const RowFormat& format) {
    Hdf5Rows rows = run.file().create_rows(group + "/" + name, format, {table_block});
    run.file().describe(group + "/" + name, format.columns);
    return rows;
  }

  void flush() {
    if (bodies) bodies->file().flush();
    run.file().flush();
  }

  // Renames the bodies file first. If the process is killed before it renames the run file, the
  // directory does not contain files of different runs: the old run file has already been removed
  // or, if its run is continued, begins with the same frames as the new bodies file.
  void publish(bool same_run) {
    const std::string run_path = directory + "/" + run_file,
                      bodies_path = directory + "/" + bodies_file;
    flush();
    if (!same_run) std::remove(run_path.c_str());
    if (bodies)
      bodies->file().rename_to(bodies_path);
    else
      std::remove(bodies_path.c_str());
    run.file().rename_to(run_path);
    parts.published = true;
  }

  void check(const Frame& frame) const {
    check_rows("positions", frame.positions.rows(), n_vertices, 3);
    check_rows("velocities", frame.velocities.rows(), n_vertices, 3);
    check_rows("contact", static_cast<Eigen::Index>(frame.contact.size()), n_vertices, 1);
    check_rows("strain", frame.strain.rows(), n_triangles, 3);
    check_rows("stretch", frame.stretch.rows(), n_triangles, 1);
    check_rows("body_vertices", frame.body_vertices.rows(), n_body_vertices, 3);
    if (n_frames > 0) check_rows("coil_currents", frame.coil_currents.size(), n_coils, 1);
  }

  void stage(const Frame& frame) {
    if (bodies) bodies->stage(n_frames, frame.body_vertices, {}, {});
    run.stage(n_frames, frame.positions, {frame.velocities.data(), frame.contact.data()},
              {frame.strain.data(), frame.stretch.data()});
    const FrameRow row{frame.step, frame.report};
    frame_rows.resize(n_frames + 1);
    frame_rows.write(n_frames, 1, &row);
    if (n_frames == 0 && frame.coil_currents.size() > 0) {
      n_coils = frame.coil_currents.size();
      run.file().write_attribute(group, "n_coils", std::array<std::int64_t, 1>{n_coils});
      current_rows = run.file().create_rows(currents, {Number::Float64, static_cast<int>(n_coils)},
                                            {table_block});
      run.file().describe(currents, "A", "current of each coil");
    }
    if (n_coils == 0) return;
    current_rows.resize(n_frames + 1);
    current_rows.write(n_frames, 1, frame.coil_currents.data());
  }

  // Commits to the bodies file first, so that it may be one frame ahead of the run file but never
  // behind it.
  void commit(const Frame& frame) {
    if (bodies) {
      bodies->commit(n_frames, frame.time);
      bodies->file().flush();
    }
    run.commit(n_frames, frame.time);
  }
};

FrameWriter::FrameWriter() = default;
FrameWriter::~FrameWriter() = default;
FrameWriter::FrameWriter(FrameWriter&&) noexcept = default;
FrameWriter& FrameWriter::operator=(FrameWriter&&) noexcept = default;

FrameWriter::FrameWriter(const std::string& directory, const FrameTopology& topology,
                         const std::string& metadata, int compression) {
  check_topology(topology);
  if (compression < 0 || compression > 9)
    fail<InvalidInput>("compression must be in [0, 9] (0: none), got {}.", compression);
  data_ = std::make_unique<Data>(directory, topology, metadata, compression);
  data_->publish(false);
}

// Copies the frames instead of appending to the old files, because the record of free space in a
// file may be wrong if its writer was killed. The old files remain until the new ones are complete.
FrameWriter FrameWriter::reopen(const std::string& directory, double after_time) {
  const FrameReader old(directory);
  FrameWriter writer;
  writer.data_ =
      std::make_unique<Data>(directory, old.topology(), old.metadata(), old.compression());
  Data& data = *writer.data_;
  for (int index = 0;
       index < old.n_frames() && old.times()[static_cast<std::size_t>(index)] <= after_time;
       ++index) {
    const Frame frame = old.frame(index);
    data.stage(frame);
    data.commit(frame);
    ++data.n_frames;
  }
  data.publish(true);
  return writer;
}

void FrameWriter::write(const Frame& frame) {
  Data& data = *data_;
  data.check(frame);
  data.stage(frame);
  data.flush();
  data.commit(frame);
  data.run.file().flush();
  ++data.n_frames;
}

int FrameWriter::n_frames() const { return static_cast<int>(data_->n_frames); }

}  // namespace loomstone
