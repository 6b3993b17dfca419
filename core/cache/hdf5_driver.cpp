#include "core/cache/hdf5_driver.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#if H5_VERSION_GE(1, 14, 0)
#include <H5FDdevelop.h>
#endif

#include "core/cache/hdf5_handles.h"
#include "core/cache/hdf5_journal.h"

namespace loomstone::hdf5 {

namespace {

// HDF5 writes metadata (the superblock, headers and indices of datasets) many times between two
// flushes and in no particular order. Therefore, metadata stays in `pending` until the next flush.
// Raw data fills rows that readers do not read before the next flush. It is therefore written to
// the file directly, unless it overlaps pending bytes or `discards` is true.
struct JournaledFile : H5FD_t {
  int descriptor = -1;
  bool writes = false;        // true: open for writing
  bool discards = false;      // true: changes stay in `pending` and are never written
  haddr_t end_allocated = 0;  // HDF5's end of allocated space (EOA) [bytes]
  haddr_t length = 0;         // length of the file without a journal [bytes]
  // Value of `length` after the last flush that wrote pending bytes or, before such a flush, when
  // the file was opened [bytes].
  haddr_t flushed = 0;
  // Bytes that belong in the file but have not been written to their places yet, including those of
  // a journal. If the file is open for reading only, also metadata that has been read.
  PendingBytes pending;
  // True: the last flush, in this process or an earlier one, is incomplete, and the file needs the
  // journal at its end. The journal contains those bytes in `pending` that lie before `flushed`.
  bool half_flushed = false;

