#include "core/base/look.h"

#include "core/base/message.h"

namespace loomstone {

void check_look(const Look& look, const std::string& where) {
  check_fields(look, where);
  if (look.color)
    require((look.color->array() >= 0.0).all() && (look.color->array() <= 1.0).all(),
            "{}.color must be in [0, 1], got ({}, {}, {}); divide bytes by 255", where,
            (*look.color)[0], (*look.color)[1], (*look.color)[2]);
  if (!look.texture) return;
  const TextureImage& image = *look.texture;
  constexpr int most = 16384;  // largest side that most OpenGL drivers accept [pixels]
  require(image.width > 0 && image.height > 0 && image.width <= most && image.height <= most,
          "{}.texture must have 1 to {} pixels along each side, got {} x {}; scale it", where, most,
          image.width, image.height);
  require(image.rgba.size() ==
              4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
          "{}.texture must have 4 bytes for each of its {} x {} pixels, got {}", where, image.width,
          image.height, image.rgba.size());
}

}  // namespace loomstone
