// The elements that a sweep of strain limiting still has to evaluate: all of them, or the active
// set. That is first the batches in which the check found a violation, then those with a vertex
// that moved since their last evaluation. The strain of any other element is unchanged, so sweeps
// over the active set give the same bits as sweeps over all elements.
#pragma once

#include <cstdint>
#include <vector>

#include "core/cloth/limits/limit_elements.h"

namespace loomstone {

// Scratch of one call of the limiter.
class ActiveSet {
 public:
  enum class Contents { AllElements, Violations };  // Violations: what add() names
  enum class Order { Batches, SingleElements };     // SingleElements: for the random order

  ActiveSet(const LimitElements& elements, const limit::Tables& tables, Contents contents,
            Order order);

  bool all_elements() const { return all_; }  // corrections need not be reported to spread()
  std::size_t n_colours() const { return of_colour_.size(); }
  std::int64_t evaluations() const { return evaluations_; }
  // Batches with a vertex that was moved by any correction so far.
  const std::vector<Index>& moved() const { return moved_list_; }

  void add(Index batch);
  // Appends the batches of a colour to `list` and removes them from the set.
  void take(std::size_t colour, std::vector<Index>& list);
  // Removes a single element; false if it was not in the set.
  bool take_one(Index slot);
  // Adds every element that shares a moved vertex with the corrected one.
  void spread(Index corrected);

 private:
  static constexpr std::uint8_t every_lane = 255;
  const LimitElements& elements_;
  const limit::Tables& tables_;
  const bool all_, singly_;
  std::vector<std::uint8_t> waits_, moved_;  // (batches) bits of lanes, flags
  std::vector<std::vector<Index>> of_colour_;
  std::vector<Index> moved_list_;
  std::int64_t evaluations_ = 0;
};

}  // namespace loomstone
