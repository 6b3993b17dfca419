// RAII wrapper of HDF5 files and datasets that hides the HDF5 API. Failures become CacheErrors that
// name the file and state what is damaged, or which operation failed and why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace loomstone {

enum class Number { UInt8, Int32, Int64, Float64 };

template <class T>
Number number_of();
template <>
inline Number number_of<std::uint8_t>() {
  return Number::UInt8;
}
template <>
inline Number number_of<std::int32_t>() {
  return Number::Int32;
}
template <>
inline Number number_of<std::int64_t>() {
  return Number::Int64;
}
template <>
inline Number number_of<double>() {
  return Number::Float64;
}

// One named column of a table whose rows are structs.
struct Column {
  std::string name;
  Number type;
  std::size_t offset;  // offset within the struct [bytes]
  std::string unit = {}, meaning = {};
};

// The contents of a row: an array of `components` numbers, or a struct of `bytes` bytes with the
// given columns.
struct RowFormat {
  Number type = Number::Float64;
  int components = 1;
  std::vector<Column> columns = {};
  std::size_t bytes = 0;  // size of the struct; unused without columns
};

// How the rows of a dataset are stored: in chunks of `block` rows. `compression` is the deflate
// level of the chunks, from 1 to 9; 0: no compression.
struct RowStorage {
  std::int64_t block = 1;
  int compression = 0;
};

// State shared by a file and its datasets.
struct Hdf5Shared {
  std::string name;        // current path or name of the file
  bool unwritten = false;  // true: rows have changed since the last successful flush
};

// A dataset that can grow by rows. write() copies `count` rows from the memory at `rows` to the
// dataset, and read() copies `count` rows of the dataset to the memory at `rows`. In the dataset,
// these rows begin at row `first`.
class Hdf5Rows {
 public:
  Hdf5Rows() = default;
  Hdf5Rows(Hdf5Rows&& other) noexcept;
  Hdf5Rows& operator=(Hdf5Rows&& other) noexcept;
  ~Hdf5Rows();
  std::int64_t size() const;
  void resize(std::int64_t rows);
  void write(std::int64_t first, std::int64_t count, const void* rows);
  void read(std::int64_t first, std::int64_t count, void* rows) const;

 private:
  friend class Hdf5File;
  std::int64_t dataset_ = -1, memory_type_ = -1;
  int components_ = 1;
  std::shared_ptr<Hdf5Shared> file_;
  std::string path_;  // path of the dataset within the file
  std::string name() const { return file_->name + ": " + path_; }
};

class Hdf5File {
 public:
  static Hdf5File create(const std::string& path);  // replaces an existing file
  static Hdf5File create_in_memory(const std::string& name);
  // Opens the file for reading only. If another process changes the file meanwhile, tries again for
  // up to about a second. Throws CacheError if no attempt succeeds, or if the file is missing or
  // damaged.
  static Hdf5File open(const std::string& path);
  static Hdf5File open_image(std::span<const unsigned char> bytes, const std::string& name);
  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&& other) noexcept;
  ~Hdf5File();

  const std::string& name() const { return shared_->name; }
  void rename_to(const std::string& path);  // renames the open file without syncing
  void flush();                             // makes all written data visible to other processes
  void close();                             // throws CacheError if data cannot be written
  std::vector<unsigned char> image();       // bytes of an in-memory file, as they would be on disk

  std::int64_t length() const;  // [bytes]
  void create_group(const std::string& path);
  bool has(const std::string& path) const;
  std::vector<std::string> children(const std::string& group) const;  // sorted by name

  // Attributes of groups and datasets.
  void write_text_attribute(const std::string& object, const std::string& name,
                            const std::string& text);
  void write_text_attribute(const std::string& object, const std::string& name,
                            const std::vector<std::string>& texts);
  // Writes the attributes `units` and `description` of a dataset.
  void describe(const std::string& path, const std::string& unit, const std::string& meaning);
  // Writes `units` and `description` of a table, with one entry for each column.
  void describe(const std::string& path, const std::vector<Column>& columns);
  void write_attribute(const std::string& object, const std::string& name,
                       std::span<const std::int64_t> values);
  void update_attribute(const std::string& object, const std::string& name, std::int64_t value);
  bool has_attribute(const std::string& object, const std::string& name) const;
  std::string text_attribute(const std::string& object, const std::string& name) const;
  std::int64_t attribute(const std::string& object, const std::string& name) const;

  // Arrays of fixed shape ({} for a single number).
  void write_array(const std::string& path, Number type, const std::vector<std::int64_t>& shape,
                   const void* values);
  template <class T>
  std::vector<T> read_array(const std::string& path,
                            std::vector<std::int64_t>* shape = nullptr) const;

  // Datasets with one string or a list of strings. Strings are UTF-8 and have a fixed length in the
  // file.
  void write_text(const std::string& path, const std::string& text);
  void write_texts(const std::string& path, const std::vector<std::string>& texts);
  std::string read_text(const std::string& path) const;
  std::vector<std::string> read_texts(const std::string& path) const;

  // Datasets that can grow by rows. The file grows by whole chunks.
  Hdf5Rows create_rows(const std::string& path, const RowFormat& format, RowStorage storage);
  Hdf5Rows open_rows(const std::string& path, const RowFormat& format) const;

 private:
  Hdf5File(std::int64_t file, std::string name);
  std::int64_t open_to_read_array(const std::string& path, Number type,
                                  std::vector<std::int64_t>& shape) const;
  void finish_reading_array(std::int64_t dataset, const std::string& path, Number type,
                            void* values) const;
  std::int64_t file_ = -1;
  std::shared_ptr<Hdf5Shared> shared_;
};

template <class T>
std::vector<T> Hdf5File::read_array(const std::string& path,
                                    std::vector<std::int64_t>* shape) const {
  std::vector<std::int64_t> found;
  const std::int64_t dataset = open_to_read_array(path, number_of<T>(), found);
  std::size_t count = 1;
  for (std::int64_t length : found) count *= static_cast<std::size_t>(length);
  std::vector<T> values(count);
  finish_reading_array(dataset, path, number_of<T>(), values.data());
  if (shape) *shape = found;
  return values;
}

}  // namespace loomstone
