#include <catch2/catch.hpp>

#include <cstdlib>

#include "core/base/error.h"
#include "example_run.h"

using namespace loomstone;
using namespace loomstone::testing;

TEST_CASE("a run is read back bit for bit, with and without bodies") {
  const bool with_bodies = GENERATE(false, true);
  const TemporaryDirectory directory;
  const FrameTopology topology = example_topology(5, with_bodies);
  const std::string metadata = "{\"scene\": \"two cloths\"}";
  const int n_frames = 40;  // these need more than two of the blocks by which the file grows
  {
    FrameWriter writer(directory.path(), topology, metadata);
    for (int index = 0; index < n_frames; ++index) write_example(writer, topology, index);
    CHECK(writer.n_frames() == n_frames);
  }
  const FrameReader reader(directory.path());
  CHECK(reader.n_frames() == n_frames);
  CHECK(reader.metadata() == metadata);
  CHECK(same(reader.topology(), topology));
  for (int index = 0; index < n_frames; ++index) {
    CHECK(same(reader.frame(index), example_frame(topology, index)));
    CHECK(reader.times()[static_cast<std::size_t>(index)] == example_frame(topology, index).time);
  }
  const auto reports = reader.reports();
  REQUIRE(reports.size() == (n_frames - 1) * steps_per_frame);
  for (std::size_t i = 0; i < reports.size(); ++i)
    CHECK(same(reports[i], example_report(static_cast<std::int64_t>(i) + 1)));
}

// tests/python/runs/test_cache_vtk.py reads this run with VTK's own reader and compares its values
// with the formulas of the example.
TEST_CASE("an example run for other programs can be kept") {
  const char* directory = std::getenv("LOOMSTONE_EXAMPLE_RUN");
  if (!directory) return;
  const FrameTopology topology = example_topology(5, true);
  FrameWriter writer(directory, topology, "{}");
  for (int index = 0; index < 40; ++index) write_example(writer, topology, index);
}
