// Owners of HDF5 identifiers, and HDF5's errors as exceptions: what the source files that call HDF5
// (serial variant, C interface) share.
#pragma once

#include <string>

#include <hdf5.h>

#include "core/cache/hdf5_file.h"

namespace loomstone::hdf5 {

// While one lives HDF5 prints no errors in this thread (it does by default); ours are exceptions.
struct Quiet {
  H5E_auto2_t print = nullptr;
  void* to = nullptr;
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
};

// Owner of any HDF5 identifier within a function.
struct Id {
  hid_t id;
  explicit Id(hid_t given) : id(given) {}
  Id(const Id&) = delete;
  ~Id() {
    if (id >= 0) H5Idec_ref(id);
  }
  operator hid_t() const { return id; }
};

// The innermost entry of HDF5's error stack: what happened, or the system's error quoted inside it.
std::string last_cause();

// Throws CacheError "NAME: could not TRIED: CAUSE."
[[noreturn]] void failed(const std::string& name, const std::string& tried);

// The result, or failed() where it is negative.
hid_t checked(hid_t result, const std::string& name, const std::string& tried);

// Throws CacheError "NAME: the file is damaged: WHAT."
[[noreturn]] void damaged(const std::string& name, const std::string& what);

hid_t native(Number type);

}  // namespace loomstone::hdf5
