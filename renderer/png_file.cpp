// Writes PNG files with libpng's simplified interface and fast compression, which takes less time
// than the default compression but makes larger files.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <system_error>

#include <png.h>

#include "core/base/message.h"
#include "renderer/image.h"

namespace loomstone {

ColorTable grey_table() {
  ColorTable table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i].fill(static_cast<std::uint8_t>(i));
  return table;
}

void write_png(const std::string& path, const Image& image) {
  if (image.width < 1 || image.height < 1 || (image.channels != 3 && image.channels != 4) ||
      image.pixels.size() != static_cast<std::size_t>(image.channels) *
                                 static_cast<std::size_t>(image.width) *
                                 static_cast<std::size_t>(image.height))
    fail<InvalidInput>("an image must have 3 or 4 bytes for each of its {} x {} pixels, got {}",
                       image.width, image.height, image.pixels.size());
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = image.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  header.flags = PNG_IMAGE_FLAG_FAST;
  // The file is renamed at the end, so that a file with the final name is always complete.
  const std::string unfinished = formatted("{}.part{}", path, getpid());
  const bool written =
      png_image_write_to_file(&header, unfinished.c_str(), 0, image.pixels.data(), 0, nullptr) != 0;
  std::error_code error;
  if (written) std::filesystem::rename(unfinished, path, error);
  if (!written || error) {
    const std::string reason = written ? error.message() : header.message;
    std::remove(unfinished.c_str());
    fail<CacheError>(
        "the picture could not be written to {}: {}; check that its folder exists and has room",
        path, reason);
  }
}

}  // namespace loomstone
