// Rank 1 stops in the first test of a task pool. The other ranks find no work, and the time-out
// LOOMSTONE_MPI_TIMEOUT ends all ranks.
#include <csignal>

#include "core/parallel/task_pool.h"
#include "tests/mpi/rank_program.h"

using namespace loomstone;
using testing::RankProgram;

int main(int argc, char** argv) {
  return RankProgram(argc, argv).run([](const RankProgram& program) {
    const Communicator& all = *program.communicator();
    const std::unique_ptr<Mailbox> mailbox = all.open_mailbox();
    TaskPool pool(*mailbox);
    const std::vector<NodeTest> tests(all.rank() == 1 ? 1 : 0);
    pool.run(Team{1}, tests,
             [](int, const NodeTest&, std::vector<NodeTest>&) { std::raise(SIGSTOP); });
  });
}
