#include "core/cache/look_file.h"

#include <cmath>
#include <limits>

#include "core/base/message.h"

namespace loomstone {

namespace {

constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

std::string texture_path(const std::string& group, std::size_t surface) {
  return formatted("{}/texture{}", group, surface);
}

[[noreturn]] void throw_damaged(const Hdf5File& file) {
  fail<CacheError>("{}: the file is damaged: the looks of its surfaces cannot be read.",
                   file.name());
}

std::vector<double> read_numbers(const Hdf5File& file, const std::string& path, std::size_t count) {
  std::vector<double> values = file.read_array<double>(path);
  if (values.size() != count) throw_damaged(file);
  return values;
}

std::shared_ptr<const TextureImage> read_texture(const Hdf5File& file, const std::string& path) {
  TextureImage image;
  std::vector<std::int64_t> shape;
  image.rgba = file.read_array<std::uint8_t>(path, &shape);
  if (shape.size() != 3 || shape[2] != 4 || shape[0] > 16384 || shape[1] > 16384)
    throw_damaged(file);
  image.height = static_cast<int>(shape[0]);
  image.width = static_cast<int>(shape[1]);
  return std::make_shared<const TextureImage>(std::move(image));
}

}  // namespace

void write_looks(Hdf5File& file, const std::string& group, const std::vector<Look>& looks) {
  if (looks.empty()) return;
  std::vector<double> colors, roughness, widths;
  for (const Look& look : looks) {
    for (int i = 0; i < 3; ++i) colors.push_back(look.color ? (*look.color)[i] : not_given);
    roughness.push_back(look.roughness.value_or(not_given));
    widths.push_back(look.texture_width);
  }
  const auto n = static_cast<std::int64_t>(looks.size());
  file.create_group(group);
  const auto write = [&](const char* name, const std::vector<std::int64_t>& shape,
                         const std::vector<double>& values, const char* unit, const char* meaning) {
    const std::string path = group + "/" + name;
    file.write_array(path, Number::Float64, shape, values.data());
    file.describe(path, unit, meaning);
  };
  write("color", {n, 3}, colors, "1", "sRGB, 0 to 1; NaN: chosen by the renderer");
  write("roughness", {n}, roughness, "1", "0: polished, 1: matt; NaN: chosen by the renderer");
  write("texture_width", {n}, widths, "m", "width of the texture in uv; 0: the box of all uv");
  for (std::size_t surface = 0; surface < looks.size(); ++surface) {
    if (!looks[surface].texture) continue;
    const TextureImage& image = *looks[surface].texture;
    const std::string path = texture_path(group, surface);
    file.write_array(path, Number::UInt8, {image.height, image.width, 4}, image.rgba.data());
    file.describe(path, "1", "image, sRGB and alpha, rows from the top");
  }
}

std::vector<Look> read_looks(const Hdf5File& file, const std::string& group, std::size_t n) {
  if (!file.has(group)) return {};
  const std::vector<double> colors = read_numbers(file, group + "/color", 3 * n),
                            roughness = read_numbers(file, group + "/roughness", n),
                            widths = read_numbers(file, group + "/texture_width", n);
  std::vector<Look> looks(n);
  for (std::size_t surface = 0; surface < n; ++surface) {
    Look& look = looks[surface];
    if (!std::isnan(colors[3 * surface])) look.color = Vec3(&colors[3 * surface]);
    if (!std::isnan(roughness[surface])) look.roughness = roughness[surface];
    look.texture_width = widths[surface];
    const std::string path = texture_path(group, surface);
    if (file.has(path)) look.texture = read_texture(file, path);
    try {
      check_look(look, "look");
    } catch (const InvalidInput&) {
      throw_damaged(file);
    }
  }
  return looks;
}

}  // namespace loomstone
