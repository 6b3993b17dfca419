// The four kinds of error the library throws. A message says what must hold, what came, where, and
// what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace loomstone {

// Base of all errors of this library.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Something a user gave cannot be simulated (ValueError in Python).
class InvalidInput : public Error {
 public:
  using Error::Error;
};

// A solve or a step failed; the message names stage, step and time (RuntimeError in Python).
class SolverFailure : public Error {
 public:
  using Error::Error;
};

// A file could not be written, read or understood (OSError in Python).
class CacheError : public Error {
 public:
  using Error::Error;
};

// This build or combination does not offer the request (NotImplementedError in Python).
class Unsupported : public Error {
 public:
  using Error::Error;
};

}  // namespace loomstone
