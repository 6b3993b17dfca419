// Appearance of a surface in pictures and exports. It does not affect the simulation.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/field.h"
#include "core/base/types.h"

namespace loomstone {

// An image in sRGB with straight alpha.
struct TextureImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  // rows from the top, 4 bytes per pixel

  friend bool operator==(const TextureImage&, const TextureImage&) = default;
};

struct Look {
  std::optional<Vec3> color;        // sRGB
  std::optional<double> roughness;  // [1]
  std::shared_ptr<const TextureImage> texture;
  double texture_width = 0.0;  // [m]

  static auto fields() {
    return std::make_tuple(
        field("color", &Look::color,
              "(3) red, green and blue in sRGB, from 0 to 1, as image programs show them; None: "
              "chosen by the renderer"),
        field(
            "roughness", &Look::roughness, "1", between(0.0, 1.0),
            "roughness of the surface, 0: polished, 1: matt; None: 0.9 for cloth, 0.6 for others"),
        field(
            "texture", &Look::texture,
            "image on the surface: name of a file, or (height x width x 3 or 4) bytes, sRGB, rows "
            "from the top; its transparent pixels show the color"),
        field("texture_width", &Look::texture_width, "m", non_negative(),
              "width of the image in uv, repeated in both directions from uv (0, 0); 0: the image "
              "covers the box of the surface's uv once, and repeats only on floors"));
  }
};

// Roughness of cloth, and of bodies and obstacles, if Look::roughness is not set [1].
constexpr double cloth_roughness = 0.9, body_roughness = 0.6;

// Throws InvalidInput unless all values are admissible. `where` is the name of the look in
// messages.
void check_look(const Look& look, const std::string& where);

}  // namespace loomstone
