// Sums and solutions of the conjugate gradient solver must have the same bits on any number of
// ranks; the program prints their hashes. Messages and halo rows must arrive, and an error must be
// the same on all ranks.
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "tests/linalg/random_system.h"
#include "tests/mpi/rank_program.h"

using namespace loomstone;
using testing::random_system;
using testing::RandomSystem;
using testing::RankProgram;

namespace {

void messages_arrive(const RankProgram& program) {
  const Communicator& all = *program.communicator();
  program.claim("the maximum is that of all ranks",
                all.maximum(10 * all.rank()) == 10 * (all.size() - 1));
  std::vector<double> numbers(1000, all.rank() == all.size() - 1 ? 2.5 : 0.0);
  all.broadcast(numbers.data(), numbers.size() * sizeof(double), all.size() - 1);
  program.claim("a broadcast reaches all", numbers.front() == 2.5 && numbers.back() == 2.5);

  // Rank r contributes r + 1 bytes.
  std::vector<std::size_t> offsets = {0};
  for (int rank = 0; rank < all.size(); ++rank) offsets.push_back(offsets.back() + rank + 1);
  std::vector<unsigned char> bytes(offsets.back(), 255);
  std::fill(bytes.begin() + offsets[all.rank()], bytes.begin() + offsets[all.rank() + 1],
            all.rank());
  all.gather_all(bytes.data(), offsets);
  for (int rank = 0; rank < all.size(); ++rank)
    for (std::size_t i = offsets[rank]; i < offsets[rank + 1]; ++i)
      program.claim("all bytes are gathered", bytes[i] == rank);

  // Each rank sends two messages to every other rank.
  std::vector<int> sent(2 * all.size()), received(2 * all.size(), -1);
  std::vector<Communicator::Message> to, from;
  for (const int round : {0, 1})
    for (int rank = 0; rank < all.size(); ++rank) {
      if (rank == all.rank()) continue;
      sent[2 * rank + round] = 100 * all.rank() + 10 * rank + round;
      to.push_back({rank, &sent[2 * rank + round], sizeof(int)});
      from.push_back({rank, &received[2 * rank + round], sizeof(int)});
    }
  all.exchange(to, from);
  for (const int round : {0, 1})
    for (int rank = 0; rank < all.size(); ++rank)
      if (rank != all.rank())
        program.claim("messages arrive in order",
                      received[2 * rank + round] == 100 * rank + 10 * all.rank() + round);
  all.barrier();
}

void sums_of_ranks_are_exact(const RankProgram& program) {
  const Communicator& all = *program.communicator();
  // To the first sum, each rank adds 1e20, 1 and -1e20. To the second sum, the last rank adds NaN,
  // and every other rank adds 1.
  std::vector<BinnedSum> sums(2);
  for (const double number : {1e20, 1.0, -1e20}) sums[0].add(number);
  sums[1].add(all.rank() == all.size() - 1 ? std::nan("") : 1.0);
  all.add(sums.data(), 2);
  program.claim("sums over ranks lose no number", sums[0].value() == all.size());
  program.claim("NaN on one rank is NaN on all", std::isnan(sums[1].value()));
}

// Operations that are in progress at the same time do not disturb each other.
void operations_overlap(const RankProgram& program) {
  const Communicator& all = *program.communicator();
  BinnedSum sum;
  sum.add(all.rank());
  std::vector<std::size_t> offsets;
  for (int rank = 0; rank <= all.size(); ++rank) offsets.push_back(rank * sizeof(int));
  std::vector<int> gathered(all.size(), -1);
  gathered[all.rank()] = 7 * all.rank();
  const int next = (all.rank() + 1) % all.size(), last = (all.rank() + all.size() - 1) % all.size();
  int sent = all.rank(), received = all.size() > 1 ? -1 : last;
  all.start_add(&sum, 1);
  all.start_gather(gathered.data(), offsets);
  if (all.size() > 1)
    all.start_exchange({{next, &sent, sizeof sent}}, {{last, &received, sizeof received}});
  all.finish();
  program.claim("a sum arrives beside other messages",
                2.0 * sum.value() == all.size() * (all.size() - 1.0));
  program.claim("a message arrives beside others", received == last);
  for (int rank = 0; rank < all.size(); ++rank)
    program.claim("a gather arrives beside others", gathered[rank] == 7 * rank);
}

void sums_keep_their_bits(const RankProgram& program) {
  const Index rows = 5000;
  const RowLayout layout(rows, program.communicator());
  std::vector<double> sums((rows + rows_per_block - 1) / rows_per_block,
                           std::numeric_limits<double>::quiet_NaN());
  for (Index row = layout.begin(); row < layout.end(); ++row) {
    if (row % rows_per_block == 0) sums[row / rows_per_block] = 0.0;
    sums[row / rows_per_block] += std::sin(1.0 * row) / (1.0 + row);
  }
  const double sum = layout.sum(sums);
  program.print_hash("sum", &sum, sizeof sum);
}

void halos_are_refreshed_and_nothing_else(const RankProgram& program) {
  const RandomSystem system = random_system(45, 2, 0, program.communicator());
  const RowLayout& layout = *system.layout;
  std::vector<double> rows(4 * layout.n_rows(), -1.0);
  for (Index row = layout.begin(); row < layout.end(); ++row) rows[4 * row] = row;
  layout.exchange(system.halo, rows.data(), 4);
  std::vector<bool> wanted(layout.n_rows(), false);
  for (Index row = layout.begin(); row < std::min(layout.end(), system.matrix.n_rows()); ++row)
    for (Index k = system.matrix.row_start()[row]; k < system.matrix.row_start()[row + 1]; ++k)
      wanted[system.matrix.columns()[k]] = true;
  for (Index row = 0; row < layout.n_rows(); ++row)
    program.claim("rows that owned rows are coupled to are current, others untouched",
                  rows[4 * row] == (wanted[row] || layout.owns(row) ? row : -1.0) &&
                      rows[4 * row + 1] == -1.0);
  layout.gather(rows.data(), 4);
  for (Index row = 0; row < layout.n_rows(); ++row)
    program.claim("gathered rows are current", rows[4 * row] == row && rows[4 * row + 1] == -1.0);
}

// Sets the rows of b and x that this rank does not own to NaN.
void forget_rows_of_others(RandomSystem& system) {
  for (Index row = 0; row < system.b.rows(); ++row)
    if (!system.layout->owns(row))
      system.b.row(row).setConstant(std::nan("")), system.x.row(row).setConstant(std::nan(""));
}

void solutions_keep_their_bits(const RankProgram& program) {
  // Side 90 gives 64 blocks of rows and three coarse levels. Side 45 gives 16 blocks, and side 13
  // gives 2, so that a third rank owns none. Terms couple distant rows with one another and with
  // bodies.
  for (const Index side : {90, 45, 13}) {
    RandomSystem system = random_system(side, 2, side * 6, program.communicator());
    forget_rows_of_others(system);
    Points x = system.x;
    const auto solver = make_linear_solver({LinearMethod::Pcg, 1e-8, 2000});
    SolveMemory memory;
    const auto solve = [&] {
      return solver->solve(Team{program.threads()}, system.view(), system.b, x, memory,
                           Unchanged::Nothing);
    };
    const LinearReport report = solve();
    program.claim("the solve converges", report.converged && report.iterations > 5);
    program.print_hash("pcg", x.data(), sizeof(double) * x.size());
    program.print_hash("iterations", &report.iterations, sizeof report.iterations);
    // Solves again with the same solver, starting from the solution.
    const LinearReport again = solve();
    program.claim("a solution is a good guess", again.iterations == 0);

    // The couplings of removed terms may remain in the coarse levels, depending on the number of
    // ranks. Their blocks are zero, so they must not change the bits of the solution.
    system.terms.resize(system.terms.size() / 3);
    x = system.x;
    program.claim("the solve with fewer terms converges", solve().converged);
    program.print_hash("pcg with fewer terms", x.data(), sizeof(double) * x.size());
  }
}

// The stiffness is multiplied by 1e9, so the solve takes many iterations.
void stiff_solutions_keep_their_bits(const RankProgram& program) {
  RandomSystem system = random_system(20, 0, 0, program.communicator());
  testing::stiffen(system, 1e9);
  std::fill(system.fixed.begin(), system.fixed.end(), 0);
  system.x.setZero();
  Points x = system.x;
  const LinearReport report = make_linear_solver({LinearMethod::Pcg, 1e-6, 20000})
                                  ->solve(Team{program.threads()}, system.view(), system.b, x);
  program.claim("the stiff solve converges", report.converged);
  program.print_hash("stiff pcg", x.data(), sizeof(double) * x.size());
}

// An error on one rank is thrown on all ranks with the same message.
void errors_are_agreed(const RankProgram& program) {
  const auto message_of = [&](const RandomSystem& system, LinearMethod method) -> std::string {
    Points x = system.x;
    try {
      make_linear_solver({method, 1e-8, 2000})
          ->solve(Team{program.threads()}, system.view(), system.b, x);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  RandomSystem poisoned = random_system(45, 2, 60, program.communicator());
  forget_rows_of_others(poisoned);
  if (poisoned.layout->owns(2000)) poisoned.b(2000, 2) = std::nan("");
  const std::string not_finite = message_of(poisoned, LinearMethod::Pcg);
  program.claim("all ranks name the row that is not finite",
                not_finite.find("row 2000") != std::string::npos);

  RandomSystem indefinite = random_system(45, 2, 60, program.communicator());
  if (indefinite.layout->owns(1800))
    indefinite.matrix.block_map(indefinite.matrix.diagonal()[1800]).setConstant(-1.0);
  const std::string bad_block = message_of(indefinite, LinearMethod::Pcg);
  program.claim("all ranks name the row that is not positive definite",
                bad_block.find("row 1800") != std::string::npos);

  if (program.communicator()->size() == 1) return;
  for (const LinearMethod method : {LinearMethod::GaussSeidel, LinearMethod::Direct})
    program.claim("methods of one rank are refused on all",
                  message_of(indefinite, method).find("runs on one rank") != std::string::npos);
}

void bad_communicators_are_refused(const RankProgram& program) {
  if (program.communicator()->size() == 1) return;
  std::string message = "no error";
  try {
    mpi_communicator(-2);
  } catch (const InvalidInput& error) {
    message = error.what();
  }
  program.claim("a handle that names no communicator is refused",
                message.find("py2f()") != std::string::npos);
  program.claim("the world may be asked for again",
                mpi_communicator()->size() == program.communicator()->size());
}

}  // namespace

int main(int argc, char** argv) {
  return RankProgram(argc, argv).run([](const RankProgram& program) {
    messages_arrive(program);
    sums_of_ranks_are_exact(program);
    operations_overlap(program);
    sums_keep_their_bits(program);
    halos_are_refreshed_and_nothing_else(program);
    solutions_keep_their_bits(program);
    stiff_solutions_keep_their_bits(program);
    errors_are_agreed(program);
    bad_communicators_are_refused(program);
  });
}
