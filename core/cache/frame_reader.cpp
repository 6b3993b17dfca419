#include <sys/stat.h>
#include <algorithm>
#include <optional>

#include "core/base/message.h"
#include "core/cache/file_format.h"
#include "core/cache/frame_file.h"
#include "core/cache/frame_layout.h"
#include "core/cache/look_file.h"
#include "core/cache/polydata_file.h"

namespace loomstone {

using namespace frame_layout;

namespace {

// Opens a frame file. Throws CacheError unless loomstone wrote the file, its kind is `kind`, and
// this build can read its format.
Hdf5File open_ours(const std::string& path, const std::string& kind) {
  Hdf5File file = Hdf5File::open(path);
  if (!file.has_attribute(group, "format") || !file.has_attribute(group, "kind"))
    fail<CacheError>(
        "{}: is an HDF5 file but not a loomstone cache; give a file that loomstone wrote.", path);
  check_file_format(path, format, file.attribute(group, "format"));
  if (const std::string found_kind = file.text_attribute(group, "kind"); found_kind != kind)
    fail<CacheError>("{}: must be a loomstone file of kind '{}', got '{}'.", path, kind,
                     found_kind);
  return file;
}

bool is_directory(const std::string& path) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

std::string directory_of(const std::string& path) {
  if (is_directory(path)) return path;
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash);
}

void check_group_numbers(const Hdf5File& file, const std::vector<Index>& groups,
                         std::size_t n_names) {
  for (Index number : groups)
    if (number < 0 || static_cast<std::size_t>(number) >= n_names)
      fail<CacheError>(
          "{}: the file is damaged: the index of a cloth or body must be in [0, {}), got {}.",
          file.name(), n_names, number);
}

}  // namespace

struct FrameReader::Data {
  Hdf5File run_file;
  PolyDataReader run;
  std::optional<Hdf5File> bodies_file;
  std::optional<PolyDataReader> bodies;
  FrameTopology topology;
  std::string metadata;
  std::vector<double> times;
  std::int64_t n_coils = 0;

  Data(const std::string& run_path, const std::string& bodies_path)
      : run_file(open_ours(run_path, run_kind)), run(run_file), times(run.times()) {
    read_cloth();
    metadata = run_file.read_text(group + "/metadata");
    if (run_file.has_attribute(group, "n_coils")) n_coils = run_file.attribute(group, "n_coils");
    if (n_coils < 0 || n_coils > run_file.length() / 8)
      fail<CacheError>("{}: the file is damaged: n_coils is {}.", run_file.name(), n_coils);
    if (run_file.attribute(group, "has_bodies")) {
      bodies_file = open_ours(bodies_path, bodies_kind);
      bodies.emplace(*bodies_file);
      read_bodies();
    }
  }

  void read_cloth() {
    const std::int64_t n_triangles = run.triangles().rows();
    topology.triangles = run.triangles();
    topology.cloth_names = run_file.read_texts(group + "/names");
    topology.cloth_of_vertex = run.constant_indices("PointData/cloth", run.n_vertices());
    topology.cloth_of_triangle = run.constant_indices("CellData/cloth", n_triangles);
    const auto uv = run.constant_numbers("CellData/uv", n_triangles, 6);
    topology.corner_uv = Eigen::Map<const Points2>(uv.data(), 3 * n_triangles, 2);
    topology.cloth_looks = read_looks(run_file, looks, topology.cloth_names.size());
    check_group_numbers(run_file, topology.cloth_of_vertex, topology.cloth_names.size());
    check_group_numbers(run_file, topology.cloth_of_triangle, topology.cloth_names.size());
  }

