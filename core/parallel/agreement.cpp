#include "core/parallel/agreement.h"

#include <new>
#include <string>

#include "core/base/error.h"

namespace loomstone {

namespace {

// Numbers by which ranks tell each other the type of an error. python/loomstone/ranks.py uses the
// same numbers.
enum Kind : int { None, Other, Input, Solver, Cache, NotOffered, Step };

Kind describe(const std::exception_ptr& failure, std::string& text) {
  try {
    if (!failure) return None;
    std::rethrow_exception(failure);
  } catch (const InvalidInput& error) {
    text = error.what();
    return Input;
  } catch (const StepFailure& error) {
    text = error.what();
    return Step;
  } catch (const SolverFailure& error) {
    text = error.what();
    return Solver;
  } catch (const CacheError& error) {
    text = error.what();
    return Cache;
  } catch (const Unsupported& error) {
    text = error.what();
    return NotOffered;
  } catch (const std::bad_alloc&) {
    text = "there is not enough memory; use fewer triangles or ranks on this machine";
  } catch (const std::exception& error) {
    text = error.what();
  } catch (...) {
    text = "an unknown failure";
  }
  return Other;
}

}  // namespace

void agree_on(const Communicator& communicator, std::exception_ptr failure) {
  std::string text;
  int kind = describe(failure, text);
  communicator.agree(kind, text);
  switch (kind) {
    case None:
      return;
    case Input:
      throw InvalidInput(text);
    case Solver:
      throw SolverFailure(text);
    case Step:
      throw StepFailure(text);
    case Cache:
      throw CacheError(text);
    case NotOffered:
      throw Unsupported(text);
    default:
      throw Error(text);
  }
}

}  // namespace loomstone
