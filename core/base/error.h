// The errors that the library throws. If possible, a message names the place of the error and
// states what is required, what was given, and what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace loomstone {

// Base class of all errors of this library.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The user's input is invalid (ValueError in Python).
class InvalidInput : public Error {
 public:
  using Error::Error;
};

// A solve or a step failed (RuntimeError in Python). If a step of a simulation failed, the message
// names the step and the time at its start.
class SolverFailure : public Error {
 public:
  using Error::Error;
};

// A step failed, but a shorter one may succeed. Causes: no solution was found, asynchronous steps
// of triangles are unstable or would have to be too short, or the matrix of the solve is not finite
// or not positive definite. In shorter steps, the mass dominates this matrix.
class StepFailure : public SolverFailure {
 public:
  using SolverFailure::SolverFailure;
};

// A file could not be written, read or interpreted (OSError in Python).
class CacheError : public Error {
 public:
  using Error::Error;
};

// The request is not supported by this build or with this combination of options
// (NotImplementedError in Python).
class Unsupported : public Error {
 public:
  using Error::Error;
};

}  // namespace loomstone