  JournaledFile() : H5FD_t{} {}
  ~JournaledFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
};

constexpr haddr_t largest_address = (static_cast<haddr_t>(1) << 62) - 1;

JournaledFile& ours(H5FD_t* file) { return *static_cast<JournaledFile*>(file); }
const JournaledFile& ours(const H5FD_t* file) { return *static_cast<const JournaledFile*>(file); }

// Adds an entry to the error stack of HDF5, with the wording of HDF5's default driver. Returns -1.
herr_t refused(const char* tried, hid_t minor) {
  const int code = errno;
  H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_VFL, minor,
           "could not %s, errno = %d, error message = '%s'", tried, code, std::strerror(code));
  return -1;
}

// Calls a function that may throw. HDF5 is written in C, so exceptions must not pass through it.
template <class Work>
herr_t guarded(const Work& work) {
  try {
    return work();
  } catch (const std::exception&) {
    errno = ENOMEM;
    return refused("hold the changes of the file in memory", H5E_CANTALLOC);
  }
}

herr_t open_into(JournaledFile& file, const char* name, unsigned flags) {
  file.writes = flags & H5F_ACC_RDWR;
  int mode = file.writes ? O_RDWR : O_RDONLY;
  if (flags & H5F_ACC_TRUNC) mode |= O_TRUNC;
  if (flags & H5F_ACC_CREAT) mode |= O_CREAT;
  if (flags & H5F_ACC_EXCL) mode |= O_EXCL;
  file.descriptor = ::open(name, mode | O_CLOEXEC, 0666);
  struct stat status = {};
  if (file.descriptor < 0 || fstat(file.descriptor, &status) != 0)
    return refused("open the file", H5E_CANTOPENFILE);
  file.length = static_cast<haddr_t>(status.st_size);
  if (std::optional<Journal> journal = read_journal(file.descriptor)) {
    file.length = journal->start;
    file.pending = std::move(journal->bytes);
    file.half_flushed = true;
  }
  file.flushed = file.length;
  return 0;
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t, haddr_t) {
  JournaledFile* file = new (std::nothrow) JournaledFile;
  if (file && guarded([&] { return open_into(*file, name, flags); }) >= 0) return file;
  delete file;
  return nullptr;
}

herr_t set_length(JournaledFile& file, haddr_t length) {
  if (::ftruncate(file.descriptor, static_cast<off_t>(length)) != 0)
    return refused("set the length of the file", H5E_SEEKERROR);
  file.length = length;
  return 0;
}

herr_t write_ranges(const JournaledFile& file, const PendingBytes& bytes) {
  for (const auto& [address, range] : bytes.ranges())
    if (!write_fully(file.descriptor, address, range))
      return refused("write the file", H5E_WRITEERROR);
  return 0;
}

// Writes the pending bytes. Bytes beyond file.flushed are written first and need no journal:
// nothing in the file refers to them until bytes before file.flushed change. The journal contains
// those changes.
herr_t flush_pending(JournaledFile& file) {
  if (file.pending.empty()) return 0;
  const auto [changed, added] = file.pending.split_at(file.flushed);
  const haddr_t start = std::max<haddr_t>(file.length, file.pending.end());
  if (write_ranges(file, added) < 0) return -1;
  if (!changed.empty()) {
    const std::vector<unsigned char> records = journal_records(changed);
    const JournalTrailer trailer = journal_trailer(start, records);
    if (!write_fully(file.descriptor, start, records) ||
        !write_fully(file.descriptor, start + records.size(),
                     {reinterpret_cast<const unsigned char*>(&trailer), sizeof trailer}))
      return refused("write the journal", H5E_WRITEERROR);
    file.half_flushed = true;
    if (write_ranges(file, changed) < 0) return -1;
  }
  if (set_length(file, start) < 0) return -1;
  file.pending.clear();
  file.flushed = start;
  file.half_flushed = false;
  return 0;
}

herr_t flush_file(H5FD_t* base, hid_t, hbool_t) {
  JournaledFile& file = ours(base);
  if (!file.writes || file.discards) return 0;
  return guarded([&] { return flush_pending(file); });
}

herr_t close_file(H5FD_t* base) {
  const std::unique_ptr<JournaledFile> file(&ours(base));
  const herr_t flushed = flush_file(base, H5P_DEFAULT, true);
  // Network file systems may report a full disk only now.
  if (::close(std::exchange(file->descriptor, -1)) != 0)
    return refused("close the file", H5E_CANTCLOSEFILE);
  return flushed;
}

// To HDF5, two open files are never the same, even if they have the same path. Otherwise they would
// share one state in HDF5, and a new reader would find only the frames that the older reader has
// found.
int compare_files(const H5FD_t* a, const H5FD_t* b) {
  if (a == b) return 0;
  return std::less<>()(a, b) ? -1 : 1;
}

herr_t query_features(const H5FD_t*, unsigned long* flags) {
  if (flags)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t end_of_allocated(const H5FD_t* file, H5FD_mem_t) { return ours(file).end_allocated; }

herr_t set_end_of_allocated(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  ours(file).end_allocated = address;
  return 0;
}

// The file may have grown if another process writes it.
haddr_t end_of_file(const H5FD_t* base, H5FD_mem_t) {
  const JournaledFile& file = ours(base);
  struct stat status = {};
  if (file.writes || fstat(file.descriptor, &status) != 0) return file.length;
  return std::max(file.length, static_cast<haddr_t>(status.st_size));
}

herr_t handle_of(H5FD_t* file, hid_t, void** handle) {
  *handle = &ours(file);
  return 0;
}

herr_t read_bytes(H5FD_t* base, H5FD_mem_t type, hid_t, haddr_t address, size_t count,
                  void* buffer) {
  JournaledFile& file = ours(base);
  const std::span bytes(static_cast<unsigned char*>(buffer), count);
  return guarded([&] {
    if (!read_fully(file.descriptor, address, bytes)) return refused("read", H5E_READERROR);
    file.pending.apply_to(address, bytes);
    if (!file.writes && type != H5FD_MEM_DRAW) file.pending.put(address, bytes);
    return 0;
  });
}

herr_t write_bytes(H5FD_t* base, H5FD_mem_t type, hid_t, haddr_t address, size_t count,
                   const void* buffer) {
  JournaledFile& file = ours(base);
  const std::span bytes(static_cast<const unsigned char*>(buffer), count);
  return guarded([&] {
    if (file.half_flushed && !file.discards && flush_pending(file) < 0) return -1;
    if (type != H5FD_MEM_DRAW || file.discards || file.pending.overlap(address, count)) {
      file.pending.put(address, bytes);
      return 0;
    }
    if (!write_fully(file.descriptor, address, bytes)) return refused("write", H5E_WRITEERROR);
    file.length = std::max<haddr_t>(file.length, address + count);
    return 0;
  });
}

// Lengthens the file to the end of allocated space. The file must not become shorter before the
// next flush, because its superblock contains the old end until then.
herr_t truncate_file(H5FD_t* base, hid_t, hbool_t) {
  JournaledFile& file = ours(base);
  if (!file.writes || file.discards) return 0;
  if (file.half_flushed && flush_file(base, H5P_DEFAULT, false) < 0) return -1;
  return file.length >= file.end_allocated ? 0 : set_length(file, file.end_allocated);
}

H5FD_class_t driver_class() {
  H5FD_class_t result = {};
#if H5_VERSION_GE(1, 14, 0)
  result.version = H5FD_CLASS_VERSION;
  result.value = 511;  // 256 to 511 are free for drivers that are not registered
#endif
  result.name = "loomstone_journal";
  result.maxaddr = largest_address;
  result.fc_degree = H5F_CLOSE_WEAK;
  result.open = open_file;
  result.close = close_file;
  result.cmp = compare_files;
  result.query = query_features;
  result.get_eoa = end_of_allocated;
  result.set_eoa = set_end_of_allocated;
  result.get_eof = end_of_file;
  result.get_handle = handle_of;
  result.read = read_bytes;
  result.write = write_bytes;
  result.flush = flush_file;
  result.truncate = truncate_file;
  const H5FD_mem_t lists[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(lists), std::end(lists), std::begin(result.fl_map));
  return result;
}

// Returns this driver's record of an open file, or null if the file belongs to another driver.
JournaledFile* journaled_file(hid_t file) {
  const Id access(H5Fget_access_plist(file));
  void* handle = nullptr;
  if (H5Pget_driver(access) != journal_driver() ||
      H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0)
    return nullptr;
  return static_cast<JournaledFile*>(handle);
}

}  // namespace

hid_t journal_driver() {
  static const H5FD_class_t type = driver_class();
  static const hid_t id = H5FDregister(&type);
  return id;
}

bool still_as_read(hid_t file) {
  const JournaledFile* const found = journaled_file(file);
  if (!found) return true;
  const std::optional<Journal> journal = read_journal(found->descriptor);
  std::vector<unsigned char> there;
  for (const auto& [address, bytes] : found->pending.ranges()) {
    there.resize(bytes.size());
    if (!read_fully(found->descriptor, address, there)) return false;
    if (journal) journal->bytes.apply_to(address, there);
    if (there != bytes) return false;
  }
  return true;
}

void discard_changes(hid_t file) {
  if (JournaledFile* const found = journaled_file(file)) found->discards = true;
}

}  // namespace loomstone::hdf5
