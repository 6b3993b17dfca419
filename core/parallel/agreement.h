// Turns a failure on one rank into the same error on all ranks.
#pragma once

#include <exception>

#include "core/parallel/communicator.h"

namespace loomstone {

// Collective. If any rank has a failure, all ranks throw the error of the lowest such rank. The
// type of the error stays the same, with two exceptions: a NewtonFailure (integrator.h) becomes a
// StepFailure, and an exception that is not a loomstone::Error becomes an Error. The text stays the
// same, too, but for std::bad_alloc it gives advice. Returns if `failure` is null on every rank.
void agree_on(const Communicator& communicator, std::exception_ptr failure);

// Collective. Runs `body` on this rank. If `body` throws on any of several ranks, all ranks throw
// as agree_on() does. A single rank throws the exception of `body` itself.
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
