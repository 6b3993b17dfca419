// The one source file that includes hdf5.h (serial variant, C interface).
#include "core/cache/hdf5_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"

namespace loomstone {

namespace {

// HDF5 prints its errors unless told otherwise, per thread; we turn them into exceptions instead.
struct Quiet {
  H5E_auto2_t print = nullptr;
  void* to = nullptr;
  Quiet() {
    // Files close themselves here. HDF5's own tidying at exit would complain about a file that
    // could not be closed because the disk is full.
    static const herr_t no_tidying_at_exit = H5dont_atexit();
    static_cast<void>(no_tidying_at_exit);
    H5Eget_auto2(H5E_DEFAULT, &print, &to);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, print, to); }
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

// The innermost entry of the error stack says what happened; system errors are quoted inside it.
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

[[noreturn]] void fail(const std::string& name, const std::string& tried) {
  throw CacheError(name + ": could not " + tried + ": " + last_cause() + ".");
}

hid_t checked(hid_t result, const std::string& name, const std::string& tried) {
  if (result < 0) fail(name, tried);
  return result;
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

// A new type identifier; the caller closes it.
hid_t memory_type(const RowFormat& format) {
  if (format.columns.empty()) return H5Tcopy(native(format.type));
  const hid_t type = H5Tcreate(H5T_COMPOUND, format.bytes);
  for (const Column& column : format.columns)
    H5Tinsert(type, column.name.c_str(), column.offset, native(column.type));
  return type;
}

// No locks: a viewer may look at a run while it writes, and network file systems often refuse
// locks.
hid_t file_access() {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_file_locking(access, false, true);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  return access;
}

// Chunk addresses live in B-trees. A node this wide holds all chunks of a usual run, so that no
// node is ever split: a split touches several nodes, and a process killed in between would leave an
// unreadable file.
constexpr unsigned chunks_per_node = 512;

hid_t file_creation() {
  const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_istore_k(creation, chunks_per_node / 2);
  return creation;
}

}  // namespace

Hdf5Rows::Hdf5Rows(Hdf5Rows&& other) noexcept { *this = std::move(other); }

Hdf5Rows& Hdf5Rows::operator=(Hdf5Rows&& other) noexcept {
  std::swap(dataset_, other.dataset_);
  std::swap(memory_type_, other.memory_type_);
  std::swap(components_, other.components_);
  std::swap(file_, other.file_);
  std::swap(path_, other.path_);
  return *this;
}

Hdf5Rows::~Hdf5Rows() {
  const Quiet quiet;
  if (dataset_ >= 0) H5Dclose(dataset_);
  if (memory_type_ >= 0) H5Tclose(memory_type_);
}

std::int64_t Hdf5Rows::size() const {
  const Quiet quiet;
  const Id space(checked(H5Dget_space(dataset_), name(), "read the shape"));
  hsize_t lengths[H5S_MAX_RANK] = {};
  H5Sget_simple_extent_dims(space, lengths, nullptr);
  return static_cast<std::int64_t>(lengths[0]);
}

void Hdf5Rows::resize(std::int64_t rows) {
  const Quiet quiet;
  const hsize_t lengths[2] = {static_cast<hsize_t>(rows), static_cast<hsize_t>(components_)};
  file_->unwritten = true;
  checked(H5Dset_extent(dataset_, lengths), name(), "grow");
}

namespace {

// The part of a file's dataset that holds `count` rows from `first`, and the memory space that
// matches it.
std::pair<hid_t, hid_t> select_rows(hid_t dataset, int components, std::int64_t first,
                                    std::int64_t count, const std::string& name) {
  const hsize_t start[2] = {static_cast<hsize_t>(first), 0};
  const hsize_t length[2] = {static_cast<hsize_t>(count), static_cast<hsize_t>(components)};
  const hid_t file = checked(H5Dget_space(dataset), name, "read the shape");
  const int rank = H5Sget_simple_extent_ndims(file);
  const hid_t memory = H5Screate_simple(rank, length, nullptr);
  H5Sselect_hyperslab(file, H5S_SELECT_SET, start, nullptr, length, nullptr);
  return {file, memory};
}

}  // namespace

void Hdf5Rows::write(std::int64_t first, std::int64_t count, const void* rows) {
  if (count == 0) return;
  const Quiet quiet;
  const auto [file, memory] = select_rows(dataset_, components_, first, count, name());
  const Id file_space(file), memory_space(memory);
  file_->unwritten = true;
  checked(H5Dwrite(dataset_, memory_type_, memory, file, H5P_DEFAULT, rows), name(), "write");
}

void Hdf5Rows::read(std::int64_t first, std::int64_t count, void* rows) const {
  if (count == 0) return;
  const Quiet quiet;
  const auto [file, memory] = select_rows(dataset_, components_, first, count, name());
  const Id file_space(file), memory_space(memory);
  checked(H5Dread(dataset_, memory_type_, memory, file, H5P_DEFAULT, rows), name(), "read");
}

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

// Closing writes what is cached and then where the file ends; on a full disk that says more than
// there is, and no reader takes such a file. What no flush has confirmed goes nowhere instead: the
// file stays as after a kill.
void Hdf5File::cut_off() const {
  const Id access(H5Fget_access_plist(file_));
  void* handle = nullptr;
  if (H5Pget_driver(access) != H5FD_SEC2 || H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle) < 0)
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
  if (!file) throw CacheError(path + ": could not open the file: " + std::strerror(errno) + ".");
  unsigned char start[8] = {};
  const std::size_t n_read = std::fread(start, 1, 8, file);
  std::fclose(file);
  const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  if (n_read < 8 || std::memcmp(start, signature, 8) != 0)
    throw CacheError(
        path +
        ": not an HDF5 file, or one whose beginning is damaged; give a file that loomstone wrote.");
  const Id access(file_access());
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  if (id < 0) throw CacheError(path + ": the file is truncated or damaged: " + last_cause() + ".");
  return {id, path};
}

Hdf5File Hdf5File::open_image(std::span<const unsigned char> bytes, const std::string& name) {
  const Quiet quiet;
  const Id access(file_access());
  H5Pset_fapl_core(access, 1 << 20, false);
  H5Pset_file_image(access, const_cast<unsigned char*>(bytes.data()), bytes.size());
  const std::string unique =
      name + "@" + std::to_string(reinterpret_cast<std::uintptr_t>(bytes.data()));
  const hid_t id = H5Fopen(unique.c_str(), H5F_ACC_RDONLY, access);
  if (id < 0) throw CacheError(name + ": the file is truncated or damaged: " + last_cause() + ".");
  return {id, name};
}

void Hdf5File::rename_to(const std::string& path) {
  if (std::rename(shared_->name.c_str(), path.c_str()) != 0)
    throw CacheError(path + ": could not rename " + shared_->name +
                     " to it: " + std::strerror(errno) + ".");
  shared_->name = path;
}

// The superblock records the end of the file, and HDF5 may write it before blocks that were set
// aside exist. Lengthen the file first, so that at no moment the file is shorter than it says.
void Hdf5File::flush() {
  const Quiet quiet;
  hsize_t length = 0;
  void* handle = nullptr;
  checked(H5Fget_filesize(file_, &length), shared_->name, "measure the file");
  checked(H5Fget_vfd_handle(file_, H5P_DEFAULT, &handle), shared_->name, "measure the file");
  const int descriptor = *static_cast<int*>(handle);
  struct stat status = {};
  if (fstat(descriptor, &status) == 0 && static_cast<hsize_t>(status.st_size) < length &&
      ftruncate(descriptor, static_cast<off_t>(length)) != 0)
    throw CacheError(shared_->name + ": could not lengthen the file: " + std::strerror(errno) +
                     ".");
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
  if (length < 0) fail(shared_->name, "take the file's image");
  std::vector<unsigned char> bytes(static_cast<std::size_t>(length));
  if (H5Fget_file_image(file_, bytes.data(), bytes.size()) < 0)
    fail(shared_->name, "take the file's image");
  return bytes;
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

void Hdf5File::write_text_attribute(const std::string& object, const std::string& name,
                                    const std::string& text) {
  const Quiet quiet;
  const Id type(H5Tcopy(H5T_C_S1)), space(H5Screate(H5S_SCALAR));
  H5Tset_size(type, std::max<std::size_t>(text.size(), 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_ASCII);
  const std::string tried = "write attribute " + name + " of " + object;
  const Id attribute(checked(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space,
                                               H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             shared_->name, tried));
  checked(H5Awrite(attribute, type, text.data()), shared_->name, tried);
}

void Hdf5File::write_attribute(const std::string& object, const std::string& name,
                               std::span<const std::int64_t> values) {
  const Quiet quiet;
  const hsize_t length = values.size();
  const Id space(length == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &length, nullptr));
  const std::string tried = "write attribute " + name + " of " + object;
  const Id attribute(checked(H5Acreate_by_name(file_, object.c_str(), name.c_str(), H5T_STD_I64LE,
                                               space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             shared_->name, tried));
  checked(H5Awrite(attribute, H5T_NATIVE_INT64, values.data()), shared_->name, tried);
}

// Object and attribute are opened anew every time: a handle kept open fails to write after a flush
// (1.10.8).
void Hdf5File::update_attribute(const std::string& object, const std::string& name,
                                std::int64_t value) {
  const Quiet quiet;
  const std::string tried = "write attribute " + name + " of " + object;
  const Id owner(checked(H5Oopen(file_, object.c_str(), H5P_DEFAULT), shared_->name, tried));
  const Id attribute(checked(H5Aopen(owner, name.c_str(), H5P_DEFAULT), shared_->name, tried));
  checked(H5Awrite(attribute, H5T_NATIVE_INT64, &value), shared_->name, tried);
}

bool Hdf5File::has_attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  return has(object) && H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::string Hdf5File::text_attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  const std::string tried = "read attribute " + name + " of " + object;
  const Id attribute(
      checked(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
              shared_->name, tried));
  const Id type(checked(H5Aget_type(attribute), shared_->name, tried));
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0)
    throw CacheError(shared_->name + ": the file is damaged: attribute " + name + " of " + object +
                     " is not a text.");
  std::string text(H5Tget_size(type), '\0');
  checked(H5Aread(attribute, type, text.data()), shared_->name, tried);
  return text.c_str();
}

std::int64_t Hdf5File::attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  const std::string tried = "read attribute " + name + " of " + object;
  const Id attribute(
      checked(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
              shared_->name, tried));
  const Id space(checked(H5Aget_space(attribute), shared_->name, tried));
  if (H5Sget_simple_extent_npoints(space) != 1)
    throw CacheError(shared_->name + ": the file is damaged: attribute " + name + " of " + object +
                     " is not one number.");
  std::int64_t value = 0;
  checked(H5Aread(attribute, H5T_NATIVE_INT64, &value), shared_->name, tried);
  return value;
}

