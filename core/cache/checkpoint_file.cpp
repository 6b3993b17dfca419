// A checkpoint is an HDF5 file, which any HDF5 tool can open, followed by a trailer of 24 bytes: a
// mark, and the length and checksum of the HDF5 file. The checksum is verified before HDF5 reads
// the data, because HDF5 does not detect all damage in its input.
#include "core/cache/checkpoint_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <span>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/message.h"
#include "core/base/word_hash.h"
#include "core/cache/file_format.h"
#include "core/cache/hdf5_file.h"

namespace loomstone {

namespace {

constexpr FileFormat format = {"checkpoint", 2, 2, "run the scene again"};
constexpr char mark[8] = {'L', 'O', 'O', 'M', 'C', 'H', 'K', '\n'};

struct Trailer {
  char mark[8];
  std::uint64_t length;
  std::uint64_t checksum;
};
static_assert(sizeof(Trailer) == 24);

// RAII file descriptor. Failures become CacheErrors.
class Descriptor {
 public:
  Descriptor(const std::string& path, int flags)
      : path_(path), descriptor_(::open(path.c_str(), flags, 0644)) {
    if (descriptor_ < 0) failed("open");
  }
  Descriptor(const Descriptor&) = delete;
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  void write(const void* from, std::size_t count) {
    const auto* bytes = static_cast<const unsigned char*>(from);
    while (count > 0) {
      const ssize_t written = ::write(descriptor_, bytes, count);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) failed("write");
      bytes += written;
      count -= static_cast<std::size_t>(written);
    }
  }
  std::vector<unsigned char> read_all() {
    struct stat status = {};
    if (fstat(descriptor_, &status) != 0) failed("read");
    std::vector<unsigned char> bytes(static_cast<std::size_t>(status.st_size));
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t got = ::read(descriptor_, bytes.data() + done, bytes.size() - done);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) failed("read");
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    bytes.resize(done);
    return bytes;
  }
  void sync() {
    if (::fsync(descriptor_) != 0) failed("sync");
  }
  void close() {
    if (::close(std::exchange(descriptor_, -1)) != 0) failed("close");
  }

 private:
  [[noreturn]] void failed(const char* tried) const {
    fail<CacheError>("{}: could not {} the checkpoint: {}.", path_, tried, std::strerror(errno));
  }
  std::string path_;
  int descriptor_;
};

// Returns `name` as a valid dataset name, in which codes that begin with "%" replace "%", "/" and
// ".". In HDF5, "/" separates groups and "." denotes the current group. Throws InvalidInput if
// `name` is empty.
std::string encoded(const std::string& name) {
  if (name.empty()) throw InvalidInput("names in a checkpoint must not be empty.");
  std::string text;
  for (char letter : name) {
    if (letter == '%')
      text += "%25";
    else if (letter == '/')
      text += "%2F";
    else if (letter == '.')
      text += "%2E";
    else
      text += letter;
  }
  return text;
}

std::string decoded(std::string text) {
  for (std::size_t at = text.find('%'); at != std::string::npos; at = text.find('%', at + 1)) {
    const std::string code = text.substr(at, 3);
    text.replace(at, code.size(), code == "%2F" ? "/" : code == "%2E" ? "." : "%");
  }
  return text;
}

void check_shape(const std::string& name, const Checkpoint::Array& array) {
  std::int64_t count = 1;
  for (std::int64_t length : array.shape) count *= length;
  if (count != static_cast<std::int64_t>(array.values.size()))
    fail<InvalidInput>("checkpoint array '{}' must have {} values according to its shape, got {}.",
                       name, count, array.values.size());
}

