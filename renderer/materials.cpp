// Determines the colours of surfaces, and uploads their texture images with mipmaps.
#include "renderer/materials.h"

#include <cmath>
#include <limits>

#include "renderer/surface_colors.h"

namespace loomstone {
namespace {

using Rgb = Eigen::Vector3f;

// Returns the colour of the back of a cloth: the front colour mixed with a light grey.
Rgb back_of(const Rgb& front) { return 0.72f * front + 0.28f * Rgb(0.55f, 0.53f, 0.48f); }

struct UvBox {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  Vec2 size() const { return high - low; }
};

// Returns the bounding box in uv of each of n surfaces; `low` exceeds `high` for a surface without
// rows in `corner_uv`.
std::vector<UvBox> uv_boxes(const Points2& corner_uv, const std::vector<Index>& owner,
                            std::size_t n) {
  std::vector<UvBox> boxes(n);
  for (Index row = 0; row < corner_uv.rows(); ++row) {
    UvBox& box = boxes[static_cast<std::size_t>(owner[static_cast<std::size_t>(row / 3)])];
    box.low = box.low.cwiseMin(corner_uv.row(row).transpose());
    box.high = box.high.cwiseMax(corner_uv.row(row).transpose());
  }
  return boxes;
}

// Makes a texture that repeats an image or, if `wrap` is GL_CLAMP_TO_EDGE, continues the colours of
// its edges.
GlObject make_image_texture(const GL& gl, const TextureImage& image, GLint wrap) {
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  GlObject texture = make_texture(gl, {.format = GL_SRGB8_ALPHA8,
                                       .width = image.width,
                                       .height = image.height,
                                       .filter = GL_LINEAR,
                                       .pixels = image.rgba.data(),
                                       .pixel_format = GL_RGBA,
                                       .pixel_type = GL_UNSIGNED_BYTE});
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 1000);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
  gl.GenerateMipmap(GL_TEXTURE_2D);
  return texture;
}

// Places the image of a look in uv coordinates. If the width of the image is given, its lower left
// corner is at the origin. Otherwise, the image covers the uv box or, if the sides of the box are
// not all positive and finite, the unit square.
void place_texture(const Look& look, const UvBox& box, Material& material) {
  if (look.texture_width > 0.0) {
    const double height = look.texture_width * look.texture->height / look.texture->width;
    material.texture_size = Vec2(look.texture_width, height).cast<float>();
  } else if ((box.size().array() > 0.0).all() && box.size().allFinite()) {
    material.texture_low = box.low.cast<float>();
    material.texture_size = box.size().cast<float>();
  }
}

}  // namespace

void Material::set(const Program& program, int texture_unit) const {
  program.set("front_color", front);
  program.set("back_color", back);
  program.set("roughness", roughness);
  program.set("pattern_size", pattern_size);
  program.set("textured", texture != 0 ? 1 : 0);
  program.set_texture("image", texture_unit, texture);
  program.set("texture_low", texture_low);
  program.set("texture_size", texture_size);
}

Materials::Materials(const GL& gl, const FrameTopology& topology) {
  const std::size_t n_cloths = topology.cloth_names.size(), n_bodies = topology.body_names.size();
  const auto add = [&](const Look& look, const UvBox& box, bool endless, Material& material) {
    if (!look.texture) return;
    const GLint wrap = look.texture_width > 0.0 || endless ? GL_REPEAT : GL_CLAMP_TO_EDGE;
    textures_.push_back(make_image_texture(gl, *look.texture, wrap));
    material.texture = textures_.back().name();
    place_texture(look, box, material);
  };
  const std::vector<UvBox> cloth_boxes =
      uv_boxes(topology.corner_uv, topology.cloth_of_triangle, n_cloths);
  for (std::size_t i = 0; i < n_cloths; ++i) {
    const Look look = topology.cloth_looks.empty() ? Look{} : topology.cloth_looks[i];
    Material& material = cloths_.emplace_back();
    material.front = shown_color(look, cloth_color(i));
    material.back = back_of(material.front);
    material.roughness = static_cast<float>(look.roughness.value_or(cloth_roughness));
    const double area = cloth_boxes[i].size().prod();
    if (std::isfinite(area) && area > 0.0)
      material.pattern_size = static_cast<float>(std::sqrt(area));
    add(look, cloth_boxes[i], false, material);
  }
  const std::vector<UvBox> body_boxes =
      uv_boxes(topology.body_corner_uv, topology.body_of_triangle, n_bodies);
  for (std::size_t i = 0; i <= n_bodies; ++i) {
    const bool has_look = i < n_bodies && !topology.body_looks.empty();
    const Look look = has_look ? topology.body_looks[i] : Look{};
    Material& material = bodies_.emplace_back();
    material.front = material.back = shown_color(look, body_color(i));
    material.own_color = look.color || look.texture;
    material.roughness = static_cast<float>(look.roughness.value_or(body_roughness));
    if (has_look) add(look, body_boxes[i], topology.body_is_floor[i], material);
  }
}

}  // namespace loomstone