void Hdf5File::write_array(const std::string& path, Number type,
                           const std::vector<std::int64_t>& shape, const void* values) {
  const Quiet quiet;
  const std::vector<hsize_t> lengths(shape.begin(), shape.end());
  const Id space(shape.empty()
                     ? H5Screate(H5S_SCALAR)
                     : H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr));
  const Id dataset(checked(
      H5Dcreate2(file_, path.c_str(), native(type), space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      shared_->name, "create " + path));
  if (H5Sget_simple_extent_npoints(space) > 0)
    checked(H5Dwrite(dataset, native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), shared_->name,
            "write " + path);
}

std::int64_t Hdf5File::open_to_read_array(const std::string& path, Number type,
                                          std::vector<std::int64_t>& shape) const {
  const Quiet quiet;
  Id dataset(checked(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), shared_->name, "open " + path));
  const Id space(checked(H5Dget_space(dataset), shared_->name, "read the shape of " + path));
  const Id stored(checked(H5Dget_type(dataset), shared_->name, "read the type of " + path));
  if (H5Tequal(stored, native(type)) <= 0)
    throw CacheError(shared_->name + ": the file is damaged: " + path +
                     " holds another type of number than expected.");
  hsize_t lengths[H5S_MAX_RANK] = {}, file_length = 0;
  const int rank = H5Sget_simple_extent_dims(space, lengths, nullptr);
  checked(H5Fget_filesize(file_, &file_length), shared_->name, "measure the file");
  double bytes = static_cast<double>(H5Tget_size(stored));
  for (int axis = 0; axis < rank; ++axis) bytes *= static_cast<double>(lengths[axis]);
  if (bytes > static_cast<double>(file_length))
    throw CacheError(shared_->name + ": the file is damaged: " + path +
                     " claims to be larger than the file.");
  shape.assign(lengths, lengths + std::max(rank, 0));
  return std::exchange(dataset.id, -1);
}