std::vector<unsigned char> to_bytes(const std::string& path, const Checkpoint& checkpoint) {
  Hdf5File file = Hdf5File::create_in_memory(path);
  file.write_attribute("/", "format", std::array<std::int64_t, 1>{format.newest});
  file.write_text_attribute("/", "kind", "checkpoint");
  for (const char* group : {"/arrays", "/integers", "/bytes", "/texts"}) file.create_group(group);
  const auto length = [](const auto& values) {
    return std::vector<std::int64_t>{static_cast<std::int64_t>(values.size())};
  };
  for (const auto& [name, array] : checkpoint.arrays) {
    check_shape(name, array);
    file.write_array("/arrays/" + encoded(name), Number::Float64, array.shape, array.values.data());
  }
  for (const auto& [name, values] : checkpoint.integers)
    file.write_array("/integers/" + encoded(name), Number::Int64, length(values), values.data());
  for (const auto& [name, values] : checkpoint.bytes)
    file.write_array("/bytes/" + encoded(name), Number::UInt8, length(values), values.data());
  for (const auto& [name, text] : checkpoint.texts)
    file.write_text("/texts/" + encoded(name), text);
  return file.image();
}

Checkpoint from_bytes(const std::string& path, std::span<const unsigned char> bytes) {
  const Hdf5File file = Hdf5File::open_image(bytes, path);
  if (!file.has_attribute("/", "format") || !file.has_attribute("/", "kind") ||
      file.text_attribute("/", "kind") != "checkpoint")
    fail<CacheError>("{}: is not a loomstone checkpoint; give a file that loomstone wrote.", path);
  check_file_format(path, format, file.attribute("/", "format"));
  Checkpoint checkpoint;
  for (const std::string& name : file.children("/arrays")) {
    Checkpoint::Array& array = checkpoint.arrays[decoded(name)];
    array.values = file.read_array<double>("/arrays/" + name, &array.shape);
  }
  for (const std::string& name : file.children("/integers"))
    checkpoint.integers[decoded(name)] = file.read_array<std::int64_t>("/integers/" + name);
  for (const std::string& name : file.children("/bytes"))
    checkpoint.bytes[decoded(name)] = file.read_array<std::uint8_t>("/bytes/" + name);
  for (const std::string& name : file.children("/texts"))
    checkpoint.texts[decoded(name)] = file.read_text("/texts/" + name);
  return checkpoint;
}

}  // namespace

// Writes and syncs the complete file under a temporary name before renaming it to `path`. Even
// after a power failure, a file at `path` is complete: the previous checkpoint or this one.
void write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  const std::vector<unsigned char> bytes = to_bytes(path, checkpoint);
  Trailer trailer{{}, bytes.size(), checksum_of(bytes)};
  std::memcpy(trailer.mark, mark, sizeof mark);
  const std::string part = path + ".part";
  Descriptor file(part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
  file.write(bytes.data(), bytes.size());
  file.write(&trailer, sizeof trailer);
  file.sync();
  file.close();
  if (std::rename(part.c_str(), path.c_str()) != 0)
    fail<CacheError>("{}: could not rename {} to it: {}.", path, part, std::strerror(errno));
  const std::size_t slash = path.rfind('/');
  Descriptor(slash == std::string::npos ? "." : path.substr(0, slash + 1),
             O_RDONLY | O_DIRECTORY | O_CLOEXEC)
      .sync();
}

Checkpoint read_checkpoint(const std::string& path) {
  const std::vector<unsigned char> bytes = Descriptor(path, O_RDONLY | O_CLOEXEC).read_all();
  Trailer trailer = {};
  if (bytes.size() >= sizeof trailer)
    std::memcpy(&trailer, bytes.data() + bytes.size() - sizeof trailer, sizeof trailer);
  if (std::memcmp(trailer.mark, mark, sizeof mark) != 0)
    fail<CacheError>(
        "{}: is not a loomstone checkpoint or is truncated; resume from another checkpoint.", path);
  const std::size_t length = bytes.size() - sizeof trailer;
  if (trailer.length != length || checksum_of({bytes.data(), length}) != trailer.checksum)
    fail<CacheError>(
        "{}: the checkpoint is damaged (its checksum does not match its content); resume from "
        "another checkpoint.",
        path);
  return from_bytes(path, {bytes.data(), length});
}

}  // namespace loomstone