  void read_bodies() {
    topology.body_triangles = bodies->triangles();
    topology.body_names = bodies_file->read_texts(group + "/names");
    topology.body_of_vertex = bodies->constant_indices("PointData/body", bodies->n_vertices());
    if (bodies_file->has("/VTKHDF/PointData/pole"))
      topology.body_pole = bodies->constant_numbers("PointData/pole", bodies->n_vertices(), 1);
    topology.body_of_triangle =
        bodies->constant_indices("CellData/body", bodies->triangles().rows());
    if (bodies_file->has("/VTKHDF/CellData/uv")) {
      const std::int64_t n_triangles = topology.body_triangles.rows();
      const auto uv = bodies->constant_numbers("CellData/uv", n_triangles, 6);
      topology.body_corner_uv = Eigen::Map<const Points2>(uv.data(), 3 * n_triangles, 2);
    }
    topology.body_looks = read_looks(*bodies_file, looks, topology.body_names.size());
    topology.body_is_floor = bodies_file->read_array<std::uint8_t>(group + "/is_floor");
    check_group_numbers(*bodies_file, topology.body_of_vertex, topology.body_names.size());
    check_group_numbers(*bodies_file, topology.body_of_triangle, topology.body_names.size());
    if (topology.body_is_floor.size() != topology.body_names.size())
      fail<CacheError>("{}: the file is damaged: is_floor has the wrong length.",
                       bodies_file->name());
    // If the writer was killed, the two files may have different numbers of frames. In files of one
    // run, the times of all common frames are equal.
    times.resize(std::min(times.size(), bodies->times().size()));
    if (!std::equal(times.begin(), times.end(), bodies->times().begin()))
      fail<CacheError>("{}: belongs to another run than {}; keep the two files of a run together.",
                       bodies_file->name(), run_file.name());
  }
};

FrameReader::~FrameReader() = default;
FrameReader::FrameReader(FrameReader&&) noexcept = default;
FrameReader& FrameReader::operator=(FrameReader&&) noexcept = default;

FrameReader::FrameReader(const std::string& path) {
  const std::string directory = directory_of(path);
  const std::string run_path = is_directory(path) ? path + "/" + run_file : path;
  data_ = std::make_unique<Data>(run_path, directory + "/" + bodies_file);
}

int FrameReader::n_frames() const { return static_cast<int>(data_->times.size()); }
const FrameTopology& FrameReader::topology() const { return data_->topology; }
const std::string& FrameReader::metadata() const { return data_->metadata; }
int FrameReader::compression() const {
  return static_cast<int>(data_->run_file.attribute(group, "compression"));
}
const std::vector<double>& FrameReader::times() const { return data_->times; }

Frame FrameReader::frame(int index) const {
  if (index < 0 || index >= n_frames())
    fail<InvalidInput>("{}: frame index must be in [0, {}), got {}.", data_->run_file.name(),
                       n_frames(), index);
  const PolyDataReader& run = data_->run;
  const std::int64_t n_vertices = run.n_vertices(), n_triangles = run.triangles().rows();
  Frame frame;
  frame.time = data_->times[static_cast<std::size_t>(index)];
  frame.positions = run.positions(index);
  frame.velocities.resize(n_vertices, 3);
  frame.contact.resize(static_cast<std::size_t>(n_vertices));
  frame.strain.resize(n_triangles, 3);
  frame.stretch.resize(n_triangles);
  run.read_at_vertices("velocity", {Number::Float64, 3}, index, frame.velocities.data());
  run.read_at_vertices("contact", {Number::UInt8, 1}, index, frame.contact.data());
  run.read_at_cells("strain", {Number::Float64, 3}, index, frame.strain.data());
  run.read_at_cells("stretch", {Number::Float64, 1}, index, frame.stretch.data());
  frame.body_vertices = data_->bodies ? data_->bodies->positions(index) : Points(0, 3);
  FrameRow row;
  data_->run_file.open_rows(group + "/frames", frame_format()).read(index, 1, &row);
  frame.step = row.step;
  frame.report = row.report;
  if (data_->n_coils > 0) {
    frame.coil_currents.resize(data_->n_coils);
    const RowFormat format{Number::Float64, static_cast<int>(data_->n_coils)};
    data_->run_file.open_rows(currents, format).read(index, 1, frame.coil_currents.data());
  }
  return frame;
}

}  // namespace loomstone
