// Datasets that grow by rows.
#include <utility>

#include "core/cache/hdf5_handles.h"

namespace loomstone {

using namespace hdf5;

namespace {

// Returns a new HDF5 type for the numbers or structs of rows in memory. The caller must close it.
hid_t memory_type(const RowFormat& format) {
  if (format.columns.empty()) return H5Tcopy(native(format.type));
  const hid_t type = H5Tcreate(H5T_COMPOUND, format.bytes);
  for (const Column& column : format.columns)
    H5Tinsert(type, column.name.c_str(), column.offset, native(column.type));
  return type;
}

// Selects `count` rows of a dataset, starting at row `first`. Returns the dataspaces of the file
// and of memory, which the caller must close.
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

// Without compression, chunks are allocated when the dataset grows, so writing a row does not
// change the dataset's chunk index in the file. Compressed chunks cannot be allocated before they
// are written. No chunk is initialised with a fill value. The chunk cache is disabled, so that rows
// are passed to the file driver as soon as they are written.
Hdf5Rows Hdf5File::create_rows(const std::string& path, const RowFormat& format,
                               RowStorage storage) {
  const Quiet quiet;
  Hdf5Rows rows;
  rows.file_ = shared_;
  rows.path_ = path;
  rows.components_ = format.components;
  rows.memory_type_ = memory_type(format);
  const int rank = format.components == 1 ? 1 : 2;
  const hsize_t components = static_cast<hsize_t>(format.components);
  const hsize_t none[2] = {0, components}, limit[2] = {H5S_UNLIMITED, components};
  const hsize_t block[2] = {static_cast<hsize_t>(storage.block), components};
  const Id space(H5Screate_simple(rank, none, limit));
  const Id creation(H5Pcreate(H5P_DATASET_CREATE)), access(H5Pcreate(H5P_DATASET_ACCESS));
  H5Pset_chunk(creation, rank, block);
  if (storage.compression > 0) {
    H5Pset_shuffle(creation);
    H5Pset_deflate(creation, static_cast<unsigned>(storage.compression));
  } else {
    H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  }
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
    damaged(shared_->name, path + " does not have the expected shape");
  return rows;
}

}  // namespace loomstone
