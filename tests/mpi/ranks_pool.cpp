// Task pools on ranks of MPI: in each of 1,000 rounds, every test is performed once. Over all
// rounds, every rank requests work, gives work to others, and refuses requests.
#include <chrono>

#include "core/parallel/task_pool.h"
#include "tests/mpi/rank_program.h"
#include "tests/parallel/random_tree.h"

using namespace loomstone;
using testing::RandomTree;
using testing::RankProgram;

namespace {

constexpr int n_rounds = 1000;

// Keeps the processor busy, as a test in a search does.
void work_for(std::chrono::nanoseconds duration) {
  const auto end = std::chrono::steady_clock::now() + duration;
  while (std::chrono::steady_clock::now() < end) {
  }
}

// Returns the counts of all ranks, added element by element.
std::vector<std::int32_t> summed(const Communicator& all, const std::vector<std::int32_t>& own) {
  std::vector<std::size_t> offsets(all.size() + 1);
  const std::size_t bytes = own.size() * sizeof(std::int32_t);
  for (int rank = 0; rank <= all.size(); ++rank) offsets[rank] = rank * bytes;
  std::vector<std::int32_t> every(own.size() * all.size()), sums(own.size(), 0);
  std::copy(own.begin(), own.end(), every.begin() + all.rank() * own.size());
  all.gather_all(every.data(), offsets);
  for (std::size_t i = 0; i < every.size(); ++i) sums[i % own.size()] += every[i];
  return sums;
}

void rounds_lose_and_repeat_nothing(const RankProgram& program) {
  const Communicator& all = *program.communicator();
  const std::unique_ptr<Mailbox> mailbox = all.open_mailbox();
  TaskPool pool(*mailbox);
  std::vector<RandomTree> trees;
  std::vector<Index> first = {0};  // index in `visits` of the first node of each tree
  for (unsigned i = 0; i < 16; ++i) {
    trees.emplace_back(1 + i % 5, 1 + 17 * i, i);
    first.push_back(first.back() + trees.back().size());
  }
  std::vector<std::int32_t> visits(first.back(), 0);
  std::int64_t requests = 0, transfers = 0, refusals = 0;
  for (int round = 0; round < n_rounds; ++round) {
    const int tree = round % 16;
    const PoolReport report =
        pool.run(Team{1}, trees[tree].roots((all.rank() + round) % all.size(), all.size()),
                 [&](int, const NodeTest& test, std::vector<NodeTest>& stack) {
                   program.claim("tasks arrive intact", RandomTree::intact(test));
                   ++visits[first[tree] + trees[tree].expand(test, stack)];
                   if (all.size() > 1) work_for(std::chrono::nanoseconds(500));
                 });
    requests += report.requests, transfers += report.transfers, refusals += report.refusals;
  }
  const std::vector<std::int32_t> sums = summed(all, visits);
  for (int tree = 0; tree < 16; ++tree)
    for (Index node = first[tree]; node < first[tree + 1]; ++node)
      program.claim("every test is performed once in every round",
                    sums[node] == n_rounds / 16 + (tree < n_rounds % 16));
  program.print_hash("visits", sums.data(), sums.size() * sizeof(std::int32_t));
  if (all.size() < 2) return;
  program.claim("this rank asks for work", requests > 0);
  program.claim("this rank gives work away", transfers > 0);
  program.claim("this rank refuses requests", refusals > 0);
}

}  // namespace

int main(int argc, char** argv) {
  return RankProgram(argc, argv).run(rounds_lose_and_repeat_nothing);
}
