#include "core/parallel/section_ranges.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/parallel/shared_work.h"

namespace loomstone {

namespace {

// A section with at least this fraction of the total cost is cut separately, and all other sections
// are cut together. Our choice.
constexpr double expensive = 0.05;

double sum_between(const std::vector<float>& costs, std::size_t begin, std::size_t end) {
  return std::accumulate(costs.begin() + static_cast<std::ptrdiff_t>(begin),
                         costs.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
}

// Returns groups of sections that are cut together: first a group of all inexpensive sections,
// which may be empty, then one group for each expensive section.
std::vector<std::vector<std::size_t>> groups(const std::vector<float>& costs,
                                             const SectionStarts& first) {
  const double sum = sum_between(costs, 0, costs.size());
  std::vector<std::vector<std::size_t>> found(1);
  for (std::size_t s = 0; s + 1 < first.size(); ++s)
    if (sum_between(costs, first[s], first[s + 1]) >= expensive * sum)
      found.push_back({s});
    else
      found.front().push_back(s);
  return found;
}

// Returns the positions at which `ranges` cuts a group of sections: its start, the boundaries
// between its ranges, and its end. A position is the number of pieces of the group that precede it.
std::vector<std::size_t> cuts_of(const std::vector<std::size_t>& group, const SectionStarts& first,
                                 const SectionRanges& ranges) {
  std::vector<std::size_t> cuts(ranges.front().size(), 0);
  for (const std::size_t s : group)
    for (std::size_t r = 0; r < cuts.size(); ++r) cuts[r] += ranges[s][r] - first[s];
  return cuts;
}

// Replaces cuts[r] by present[r] if the cost between the two is at most `tolerance` times the mean
// cost of a range. A cut that would then precede the previous cut is moved to the previous cut.
void keep_close(const std::vector<float>& costs, const std::vector<std::size_t>& present,
                double tolerance, std::vector<std::size_t>& cuts) {
  const double most =
      tolerance * sum_between(costs, 0, costs.size()) / static_cast<double>(cuts.size() - 1);
  for (std::size_t r = 1; r + 1 < cuts.size(); ++r) {
    const auto [begin, end] = std::minmax(cuts[r], present[r]);
    if (sum_between(costs, begin, end) <= most) cuts[r] = present[r];
    cuts[r] = std::max(cuts[r], cuts[r - 1]);
  }
}

// Divides the sections of each group. `cut` receives the group and the costs of its pieces, and
// returns the positions at which the group is cut.
template <class Cut>
SectionRanges ranges_of_groups(const std::vector<float>& costs, const SectionStarts& first,
                               Cut&& cut) {
  SectionRanges ranges(first.size() - 1);
  for (const std::vector<std::size_t>& group : groups(costs, first)) {
    std::vector<float> joined;
    for (const std::size_t s : group)
      joined.insert(joined.end(), costs.begin() + static_cast<std::ptrdiff_t>(first[s]),
                    costs.begin() + static_cast<std::ptrdiff_t>(first[s + 1]));
    const std::vector<std::size_t> cuts = cut(group, joined);
    std::size_t begin = 0;  // start of the section in `joined`
    for (const std::size_t s : group) {
      const std::size_t end = begin + first[s + 1] - first[s];
      for (const std::size_t start : cuts)
        ranges[s].push_back(first[s] + std::clamp(start, begin, end) - begin);
      begin = end;
    }
  }
  return ranges;
}

}  // namespace

SectionRanges section_ranges(const std::vector<float>& costs, const SectionStarts& first,
                             int n_ranges) {
  return ranges_of_groups(costs, first, [&](const auto&, const std::vector<float>& of_group) {
    return contiguous_ranges(of_group, n_ranges);
  });
}

SectionRanges section_ranges(const std::vector<float>& costs, const SectionStarts& first,
                             const SectionRanges& present, double tolerance) {
  if (present.empty()) return {};
  const int n_ranges = static_cast<int>(present.front().size()) - 1;
  const auto cut = [&](const std::vector<std::size_t>& group, const std::vector<float>& of_group) {
    std::vector<std::size_t> cuts = contiguous_ranges(of_group, n_ranges);
    keep_close(of_group, cuts_of(group, first, present), tolerance, cuts);
    return cuts;
  };
  return ranges_of_groups(costs, first, cut);
}

double imbalance(const std::vector<float>& costs, const SectionStarts& first,
                 const SectionRanges& ranges) {
  if (ranges.empty()) return 1.0;
  const std::size_t n_ranges = ranges.front().size() - 1;
  double most = 0.0, sum = 0.0;
  for (const std::vector<std::size_t>& group : groups(costs, first)) {
    double most_of_group = 0.0;
    for (std::size_t r = 0; r < n_ranges; ++r) {
      double cost = 0.0;
      for (const std::size_t s : group) cost += sum_between(costs, ranges[s][r], ranges[s][r + 1]);
      most_of_group = std::max(most_of_group, cost);
      sum += cost;
    }
    most += most_of_group;
  }
  return sum > 0.0 ? most * static_cast<double>(n_ranges) / sum : 1.0;
}

}  // namespace loomstone
