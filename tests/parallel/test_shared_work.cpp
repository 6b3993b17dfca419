#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <typeinfo>

#include "core/base/error.h"
#include "core/parallel/merge_runs.h"
#include "core/parallel/repeated_gather.h"
#include "core/parallel/section_ranges.h"
#include "tests/support/thread_ranks.h"

using namespace loomstone;
using test::on_ranks;

TEST_CASE("even shares cover a range once and differ by at most one") {
  for (const Index n : {0, 1, 7, 1000})
    for (const int ranks : {1, 2, 3, 7}) {
      Index next = 0, least = n, most = 0;
      for (int rank = 0; rank < ranks; ++rank) {
        const IndexRange share = even_share(n, rank, ranks);
        CHECK(share.begin == next);
        next = share.end;
        least = std::min(least, share.end - share.begin);
        most = std::max(most, share.end - share.begin);
      }
      CHECK(next == n);
      CHECK(most - least <= 1);
    }
}

TEST_CASE("all ranks receive the results of all ranks in the order of the ranks") {
  for (const int n : {1, 2, 3, 7}) {
    std::vector<int> right(n, 0);
    on_ranks(n, [&](const auto& ranks) {
      const int rank = ranks->rank();
      const std::vector<double> results = results_of_ranks(*ranks, [&] { return 1.5 * rank; });
      // Rank r contributes r elements, so rank 0 contributes none.
      const auto gathered = gather_from_ranks(
          *ranks, [&] { return std::vector<std::array<int, 2>>(rank, {rank, n}); });
      bool all = static_cast<int>(results.size()) == n;
      for (int other = 0; other < n; ++other) {
        all = all && results[other] == 1.5 * other &&
              gathered.start[other + 1] - gathered.start[other] == static_cast<std::size_t>(other);
        for (std::size_t i = gathered.start[other]; i < gathered.start[other + 1]; ++i)
          all = all && gathered.elements[i] == std::array<int, 2>{other, n};
      }
      right[rank] = all;
    });
    CHECK(std::accumulate(right.begin(), right.end(), 0) == n);
  }
}

TEST_CASE("if the work of some ranks fails, all ranks throw the error of the lowest of them") {
  for (const bool gathers : {false, true}) {
    std::vector<std::string> said(4);
    on_ranks(4, [&](const auto& ranks) {
      const int rank = ranks->rank();
      const auto work = [&] {
        if (rank == 1 || rank == 3) throw InvalidInput("rank " + std::to_string(rank));
        return std::vector<int>(2, rank);
      };
      try {
        if (gathers)
          gather_from_ranks(*ranks, work);
        else
          results_of_ranks(*ranks, [&] { return work().front(); });
      } catch (const InvalidInput& error) {
        said[rank] = error.what();
      }
    });
    for (const std::string& text : said) CHECK(text == "rank 1");
  }
}

TEST_CASE("the error of a rank keeps its type on all ranks") {
  const auto count = [](auto&& failure) {
    std::atomic<int> kept = 0;
    on_ranks(2, [&](const auto& ranks) {
      try {
        results_of_ranks(*ranks, [&] {
          if (ranks->rank() == 1) throw failure;
          return 0;
        });
      } catch (const Error& error) {
        kept += typeid(error) == typeid(failure);
      }
    });
    return kept.load();
  };
  CHECK(count(InvalidInput("")) == 2);
  CHECK(count(SolverFailure("")) == 2);
  CHECK(count(StepFailure("")) == 2);
  CHECK(count(CacheError("")) == 2);
  CHECK(count(Unsupported("")) == 2);
}

TEST_CASE("a repeated gather gives all elements and notes, with one exchange if sizes are alike") {
  // Numbers of elements of ranks 0 and 1 in seven gathers.
  const std::vector<std::array<std::size_t, 2>> sizes = {
      {{0, 0}}, {{80, 3}}, {{80, 3}}, {{90, 0}}, {{91, 0}}, {{200, 0}}, {{1, 1}}};
  const std::vector<int> exchanges = {1, 2, 1, 1, 1, 2, 2};
  std::vector<int> right(2, 0);
  on_ranks(2, [&](const auto& ranks) {
    GatherRoom room;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const std::int64_t before = ranks->traffic().operations;
      const auto all = gather_again<std::array<int, 3>, double>(*ranks, room, [&](double& note) {
        note = 0.5 + ranks->rank();
        return std::vector<std::array<int, 3>>(sizes[i][ranks->rank()], {ranks->rank(), 7, int(i)});
      });
      bool good = ranks->traffic().operations - before == exchanges[i] &&
                  all.notes == std::vector<double>{0.5, 1.5} &&
                  all.gathered.elements.size() == sizes[i][0] + sizes[i][1];
      for (int rank : {0, 1})
        for (std::size_t k = all.gathered.start[rank]; k < all.gathered.start[rank + 1]; ++k)
          good = good && all.gathered.elements[k] == std::array<int, 3>{rank, 7, int(i)};
      right[ranks->rank()] += good;
    }
  });
  CHECK(right == std::vector<int>(2, static_cast<int>(sizes.size())));
}

