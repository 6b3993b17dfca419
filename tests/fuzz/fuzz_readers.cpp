// libFuzzer target for one reader of files. LOOMSTONE_READER chooses the reader: 1 OBJ, 2 PLY, 3
// checkpoints, 4 run.vtkhdf. A reader must either return a value or throw an Error. Anything else
// (another exception, a crash, more than 2 GiB of memory or 10 s) is a finding.
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

#include "core/base/error.h"
#include "core/base/word_hash.h"
#include "core/cache/checkpoint_file.h"
#include "core/cache/frame_file.h"
#include "core/mesh/mesh_file.h"

using namespace loomstone;

namespace {

void write(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
}

// Appends the mark, length and checksum of a checkpoint. Without them, the reader would refuse the
// file before HDF5 reads its content.
std::string with_checksum(std::string bytes) {
  WordHash hash;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    hash.add(word);
  }
  const std::uint64_t numbers[2] = {bytes.size(), hash.sum};
  bytes += "LOOMCHK\n";
  return bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
}

void read(const std::string& path, std::string_view bytes) {
#if LOOMSTONE_READER == 3
  write(path, with_checksum(std::string(bytes)));
  read_checkpoint(path);
#elif LOOMSTONE_READER == 4
  write(path, bytes);
  const FrameReader reader(path);
  for (int index = 0; index < reader.n_frames() && index < 4; ++index) reader.frame(index);
#else
  write(path, bytes);
  read_mesh(path);
#endif
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = "/dev/shm/loomstone-fuzz-" + std::to_string(getpid()) +
                                  (LOOMSTONE_READER == 2 ? ".ply" : ".obj");
  try {
    read(path, {reinterpret_cast<const char*>(data), size});
  } catch (const Error&) {
  }
  std::remove(path.c_str());
  return 0;
}
