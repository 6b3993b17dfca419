// Elements that a strain-limiting sweep still has to evaluate: either all elements or the active
// set. The active set starts with the batches in which LimitCheck found an excess above the
// tolerance. A sweep removes the elements that it evaluates. When a correction moves a vertex, all
// elements at this vertex are added. The strain of all other elements has not changed since they
// were last checked or evaluated, so another evaluation would have no effect. Sweeps over the
// active set and over all elements therefore give bitwise identical results.
#pragma once

#include <cstdint>
#include <vector>

#include "core/cloth/limits/limit_elements.h"

namespace loomstone {

// Elements to evaluate during one call of the limiter.
class ActiveSet {
 public:
  enum class Contents { AllElements, Violations };  // Violations: empty until add() is called
  enum class Order { Batches, SingleElements };     // SingleElements: for random order

  ActiveSet(const LimitElements& elements, const limit::Tables& tables, Contents contents,
            Order order);

  bool all_elements() const { return all_; }  // true: spread() need not be called
  std::size_t n_colours() const { return of_colour_.size(); }
  std::int64_t evaluations() const { return evaluations_; }
  // Batches with a vertex that a correction has moved; empty if the set contains all elements.
  const std::vector<Index>& moved() const { return moved_list_; }

  void add(Index batch);
  // Appends to `list` those batches of a colour that are in the set. Removes them from the set
  // unless all_elements() is true.
  void take(std::size_t colour, std::vector<Index>& list);
  // Removes a single element from the set unless all_elements() is true. Returns false if the
  // element was not in the set.
  bool take_one(Index slot);
  // Adds every element that shares a moved vertex with the corrected element. With Order::Batches,
  // adds the whole batches of these elements.
  void spread(Index corrected);

 private:
  static constexpr std::uint8_t every_lane = 255;
  const LimitElements& elements_;
  const limit::Tables& tables_;
  const bool all_, singly_;
  // (batches) waits_: bit mask of the lanes that are in the set; moved_: 1 if the batch is in
  // moved_list_, otherwise 0.
  std::vector<std::uint8_t> waits_, moved_;
  std::vector<std::vector<Index>> of_colour_;
  std::vector<Index> moved_list_;
  std::int64_t evaluations_ = 0;
};

}  // namespace loomstone