TEST_CASE("if the work before a repeated gather fails on a rank, all ranks throw") {
  std::vector<std::string> said(3);
  on_ranks(3, [&](const auto& ranks) {
    GatherRoom room;
    try {
      gather_again<int, int>(*ranks, room, [&](int&) -> std::vector<int> {
        if (ranks->rank() == 1) throw InvalidInput("rank 1");
        return std::vector<int>(5, 0);
      });
    } catch (const InvalidInput& error) {
      said[ranks->rank()] = error.what();
    }
  });
  for (const std::string& text : said) CHECK(text == "rank 1");
}

TEST_CASE("expensive sections are cut one by one, and cheap ones together") {
  // Two sections with costs of 16 and 8, and four sections with a cost of 0.25 each.
  std::vector<float> costs(8, 2.0f);
  costs.insert(costs.end(), 8, 1.0f);
  costs.insert(costs.end(), 4, 0.25f);
  const SectionStarts first = {0, 8, 16, 17, 18, 19, 20};
  const SectionRanges ranges = section_ranges(costs, first, 4);
  CHECK(ranges == SectionRanges{{0, 2, 4, 6, 8},
                                {8, 10, 12, 14, 16},
                                {16, 17, 17, 17, 17},
                                {17, 17, 18, 18, 18},
                                {18, 18, 18, 19, 19},
                                {19, 19, 19, 19, 20}});
  CHECK(imbalance(costs, first, ranges) == Approx(1.0));
  // One piece of the first section becomes twice as expensive. The most expensive ranges of the
  // first, the second and the cheap sections then cost 6, 2 and 0.25. The mean per rank is 27 / 4.
  costs[0] = 4.0f;
  CHECK(imbalance(costs, first, ranges) == Approx((6.0 + 2.0 + 0.25) / (27.0 / 4.0)));
  CHECK(imbalance({}, {0}, section_ranges({}, {0}, 3)) == 1.0);
}

TEST_CASE("a new cut of sections keeps the boundaries that are close to their best places") {
  // An expensive section with a mean cost of 4 per range, and two cheap ones that are cut together.
  std::vector<float> costs(16, 1.0f);
  const SectionStarts first = {0, 16, 18, 20};
  costs.insert(costs.end(), 4, 0.0625f);
  const SectionRanges best = section_ranges(costs, first, 4);
  CHECK(best == SectionRanges{{0, 4, 8, 12, 16}, {16, 17, 18, 18, 18}, {18, 18, 18, 19, 20}});
  const SectionRanges present = {{0, 5, 8, 10, 16}, {16, 17, 18, 18, 18}, {18, 18, 18, 18, 20}};
  CHECK(section_ranges(costs, first, present, 0.0) == best);
  // The cost between the present boundary 5 and the best one, 4, is 1. Between 10 and 12, it is 2.
  CHECK(section_ranges(costs, first, present, 0.25) ==
        SectionRanges{{0, 5, 8, 12, 16}, {16, 17, 18, 18, 18}, {18, 18, 18, 19, 20}});
  CHECK(section_ranges(costs, first, present, 1.0) == present);
  // The first section becomes cheap, and the last one expensive. The first two sections are then
  // cut together. Counted in pieces of both, their present boundaries are 6, 10 and 12.
  std::fill(costs.begin(), costs.begin() + 16, 0.0f);
  costs[19] = 8.0f;
  CHECK(section_ranges(costs, first, present, 0.05) ==
        SectionRanges{{0, 6, 16, 16, 16}, {16, 16, 17, 17, 18}, {18, 18, 18, 20, 20}});
  CHECK(section_ranges({}, {0}, SectionRanges{}, 0.05).empty());
}

TEST_CASE("sorted runs are merged in order, and equal elements keep the order of the runs") {
  const auto before = [](const std::array<int, 2>& a, const std::array<int, 2>& b) {
    return a[0] < b[0];
  };
  const auto place_of = [](const std::array<int, 2>& element) {
    return static_cast<std::uint64_t>(element[0]);
  };
  for (const int n_runs : {0, 1, 2, 3, 5, 8}) {
    Gathered<std::array<int, 2>> all;
    all.start = {0};
    for (int run = 0; run < n_runs; ++run) {
      for (int i = 0; i < 3 * run; ++i) all.elements.push_back({i * i % 50 / (run + 1) + i, run});
      all.start.push_back(all.elements.size());
    }
    for (std::size_t run = 0; run + 1 < all.start.size(); ++run)
      std::stable_sort(all.elements.begin() + static_cast<std::ptrdiff_t>(all.start[run]),
                       all.elements.begin() + static_cast<std::ptrdiff_t>(all.start[run + 1]),
                       before);
    std::vector<std::array<int, 2>> expected = all.elements, elements = all.elements;
    std::stable_sort(expected.begin(), expected.end(), before);
    merge_runs(elements, all.start, before);
    CHECK(elements == expected);
    CHECK(merged(all, place_of) == expected);
  }
}
