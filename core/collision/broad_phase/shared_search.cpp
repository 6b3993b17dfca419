#include "core/collision/broad_phase/shared_search.h"

#include <utility>

#include "core/collision/broad_phase/record_tests.h"
#include "core/parallel/traverse.h"

namespace loomstone {

namespace {

// With Traversal::Loops and several threads, one thread expands tests until there are at least this
// many tests, or only tests of two clusters. A parallel loop then performs each of these tests and
// all that follow from it.
constexpr std::size_t enough_branches = 256;

}  // namespace

SharedSearch::SharedSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                           const BroadPhase& broad_phase, Decomposition decomposition,
                           std::shared_ptr<const Communicator> communicator)
    : SharedSearch(model, pairs, broad_phase, decomposition, communicator, communicator->size()) {}

SharedSearch::SharedSearch(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                           const BroadPhase& broad_phase, Decomposition decomposition,
                           std::shared_ptr<const Communicator> communicator, int n_parts)
    : broad_phase_(broad_phase),
      decomposition_(decomposition),
      communicator_(std::move(communicator)),
      mailbox_(communicator_->open_mailbox()),
      pool_(*mailbox_),
      n_parts_(n_parts),
      trees_(model, pairs, n_parts),
      deals_{SearchDeal(trees_.n_clusters()), SearchDeal(trees_.n_clusters())} {}

void SharedSearch::each_pair(const Team& team, const InflatedMotion& motion, const Take& take) {
  still_ = &motion.x0 == &motion.x1;
  // Only boxes of vertices at rest show whether a tree is still compact, so trees are rebuilt only
  // in searches in which no vertex moves.
  if (refits_only_compared())
    trees_.refit_nodes(team, motion, still_);
  else
    trees_.refit(team, motion, still_);
  scratch_.resize(std::max(1, team.threads));
  SearchDeal& deal = deals_[still_];
  measures_ = !recorded_ && decomposition_ == Decomposition::Dynamic && n_parts_ > 1 &&
              deal.begin(team.threads);
  const auto perform_test = [&](int thread, const NodeTest& test, std::vector<NodeTest>& stack) {
    if (!PartitionTrees::leaf(test)) {
      trees_.expand(test, stack, scratch_[thread]);
      return;
    }
    features(thread, test, take);
  };
  const TaskPool::Perform perform = [&](int thread, const NodeTest& test,
                                        std::vector<NodeTest>& stack) {
    if (!measures_) return perform_test(thread, test, stack);
    const auto start = std::chrono::steady_clock::now();
    perform_test(thread, test, stack);
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    deal.add(thread, trees_.first_cluster(test), passed.count());
  };
  failure_ = nullptr;
  report_ = {};
  start_ = std::chrono::steady_clock::now();
  try {
    if (recorded_) {
      record_tests([&](int rank) { return first_tests(rank, n_parts_); }, n_parts_, perform,
                   *recorded_);
      if (deal.known())
        recorded_->deal_exchanges = SearchDeal::exchanges(), recorded_->deal_bytes = deal.bytes();
      return;
    }
    if (refits_only_compared()) {
      compare(team, motion, take);
      return;
    }
    std::vector<NodeTest> tests = first_tests(communicator_->rank(), communicator_->size());
    if (decomposition_ == Decomposition::Dynamic)
      report_ = pool_.run(team, std::move(tests), perform);
    else
      traverse(team, std::move(tests), perform);
  } catch (...) {
    failure_ = std::current_exception();
  }
}

// Returns whether a rank first finds the clusters that overlap and then, to save memory, refits
// only the features of these clusters. This is the case in static searches on several ranks with
// Traversal::Loops, unless costs are recorded. All other searches first refit all features.
bool SharedSearch::refits_only_compared() const {
  return decomposition_ == Decomposition::Static && traversal_ == Traversal::Loops && !recorded_ &&
         communicator_->size() > 1;
}

// Performs all tests of this rank in a static search: finds the pairs of clusters that overlap,
// refits their features, then compares these features.
void SharedSearch::compare(const Team& team, const InflatedMotion& motion, const Take& take) {
  std::vector<std::vector<NodeTest>> of_thread(scratch_.size());
  traverse(team, first_tests(communicator_->rank(), communicator_->size()),
           [&](int thread, const NodeTest& test, std::vector<NodeTest>& stack) {
             if (PartitionTrees::leaf(test))
               of_thread[thread].push_back(test);
             else
               trees_.expand(test, stack, scratch_[thread]);
           });
  std::vector<NodeTest> leaves;
  for (const std::vector<NodeTest>& part : of_thread)
    leaves.insert(leaves.end(), part.begin(), part.end());
  trees_.refit_features(team, motion, leaves);
  constexpr Index at_once = 64;
  const Index n = static_cast<Index>(leaves.size());
  parallel_tasks(team, (n + at_once - 1) / at_once, [&](Index range) {
    for (Index i = range * at_once; i < std::min(n, (range + 1) * at_once); ++i)
      features(thread_number(), leaves[i], take);
  });
}

// Passes the pairs of features with overlapping boxes in the two clusters of a test to take().
// Omits pairs that share a vertex and pairs that do not collide because of an attachment.
void SharedSearch::features(int thread, const NodeTest& leaf, const Take& take) {
  trees_.features(leaf, scratch_[thread], [&](Index pair, ContactKind kind, PairKey key) {
    if (!broad_phase_.attached(kind, key)) take(thread, pair, kind, key);
  });
}

// Returns the tests with which a rank starts the current search.
std::vector<NodeTest> SharedSearch::first_tests(int rank, int n_ranks) const {
  const SearchDeal& deal = deals_[still_];
  if (!deal.known()) return trees_.top_level(rank, n_ranks);
  return trees_.tests_of(deal.starts()[rank], deal.starts()[rank + 1]);
}

// Performs `tests` and the tests that follow from them, without passing any to other ranks.
void SharedSearch::traverse(const Team& team, std::vector<NodeTest> tests,
                            const TaskPool::Perform& perform) {
  if (team.threads > 1 && traversal_ == Traversal::Loops) {
    std::vector<NodeTest> next, leaves;
    while (!tests.empty() && tests.size() + leaves.size() < enough_branches) {
      next.clear();
      for (const NodeTest& test : tests)
        if (PartitionTrees::leaf(test))
          leaves.push_back(test);
        else
          trees_.expand(test, next, scratch_[0]);
      tests.swap(next);
    }
    tests.insert(tests.end(), leaves.begin(), leaves.end());
    parallel_tasks(team, static_cast<Index>(tests.size()), [&](Index i) {
      std::vector<NodeTest> stack = {tests[i]};
      while (!stack.empty()) {
        const NodeTest test = stack.back();
        stack.pop_back();
        perform(thread_number(), test, stack);
      }
    });
  } else {
    parallel_traverse(team, std::move(tests), perform);
  }
}

}  // namespace loomstone
