// Search for pairs of features that is divided among all ranks ([Thomaszewski2010], 5.3). In every
// search, the hierarchies of PartitionTrees are traversed from their roots. During a search, ranks
// communicate only to balance their work (Decomposition::Dynamic). At its end, they gather results
// and, in some dynamic searches, costs.
#pragma once

#include <algorithm>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/collision/broad_phase/broad_phase.h"
#include "core/collision/broad_phase/decomposition.h"
#include "core/collision/broad_phase/partition_trees.h"
#include "core/collision/broad_phase/search_deal.h"
#include "core/parallel/communicator.h"
#include "core/parallel/pool_replay.h"
#include "core/parallel/repeated_gather.h"
#include "core/parallel/task_pool.h"

namespace loomstone {

class SharedSearch {
 public:
  // `broad_phase` tells which pairs of features do not collide because of an attachment. `model`,
  // `pairs` and `broad_phase` must outlive this object. Construction and destruction are
  // collective.
  SharedSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
               const BroadPhase& broad_phase, Decomposition decomposition,
               std::shared_ptr<const Communicator> communicator);
  // Like the first constructor, but cuts the sequence of the rows of all cloths into `n_parts`
  // ranges instead of one range for each rank.
  SharedSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
               const BroadPhase& broad_phase, Decomposition decomposition,
               std::shared_ptr<const Communicator> communicator, int n_parts);

  // Receives a pair of features. Called concurrently by different threads.
  using Take = std::function<void(int thread, Index surface_pair, ContactKind kind, PairKey key)>;

  // Collective. Passes to take() all pairs of features that belong to one of the surface pairs and
  // whose 18-DOPs overlap, each on one rank. The 18-DOPs enclose `motion` and are inflated by
  // motion.inflation. Omits pairs that do not collide because of an attachment, and pairs that
  // share a vertex. All other pairs that come closer than the sum of the inflations of their
  // surfaces are thus found. If take() throws on a rank, all ranks throw in gather().
  void each_pair(const Team& team, const InflatedMotion& motion, const Take& take);

  // Collective. Ends a search that each_pair() began. Returns the records that the threads of all
  // ranks made in it. `of_thread` contains those of each thread of this rank.
  template <class Record>
  std::vector<Record> gather(const std::vector<std::vector<Record>>& of_thread) {
    struct Nothing {};
    const auto own = [&](Nothing&) {
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
      std::vector<Record> records;
      for (const std::vector<Record>& part : of_thread)
        records.insert(records.end(), part.begin(), part.end());
      return records;
    };
    std::vector<Record> all =
        gather_again<Record, Nothing>(*communicator_, room_[still_], own).gathered.elements;
    result_bytes_ = all.size() * sizeof(Record);
    most_bytes_ = std::max(most_bytes_, result_bytes_);
    if (measures_) deals_[still_].end(*communicator_, n_parts_);
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    return all;
  }

  // Returns the number of records that fit into the memory of the largest result so far. Threads
  // can reserve memory for this number before a search.
  template <class Record>
  std::size_t most_records() const {
    return most_bytes_ / sizeof(Record);
  }

  // Makes searches measure the costs of their tests and write them to `tests`. A search then runs
  // on one thread of one rank and performs the tests of `n_parts` ranks.
  void record(RecordedTests* tests) { recorded_ = tests; }

  // Sets how the threads of a rank divide a static search. Loops are the default, because they were
  // faster on two threads (docs/experiments/collisions.md).
  void set_traversal(Traversal traversal) { traversal_ = traversal; }
  // Report on the last search of this rank; empty if this search did not use the task pool.
  const PoolReport& report() const { return report_; }
  // Time of the last search on this rank, from the end of the first refit to the end of gather()
  // [s]. If refits_only_compared() returns true, the first refit computes only the boxes of nodes,
  // so the time includes the refit of features.
  double seconds() const { return seconds_; }
  std::size_t result_bytes() const { return result_bytes_; }  // size of the last result [bytes]
  // Memory of the hierarchies on this rank [bytes].
  std::size_t hierarchy_bytes() const { return trees_.bytes(); }

 private:
  std::vector<NodeTest> first_tests(int rank, int n_ranks) const;
  bool refits_only_compared() const;
  void compare(const Team& team, const InflatedMotion& motion, const Take& take);
  void features(int thread, const NodeTest& leaf, const Take& take);
  void traverse(const Team& team, std::vector<NodeTest> tests, const TaskPool::Perform& perform);

  const BroadPhase& broad_phase_;
  const Decomposition decomposition_;
  Traversal traversal_ = Traversal::Loops;
  std::shared_ptr<const Communicator> communicator_;
  std::unique_ptr<Mailbox> mailbox_;
  TaskPool pool_;
  const int n_parts_;
  PartitionTrees trees_;
  RecordedTests* recorded_ = nullptr;
  bool still_ = false;     // all vertices are at rest in the current or last search
  bool measures_ = false;  // the current or last search measures costs for `deals_`
  // Divisions of the tests with which ranks start dynamic searches. Index 0: searches in which
  // vertices move; index 1: searches in which all vertices are at rest (`still_`).
  SearchDeal deals_[2];
  GatherRoom room_[2];                            // for results; indices as in deals_
  std::vector<PartitionTrees::Scratch> scratch_;  // one for each thread
  std::exception_ptr failure_;                    // exception in each_pair(), for gather()
  PoolReport report_;
  std::chrono::steady_clock::time_point start_;
  double seconds_ = 0.0;
  std::size_t result_bytes_ = 0, most_bytes_ = 0;
};

}  // namespace loomstone
