// Functions of Hdf5File for files and groups.
#include "core/cache/hdf5_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/message.h"
#include "core/cache/hdf5_driver.h"
#include "core/cache/hdf5_handles.h"

namespace loomstone {

using namespace hdf5;

namespace {

// Returns access properties that do not lock files, because a viewer may read a run while it is
// written, and because network file systems often refuse locks. With these properties, closing a
// file also closes all its objects.
hid_t file_access() {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_driver(access, journal_driver(), nullptr);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  return access;
}

// Number of chunk addresses per B-tree node. A node of this size contains all chunks of a typical
// run, so nodes are rarely split.
constexpr unsigned chunks_per_node = 512;

hid_t file_creation() {
  const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_istore_k(creation, chunks_per_node / 2);
  return creation;
}

}  // namespace

Hdf5File::Hdf5File(std::int64_t file, std::string name)
    : file_(file), shared_(std::make_shared<Hdf5Shared>(Hdf5Shared{std::move(name)})) {}

Hdf5File::Hdf5File(Hdf5File&& other) noexcept { *this = std::move(other); }

Hdf5File& Hdf5File::operator=(Hdf5File&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(shared_, other.shared_);
  return *this;
}

Hdf5File::~Hdf5File() {
  const Quiet quiet;
  if (file_ < 0) return;
  if (shared_->unwritten) cut_off();
  H5Fclose(file_);
}

// Redirects the open file to /dev/null, so that closing it writes nothing. On a full disk, closing
// the file would record an end of file beyond the actual end, and the file would be unreadable.
// Data that was not flushed is lost, as if the process had been killed.
void Hdf5File::cut_off() const {
  const Id access(H5Fget_access_plist(file_));
  void* handle = nullptr;
  if (H5Pget_driver(access) != journal_driver() ||
      H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle) < 0)
    return;
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nowhere < 0) return;
  ::dup2(nowhere, *static_cast<int*>(handle));
  ::close(nowhere);
}

Hdf5File Hdf5File::create(const std::string& path) {
  const Quiet quiet;
  const Id access(file_access()), creation(file_creation());
  return {
      checked(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), path, "create the file"),
      path};
}

Hdf5File Hdf5File::create_in_memory(const std::string& name) {
  const Quiet quiet;
  const Id access(file_access());
  H5Pset_fapl_core(access, 1 << 20, false);
  return {
      checked(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), name, "create the file"),
      name};
}

Hdf5File Hdf5File::open(const std::string& path) {
  const Quiet quiet;
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (!file) fail<CacheError>("{}: could not open the file: {}.", path, std::strerror(errno));
  unsigned char start[8] = {};
  const std::size_t n_read = std::fread(start, 1, 8, file);
  std::fclose(file);
  const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  if (n_read < 8 || std::memcmp(start, signature, 8) != 0)
    fail<CacheError>(
        "{}: not an HDF5 file, or one whose beginning is damaged; give a file that loomstone "
        "wrote.",
        path);
  const Id access(file_access());
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  if (id < 0) fail<CacheError>("{}: the file is truncated or damaged: {}.", path, last_cause());
  return {id, path};
}

Hdf5File Hdf5File::open_image(std::span<const unsigned char> bytes, const std::string& name) {
  const Quiet quiet;
  const Id access(file_access());
  H5Pset_fapl_core(access, 1 << 20, false);
  H5Pset_file_image(access, const_cast<unsigned char*>(bytes.data()), bytes.size());
  const std::string unique =
      formatted("{}@{}", name, reinterpret_cast<std::uintptr_t>(bytes.data()));
  const hid_t id = H5Fopen(unique.c_str(), H5F_ACC_RDONLY, access);
  if (id < 0) fail<CacheError>("{}: the file is truncated or damaged: {}.", name, last_cause());
  return {id, name};
}

void Hdf5File::rename_to(const std::string& path) {
  if (std::rename(shared_->name.c_str(), path.c_str()) != 0)
    fail<CacheError>("{}: could not rename {} to it: {}.", path, shared_->name,
                     std::strerror(errno));
  shared_->name = path;
}

void Hdf5File::flush() {
  const Quiet quiet;
  checked(H5Fflush(file_, H5F_SCOPE_LOCAL), shared_->name, "write");
  shared_->unwritten = false;
}

void Hdf5File::close() {
  const Quiet quiet;
  if (file_ >= 0) checked(H5Fclose(std::exchange(file_, -1)), shared_->name, "close the file");
}

std::vector<unsigned char> Hdf5File::image() {
  const Quiet quiet;
  checked(H5Fflush(file_, H5F_SCOPE_LOCAL), shared_->name, "write");
  const ssize_t length = H5Fget_file_image(file_, nullptr, 0);
  if (length < 0) failed(shared_->name, "take the file's image");
  std::vector<unsigned char> bytes(static_cast<std::size_t>(length));
  if (H5Fget_file_image(file_, bytes.data(), bytes.size()) < 0)
    failed(shared_->name, "take the file's image");
  return bytes;
}

std::int64_t Hdf5File::length() const {
  const Quiet quiet;
  hsize_t length = 0;
  checked(H5Fget_filesize(file_, &length), shared_->name, "measure the file");
  return static_cast<std::int64_t>(length);
}

void Hdf5File::create_group(const std::string& path) {
  const Quiet quiet;
  const Id group(checked(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                         shared_->name, "create group " + path));
}

bool Hdf5File::has(const std::string& path) const {
  const Quiet quiet;
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (H5Lexists(file_, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

std::vector<std::string> Hdf5File::children(const std::string& path) const {
  const Quiet quiet;
  const Id group(
      checked(H5Gopen2(file_, path.c_str(), H5P_DEFAULT), shared_->name, "open group " + path));
  std::vector<std::string> names;
  const auto visit = [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(name);
    return 0;
  };
  checked(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &names), shared_->name,
          "list group " + path);
  return names;
}

}  // namespace loomstone
