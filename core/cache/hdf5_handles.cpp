#include "core/cache/hdf5_handles.h"

#include "core/base/message.h"

namespace loomstone::hdf5 {

Quiet::Quiet() {
  // Disables the cleanup of HDF5 at exit. It is not needed, because destructors close all files,
  // and it would print errors for a file that could not be closed on a full disk.
  static const herr_t no_tidying_at_exit = H5dont_atexit();
  static_cast<void>(no_tidying_at_exit);
  H5Eget_auto2(H5E_DEFAULT, &print, &to);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Quiet::~Quiet() { H5Eset_auto2(H5E_DEFAULT, print, to); }

std::string last_cause() {
  std::string cause;
  const auto visit = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    if (entry->desc && *entry->desc) *static_cast<std::string*>(data) = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, visit, &cause);
  const std::string mark = "error message = '";
  const std::size_t from = cause.find(mark);
  if (from != std::string::npos) {
    const std::size_t begin = from + mark.size();
    cause = cause.substr(begin, cause.find('\'', begin) - begin);
  }
  return cause.empty() ? "no cause given" : cause;
}

void failed(const std::string& name, const std::string& tried) {
  fail<CacheError>("{}: could not {}: {}.", name, tried, last_cause());
}

hid_t checked(hid_t result, const std::string& name, const std::string& tried) {
  if (result < 0) failed(name, tried);
  return result;
}

void damaged(const std::string& name, const std::string& what) {
  fail<CacheError>("{}: the file is damaged: {}.", name, what);
}

hid_t native(Number type) {
  switch (type) {
    case Number::UInt8:
      return H5T_NATIVE_UINT8;
    case Number::Int32:
      return H5T_NATIVE_INT32;
    case Number::Int64:
      return H5T_NATIVE_INT64;
    case Number::Float64:
      return H5T_NATIVE_DOUBLE;
  }
  return -1;
}

}  // namespace loomstone::hdf5
