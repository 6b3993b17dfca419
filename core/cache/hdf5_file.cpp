// Functions of Hdf5File for files and groups.
#include "core/cache/hdf5_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include <sys/stat.h>
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
  checked(H5Pset_driver(access, journal_driver(), nullptr), "HDF5", "use the file driver");
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  return access;
}

// Number of chunk addresses per B-tree node. In a typical run, a node of this size has room for the
// addresses of all chunks of a dataset, so nodes are rarely split.
constexpr unsigned chunks_per_node = 512;

hid_t file_creation() {
  const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_istore_k(creation, chunks_per_node / 2);
  return creation;
}

// Reads the headers and chunk indices of all datasets. The driver keeps them in memory.
void read_structure(hid_t file) {
  const auto visit = [](hid_t root, const char* name, const H5O_info_t* info, void*) -> herr_t {
    if (info->type != H5O_TYPE_DATASET) return 0;
    const Id dataset(H5Dopen2(root, name, H5P_DEFAULT));
    const Id space(H5Dget_space(dataset)), creation(H5Dget_create_plist(dataset));
    hsize_t n_chunks = 0;
    if (H5Pget_layout(creation) == H5D_CHUNKED) H5Dget_num_chunks(dataset, space, &n_chunks);
    return 0;
  };
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, visit, nullptr, H5O_INFO_BASIC);
}

// Properties of a file that change when it is written or replaced.
struct FileStamp {
  dev_t device = 0;
  ino_t inode = 0;
  off_t length = 0;
  std::int64_t seconds = 0, nanoseconds = 0;
  bool operator==(const FileStamp&) const = default;
};

FileStamp stamp_of(const std::string& path) {
  struct stat status = {};
  if (stat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino, status.st_size, status.st_mtim.tv_sec,
          status.st_mtim.tv_nsec};
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
  // If rows have changed since the last flush, the changes may be incomplete. Nothing more is then
  // written to the file.
  if (shared_->unwritten) discard_changes(file_);
  H5Fclose(file_);
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
  // If another process changes the file while its structure is read, the parts that have been read
  // may not fit together.
  constexpr int most_attempts = 200;
  constexpr useconds_t pause = 5000;  // [us]
  const Id access(file_access());
  for (int attempt = 1;; ++attempt) {
    const FileStamp before = stamp_of(path);
    const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
    if (id < 0 && stamp_of(path) == before)
      fail<CacheError>("{}: the file is truncated or damaged: {}.", path, last_cause());
    if (id >= 0) read_structure(id);
    if (id >= 0 && still_as_read(id)) return {id, path};
    if (id >= 0) H5Fclose(id);
    if (attempt == most_attempts)
      fail<CacheError>("{}: another process writes the file all the time; try again later.", path);
    usleep(pause);
  }
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
