// RAII owners of HDF5 identifiers, and conversion of HDF5 errors to exceptions, shared by the
// source files that call the C API of serial HDF5 (without MPI).
#pragma once

#include <string>

#include <hdf5.h>

#include "core/cache/hdf5_file.h"

namespace loomstone::hdf5 {

// HDF5 prints no errors while an object of this type exists. checked() turns errors into exceptions
// instead.
struct Quiet {
  H5E_auto2_t print = nullptr;
  void* to = nullptr;
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
};

// Owns an HDF5 identifier of any kind and releases it at the end of its scope.
struct Id {
  hid_t id;
  explicit Id(hid_t given) : id(given) {}
  Id(const Id&) = delete;
  ~Id() {
    if (id >= 0) H5Idec_ref(id);
  }
  operator hid_t() const { return id; }
};

// Returns the innermost description in HDF5's error stack, or the system error that it quotes.
// Returns "no cause given" if there is none.
std::string last_cause();

// Throws CacheError "NAME: could not TRIED: CAUSE."
[[noreturn]] void failed(const std::string& name, const std::string& tried);

// Returns the result, or calls failed() if it is negative.
hid_t checked(hid_t result, const std::string& name, const std::string& tried);

// Throws CacheError "NAME: the file is damaged: WHAT."
[[noreturn]] void damaged(const std::string& name, const std::string& what);

hid_t native(Number type);

}  // namespace loomstone::hdf5
