#include <catch2/catch.hpp>

#include <cstdlib>

#include "core/base/error.h"
#include "core/cache/hdf5_file.h"
#include "core/cache/texture_points.h"
#include "example_run.h"

using namespace loomstone;
using namespace loomstone::testing;

TEST_CASE("a run is read back bit for bit, with and without bodies") {
  const bool with_bodies = GENERATE(false, true);
  const TemporaryDirectory directory;
  const FrameTopology topology = example_topology(5, with_bodies);
  const int compression = GENERATE(0, 4);
  const std::string metadata = "{\"scene\": \"two cloths \xC3\xA9\"}";
  const int n_frames = 40;  // three blocks: an uncompressed file grows by blocks of 16 frames
  {
    FrameWriter writer(directory.path(), topology, metadata, compression);
    for (int index = 0; index < n_frames; ++index) write_example(writer, topology, index);
    CHECK(writer.n_frames() == n_frames);
  }
  const FrameReader reader(directory.path());
  CHECK(reader.n_frames() == n_frames);
  CHECK(reader.metadata() == metadata);
  CHECK(reader.compression() == compression);
  CHECK(same(reader.topology(), topology));
  for (int index = 0; index < n_frames; ++index) {
    CHECK(same(reader.frame(index), example_frame(topology, index)));
    CHECK(reader.times()[static_cast<std::size_t>(index)] == example_frame(topology, index).time);
  }
}

// tests/python/runs/test_cache_vtk.py sets LOOMSTONE_EXAMPLE_RUN, reads the run with VTK's own
// reader and compares its values with the formulas of the example.
TEST_CASE("an example run for other programs can be kept") {
  const char* directory = std::getenv("LOOMSTONE_EXAMPLE_RUN");
  if (!directory) return;
  const FrameTopology topology = example_topology(5, true);
  FrameWriter writer(directory, topology, "{}");
  for (int index = 0; index < 40; ++index) write_example(writer, topology, index);
}

TEST_CASE("positions that do not change are stored once, and no dataset has rows beyond NSteps") {
  const TemporaryDirectory directory;
  const FrameTopology topology = example_topology(4, true);
  const int n_frames = 20;
  Frame frame = example_frame(topology, 0);
  {
    FrameWriter writer(directory.path(), topology, "");
    for (int index = 0; index < n_frames; ++index) {
      if (index == 12) frame.body_vertices.array() += 1.0;
      frame.time = 0.1 * index;
      writer.write(frame);
    }
  }
  const FrameReader reader(directory.path());
  REQUIRE(reader.n_frames() == n_frames);
  CHECK(same(reader.frame(19), frame));
  CHECK(reader.frame(11).body_vertices(0, 0) == frame.body_vertices(0, 0) - 1.0);
  const auto rows_of = [&](const std::string& name, const std::string& path,
                           const RowFormat& format) {
    return Hdf5File::open(directory / name).open_rows("/VTKHDF/" + path, format).size();
  };
  CHECK(rows_of("bodies.vtkhdf", "Points", {Number::Float64, 3}) == 2 * 8);
  CHECK(rows_of("run.vtkhdf", "PointData/contact", {Number::UInt8, 1}) % n_frames == 0);
  CHECK(rows_of("run.vtkhdf", "CellData/stretch", {Number::Float64, 1}) == n_frames * 36);
  for (const char* table : {"Values", "PartOffsets", "NumberOfParts", "PointOffsets"}) {
    const Number type = table == std::string("Values") ? Number::Float64 : Number::Int64;
    CHECK(rows_of("run.vtkhdf", std::string("Steps/") + table, {type, 1}) == n_frames);
  }
}

TEST_CASE("a vertex on a seam of the texture has a point for each coordinate") {
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 1, 3, 2;
  Points2 uv(6, 2);
  uv << 0, 0, 1, 0, 0, 1, /* seam */ 5, 0, 6, 1, 0, 1;
  const TexturePoints made = texture_points(5, triangles, uv);
  REQUIRE(made.textured);
  CHECK(made.vertices == std::vector<Index>{0, 1, 2, 3, 4, 1});
  CHECK(made.triangles.row(1) == Eigen::RowVector3i(5, 3, 2));
  for (int corner = 0; corner < 6; ++corner)
    CHECK(made.uv.row(made.triangles.data()[corner]) == uv.row(corner));
  CHECK(made.uv.row(4).isZero());  // no triangle uses this vertex

  // Every triangle has its own texture coordinates. Splitting vertices would more than double the
  // number of points, so the texture coordinates are omitted.
  Triangles fan(6, 3);
  fan << 0, 1, 2, 0, 2, 3, 0, 3, 1, 0, 2, 1, 0, 3, 2, 0, 1, 3;
  CHECK(!texture_points(4, fan, Points2::Random(18, 2)).textured);
}
