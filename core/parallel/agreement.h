// One rank's failure becomes the same error on all.
#pragma once

#include <exception>

#include "core/parallel/communicator.h"

namespace loomstone {

// Collective, after a part of the work: throws on all ranks the error of the lowest rank that had
// one, of the same kind and with the same text. Errors that are not ours become Error. Returns
// where `failure` is null everywhere.
void agree_on(const Communicator& communicator, std::exception_ptr failure);

// Does `body` on this rank; where it throws on one rank, all ranks throw. Collective.
template <class Body>
void together(const Communicator& communicator, Body&& body) {
  if (communicator.size() == 1) {
    body();
    return;
  }
  std::exception_ptr failure;
  try {
    body();
  } catch (...) {
    failure = std::current_exception();
  }
  agree_on(communicator, failure);
}

}  // namespace loomstone