void Hdf5File::finish_reading_array(std::int64_t dataset, const std::string& path, Number type,
                                    void* values) const {
  const Quiet quiet;
  const Id owner(dataset), space(H5Dget_space(dataset));
  if (H5Sget_simple_extent_npoints(space) > 0)
    checked(H5Dread(dataset, native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), shared_->name,
            "read " + path);
}

// Blocks are set aside as soon as the dataset grows into them and never filled, so that writing a
// row moves bytes to a place that is already in the file's tables. No cache: a row goes straight to
// the file.
Hdf5Rows Hdf5File::create_rows(const std::string& path, const RowFormat& format,
                               std::int64_t block_rows) {
  const Quiet quiet;
  Hdf5Rows rows;
  rows.file_ = shared_;
  rows.path_ = path;
  rows.components_ = format.components;
  rows.memory_type_ = memory_type(format);
  const int rank = format.components == 1 ? 1 : 2;
  const hsize_t components = static_cast<hsize_t>(format.components);
  const hsize_t none[2] = {0, components}, limit[2] = {H5S_UNLIMITED, components};
  const hsize_t block[2] = {static_cast<hsize_t>(block_rows), components};
  const Id space(H5Screate_simple(rank, none, limit));
  const Id creation(H5Pcreate(H5P_DATASET_CREATE)), access(H5Pcreate(H5P_DATASET_ACCESS));
  H5Pset_chunk(creation, rank, block);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  H5Pset_chunk_cache(access, 1, 0, 1.0);
  const Id stored_type(H5Tcopy(rows.memory_type_));
  if (!format.columns.empty()) H5Tpack(stored_type);
  rows.dataset_ =
      checked(H5Dcreate2(file_, path.c_str(), stored_type, space, H5P_DEFAULT, creation, access),
              shared_->name, "create " + path);
  return rows;
}

Hdf5Rows Hdf5File::open_rows(const std::string& path, const RowFormat& format) const {
  const Quiet quiet;
  Hdf5Rows rows;
  rows.file_ = shared_;
  rows.path_ = path;
  rows.components_ = format.components;
  rows.memory_type_ = memory_type(format);
  rows.dataset_ =
      checked(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), shared_->name, "open " + path);
  const Id space(checked(H5Dget_space(rows.dataset_), shared_->name, "read the shape of " + path));
  hsize_t lengths[H5S_MAX_RANK] = {0, 1};
  const int rank = H5Sget_simple_extent_dims(space, lengths, nullptr);
  const int expected_rank = format.components == 1 ? 1 : 2;
  if (rank != expected_rank || (rank == 2 && lengths[1] != static_cast<hsize_t>(format.components)))
    throw CacheError(shared_->name + ": the file is damaged: " + path +
                     " does not have the expected shape.");
  return rows;
}

}  // namespace loomstone
