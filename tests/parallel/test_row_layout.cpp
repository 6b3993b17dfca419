#include <catch2/catch.hpp>

#include "core/parallel/row_layout.h"
#include "core/parallel/team.h"

using namespace loomstone;

namespace {

// One of several ranks. It communicates with none of the others.
class SilentRank final : public Communicator {
 public:
  SilentRank(int rank, int size) : rank_(rank), size_(size) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void barrier() const override {}
  std::int64_t maximum(std::int64_t value) const override { return value; }
  void broadcast(void*, std::size_t, int) const override {}
  void start_gather(void*, const std::vector<std::size_t>&) const override {}
  void start_exchange(const std::vector<Message>&, const std::vector<Message>&) const override {}
  void start_add(BinnedSum*, int) const override {}
  void finish() const override {}
  void abort(int) const override { std::abort(); }

 private:
  int rank_, size_;
};

}  // namespace

TEST_CASE("ranges of ranks cover all rows, start at whole blocks and differ by at most one block") {
  for (const int ranks : {1, 2, 3, 5, 8})
    for (const Index rows : {0, 1, 127, 128, 129, 1000, 7397}) {
      const RowLayout layout(rows, std::make_shared<SilentRank>(ranks - 1, ranks));
      const auto& starts = layout.starts();
      CHECK(starts.front() == 0);
      CHECK(layout.n_rows() == rows);
      CHECK(layout.end() == rows);
      Index fewest = rows, most = 0;
      for (int rank = 0; rank < ranks; ++rank) {
        CHECK((starts[rank] % rows_per_block == 0 || starts[rank] == rows));
        const Index blocks =
            (starts[rank + 1] - starts[rank] + rows_per_block - 1) / rows_per_block;
        fewest = std::min(fewest, blocks);
        most = std::max(most, blocks);
      }
      CHECK(most - fewest <= 1);
    }
}

TEST_CASE("the owner of a row is the rank whose range contains it, also with empty ranges") {
  for (const Index rows : {130, 1000}) {
    const RowLayout layout(rows, std::make_shared<SilentRank>(0, 5));
    for (Index row = 0; row < rows; ++row) {
      const int owner = layout.owner(row);
      CHECK((layout.starts()[owner] <= row && row < layout.starts()[owner + 1]));
      CHECK(layout.owns(row) == (owner == 0));
    }
  }
}

TEST_CASE("one rank sums its blocks and keeps its rows") {
  const RowLayout layout(300, single_communicator());
  CHECK(layout.sum({1.0, 1e-17, 3.0}) == 4.0);
  std::vector<double> rows(900, 3.0);
  layout.exchange({}, rows.data(), 3);
  layout.gather(rows.data(), 3);
  CHECK(rows == std::vector<double>(900, 3.0));
  CHECK(layout.single());
}
