// Joins the records that the threads of all ranks have made.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <vector>

#include "core/parallel/agreement.h"
#include "core/parallel/communicator.h"

namespace loomstone {

// Collective. Returns the records of all ranks, in the order of ranks and threads. If any rank has
// a failure, all ranks throw the error of the lowest such rank.
template <class Record>
std::vector<Record> gather_records(const Communicator& communicator,
                                   const std::vector<std::vector<Record>>& of_thread,
                                   std::exception_ptr failure) {
  std::vector<Record> own;
  for (const std::vector<Record>& part : of_thread) own.insert(own.end(), part.begin(), part.end());
  if (communicator.size() == 1) {
    if (failure) std::rethrow_exception(failure);
    return own;
  }
  const int size = communicator.size(), rank = communicator.rank();
  std::vector<std::int64_t> counts(size);
  counts[rank] = failure ? -1 : static_cast<std::int64_t>(own.size());
  std::vector<std::size_t> offsets(size + 1);
  for (int i = 0; i <= size; ++i) offsets[i] = i * sizeof(std::int64_t);
  communicator.gather_all(counts.data(), offsets);
  for (const std::int64_t count : counts)
    if (count < 0) agree_on(communicator, failure);
  for (int i = 0; i < size; ++i)
    offsets[i + 1] = offsets[i] + static_cast<std::size_t>(counts[i]) * sizeof(Record);
  if (offsets.back() == 0) return {};
  // Records consist of numbers only, so copying their bytes copies them.
  std::vector<Record> all(offsets.back() / sizeof(Record));
  std::copy(own.begin(), own.end(),
            all.begin() + static_cast<std::ptrdiff_t>(offsets[rank] / sizeof(Record)));
  communicator.gather_all(static_cast<void*>(all.data()), offsets);
  return all;
}

}  // namespace loomstone
