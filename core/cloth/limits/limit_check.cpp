#include "core/cloth/limits/limit_check.h"

#include <algorithm>
#include <tuple>

#include "core/base/sort_unique.h"
#include "core/cloth/material/strain_limit.h"

namespace loomstone {

namespace {

constexpr Index batches_per_check = 16;
constexpr int message = 26;  // doubles sent per batch: index, excess, 24 strains

}  // namespace

std::vector<Index> LimitReport::broken_elements() const {
  std::vector<Index> elements;
  for (const BrokenLimit& each : broken) elements.push_back(each.element);
  sort_unique(elements);
  return elements;
}

LimitCheck::LimitCheck(const LimitElements& elements, const Communicator* ranks)
    : elements_(elements),
      ranks_(ranks && ranks->size() > 1 ? ranks : nullptr),
      excess_(elements.n_batches(), 0.0),
      strains_(24 * static_cast<std::size_t>(elements.n_batches())) {}

void LimitCheck::check_all(const Team& team, const limit::Tables& tables,
                           const limit::Motion& motion) {
  const std::int64_t n = elements_.n_batches(), rank = ranks_ ? ranks_->rank() : 0,
                     size = ranks_ ? ranks_->size() : 1;
  const Index first = static_cast<Index>(n * rank / size),
              last = static_cast<Index>(n * (rank + 1) / size);
  parallel_ranges(team, last - first, batches_per_check, [&](Index begin, Index end) {
    limit::check(tables, motion, nullptr, first + begin, end - begin, violations());
  });
  if (ranks_) share(first, last);
}

void LimitCheck::check(const Team& team, const limit::Tables& tables, const limit::Motion& motion,
                       const std::vector<Index>& batches) {
  parallel_ranges(team, static_cast<Index>(batches.size()), batches_per_check,
                  [&](Index begin, Index end) {
                    limit::check(tables, motion, batches.data(), begin, end - begin, violations());
                  });
}

// Gives all ranks the results of all batches. This rank has checked the batches [first, last).
// Ranks first gather the numbers of batches with an excess. If all these numbers are zero, nothing
// else is sent.
void LimitCheck::share(Index first, Index last) {
  const int size = ranks_->size(), rank = ranks_->rank();
  std::vector<std::int64_t> counts(size, 0);
  for (Index b = first; b < last; ++b) counts[rank] += excess_[b] > 0.0;
  std::vector<std::size_t> offsets(size + 1, 0);
  for (int r = 0; r < size; ++r) offsets[r + 1] = offsets[r] + sizeof counts[0];
  ranks_->gather_all(counts.data(), offsets);
  std::fill(excess_.begin(), excess_.begin() + first, 0.0);
  std::fill(excess_.begin() + last, excess_.end(), 0.0);
  for (int r = 0; r < size; ++r)
    offsets[r + 1] = offsets[r] + message * sizeof(double) * static_cast<std::size_t>(counts[r]);
  if (offsets.back() == 0) return;
  std::vector<double> received(offsets.back() / sizeof(double));
  double* next = received.data() + offsets[rank] / sizeof(double);
  for (Index b = first; b < last; ++b) {
    if (excess_[b] == 0.0) continue;
    next[0] = b, next[1] = excess_[b];
    next = std::copy_n(strain(b), 24, next + 2);
  }
  ranks_->gather_all(received.data(), offsets);
  for (std::size_t i = 0; i < received.size(); i += message) {
    const auto b = static_cast<std::size_t>(received[i]);
    excess_[b] = received[i + 1];
    std::copy_n(received.data() + i + 2, 24, strains_.data() + 24 * b);
  }
}

void LimitCheck::add_to(LimitReport& report, const limit::Tables& tables,
                        const limit::Motion& motion, double unit) const {
  double most = 0.0;
  report.squares.assign(elements_.n_limits(), 0.0);
  for (Index b = 0; b < elements_.n_batches(); ++b) {
    if (excess_[b] == 0.0) continue;  // no excess, the usual case
    const limit::Bounds& bounds = tables.bounds[tables.bounds_of[b]];
    const double* strain = this->strain(b);
    for (Index lane = 0; lane < 8; ++lane) {
      const Index element = elements_.element(8 * b + lane);
      if (element < 0) continue;
      double largest = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double e = strain[8 * k + lane];
        const double beyond = std::max({0.0, e - bounds.high[k], bounds.low[k] - e});
        report.excess[k] = std::max(report.excess[k], unit * beyond);
        largest = std::max(largest, beyond);
        report.squares[tables.bounds_of[b]] += beyond * beyond;
        const double margin = limit_margin(e > bounds.high[k] ? bounds.high[k] : bounds.low[k]);
        if (!motion.v && beyond > margin) report.broken.push_back({element, k, beyond});
      }
      report.beyond += largest > motion.tolerance;
      if (largest > most || (largest == most && most > 0.0 && element < report.worst))
        most = largest, report.worst = element;
    }
  }
  std::sort(
      report.broken.begin(), report.broken.end(), [](const BrokenLimit& a, const BrokenLimit& b) {
        return std::tuple(-a.excess, a.element, a.mode) < std::tuple(-b.excess, b.element, b.mode);
      });
}

}  // namespace loomstone
