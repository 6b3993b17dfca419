#include <catch2/catch.hpp>

#include <cstring>

#include "core/base/error.h"
#include "core/cache/checkpoint_file.h"
#include "example_run.h"

using namespace loomstone;
using loomstone::testing::TemporaryDirectory;

namespace {

Checkpoint example_checkpoint() {
  Checkpoint checkpoint;
  checkpoint.arrays["cloth/positions"] = {{2, 3}, {0.1, -0.0, 1e-310, 1.0 / 3.0, 1e300, -7}};
  checkpoint.arrays["time"] = {{}, {0.125}};
  checkpoint.arrays["nothing"] = {{0, 3}, {}};
  checkpoint.integers["contact.pairs"] = {-1, std::int64_t{1} << 62};
  checkpoint.bytes["bullet"] = {0, 255, 3};
  checkpoint.bytes["empty"] = {};
  checkpoint.texts["100% wool"] = "{\"a\": 1}";
  checkpoint.texts["."] = "";
  return checkpoint;
}

}  // namespace

TEST_CASE("a checkpoint is read back bit for bit") {
  const TemporaryDirectory directory;
  const Checkpoint written = example_checkpoint();
  write_checkpoint(directory / "a.checkpoint", written);
  const Checkpoint read = read_checkpoint(directory / "a.checkpoint");
  REQUIRE(read.arrays.size() == written.arrays.size());
  for (const auto& [name, array] : written.arrays) {
    REQUIRE(read.arrays.count(name) == 1);
    CHECK(read.arrays.at(name).shape == array.shape);
    REQUIRE(read.arrays.at(name).values.size() == array.values.size());
    CHECK(std::equal(array.values.begin(), array.values.end(), read.arrays.at(name).values.begin(),
                     [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }));
  }
  CHECK(read.integers == written.integers);
  CHECK(read.bytes == written.bytes);
  CHECK(read.texts == written.texts);
}
