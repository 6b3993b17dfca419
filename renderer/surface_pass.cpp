// Draws the final picture and reads its pixels.
#include "renderer/surface_pass.h"

#include <algorithm>

#include "renderer/surface_shaders.h"

namespace loomstone {
namespace {

constexpr int image_unit = 2;  // texture unit of images

// Returns for each drawing the vector from its sample to the centre of the pixel [pixels], or zero
// if one drawing has all samples. The four samples have the positions that Mesa's llvmpipe uses for
// multisampling.
std::vector<Eigen::Vector2f> centres_from(SurfacePass::Samples samples) {
  if (!samples.separate) return {Eigen::Vector2f::Zero()};
  return {{0.125f, 0.375f}, {-0.375f, 0.125f}, {0.375f, -0.125f}, {-0.125f, -0.375f}};
}

}  // namespace

SurfacePass::SurfacePass(const GL& gl, int width, int height, Samples samples,
                         const ColorTable& table)
    : gl_(&gl),
      width_(width),
      height_(height),
      to_centres_(centres_from(samples)),
      background_program_(gl, "background", whole_picture_vertex_shader(),
                          background_fragment_shader()),
      floor_program_(gl, "floor", surface_vertex_shader(), floor_fragment_shader()),
      cloth_program_(gl, "cloth", surface_vertex_shader(), cloth_fragment_shader(samples.separate)),
      body_program_(gl, "body", surface_vertex_shader(), body_fragment_shader(samples.separate)),
      edge_program_(gl, "edge", surface_vertex_shader(), edge_fragment_shader()),
      overlay_program_(gl, "overlay", whole_picture_vertex_shader(), overlay_fragment_shader()),
      picture_color_(make_renderbuffer(gl, GL_RGBA8, width, height, 1)),
      picture_depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height, 1)),
      picture_(make_framebuffer(gl)),
      things_color_(
          make_renderbuffer(gl, GL_RGBA8, width, height, samples.separate ? 1 : samples.per_pixel)),
      things_depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height,
                                      samples.separate ? 1 : samples.per_pixel)),
      things_(make_framebuffer(gl)),
      resolved_color_(make_texture(gl, {GL_RGBA8, width, height})),
      resolved_(make_framebuffer(gl)),
      sum_color_(make_texture(
          gl, {GL_RGBA16F, samples.separate ? width : 1, samples.separate ? height : 1})),
      sum_(make_framebuffer(gl)),
      color_table_(make_texture(gl, {.format = GL_RGB8,
                                     .width = 256,
                                     .height = 1,
                                     .filter = GL_LINEAR,
                                     .pixels = table.data(),
                                     .pixel_format = GL_RGB,
                                     .pixel_type = GL_UNSIGNED_BYTE})),
      empty_(make_vertex_array(gl)) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                             picture_color_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                             picture_depth_.name());
  check_framebuffer(gl, "picture");
  gl.BindFramebuffer(GL_FRAMEBUFFER, things_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                             things_color_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                             things_depth_.name());
  check_framebuffer(gl, "surface pass");
  gl.BindFramebuffer(GL_FRAMEBUFFER, resolved_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                          resolved_color_.name(), 0);
  check_framebuffer(gl, "resolved picture");
  gl.BindFramebuffer(GL_FRAMEBUFFER, sum_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, sum_color_.name(),
                          0);
  check_framebuffer(gl, "mean of samples");
}

void SurfacePass::set_common(const Program& program, const SurfaceShading& shading,
                             const Eigen::Vector2f& to_centre) const {
  const Float4x4 to_eye = shading.view.view();
  const Eigen::Vector2f size(static_cast<float>(width_), static_cast<float>(height_));
  Float4x4 projection = shading.view.projection();
  projection.block<2, 1>(0, 2) -= 2.0f * to_centre.cwiseQuotient(size);
  program.use();
  program.set("view", to_eye);
  program.set("projection", projection);
  program.set("size", size);
  program.set("to_centre", to_centre);
  program.set("towards_light",
              Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * shading.light.towards));
  program.set("up", Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * Eigen::Vector3f::UnitZ()));
  program.set("towards_eye", 0.0f);
  program.set("colored", shading.options.colored ? 1 : 0);
  program.set_texture("light_seen", 0, shading.seen.result());
}

void SurfacePass::draw_floors(const std::vector<PlacedFloor>& floors) const {
  gl_->Enable(GL_CULL_FACE);  // floors are invisible from below
  for (const PlacedFloor& floor : floors) floor.square->draw();
  gl_->Disable(GL_CULL_FACE);
}

void SurfacePass::draw_surroundings(const SurfaceShading& shading,
                                    const SurfaceThings& things) const {
  set_common(floor_program_, shading);
  floor_program_.set("transparent", shading.options.transparent ? 1 : 0);
  gl_->Enable(GL_CULL_FACE);  // floors are invisible from below
  for (const PlacedFloor& floor : things.floors) {
    const Material& material = things.materials.body(floor.body);
    material.set(floor_program_, image_unit);
    floor_program_.set("colored", material.own_color ? 1 : 0);
    floor_program_.set("centre_uv", floor.uv.centre);
    floor_program_.set("side_a_uv", floor.uv.side_a);
    floor_program_.set("side_b_uv", floor.uv.side_b);
    floor.square->draw();
  }
  gl_->Disable(GL_CULL_FACE);
  if (shading.options.transparent) return;
  // The backdrop lies on the far plane and is drawn after the floors, so it is shaded only where
  // there is no floor.
  set_common(background_program_, shading);
  gl_->BindVertexArray(empty_.name());
  gl_->DepthFunc(GL_LEQUAL);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->DepthFunc(GL_LESS);
}

void SurfacePass::draw_things(const SurfaceShading& shading, const SurfaceThings& things,
                              const Eigen::Vector2f& to_centre) const {
  const SurfaceOptions& options = shading.options;
  set_common(floor_program_, shading, to_centre);
  gl_->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);  // floors only write depth here
  draw_floors(things.floors);
  gl_->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

  set_common(cloth_program_, shading, to_centre);
  cloth_program_.set_texture("color_table", 1, color_table_.name());
  cloth_program_.set("pattern", static_cast<int>(options.pattern));
  cloth_program_.set("value_range", Eigen::Vector2f(static_cast<float>(options.range.low),
                                                    static_cast<float>(options.range.high)));
  for (Index part = 0; part < things.cloth.n_parts(); ++part) {
    things.materials.cloth(part).set(cloth_program_, image_unit);
    cloth_program_.set("checker_color", Eigen::Vector3f(0.66f, 0.63f, 0.57f));
    cloth_program_.set("split",
                       options.split.empty()
                           ? 1e9f
                           : static_cast<float>(options.split[static_cast<std::size_t>(part)]));
    things.cloth.draw_part(part);
  }
  if (options.wireframe) {
    set_common(edge_program_, shading, to_centre);
    edge_program_.set("towards_eye", 8e-4f);
    gl_->Enable(GL_BLEND);
    gl_->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    gl_->DepthMask(GL_FALSE);
    things.cloth.draw_edges();
    gl_->DepthMask(GL_TRUE);
    gl_->Disable(GL_BLEND);
  }

  set_common(body_program_, shading, to_centre);
  for (Index part = 0; part < things.bodies.n_parts(); ++part) {
    things.materials.body(part).set(body_program_, image_unit);
    body_program_.set("curves", part == things.n_bodies ? 1 : 0);
    things.bodies.draw_part(part);
  }
}

void SurfacePass::draw(const SurfaceShading& shading, const SurfaceThings& things,
                       const Rectangle& reached) const {
  gl_->Viewport(0, 0, width_, height_);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  gl_->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  draw_surroundings(shading, things);
  if (reached.width <= 0 || reached.height <= 0) return;

  gl_->Enable(GL_SCISSOR_TEST);
  gl_->Scissor(reached.left, reached.bottom, reached.width, reached.height);
  draw_samples(shading, things, reached);
  // The colours of cloth, bodies, curves and wireframe are premultiplied by their coverage.
  gl_->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  lay_over(picture_, to_centres_.size() > 1 ? sum_color_ : resolved_color_);
  gl_->Disable(GL_SCISSOR_TEST);
}

void SurfacePass::draw_samples(const SurfaceShading& shading, const SurfaceThings& things,
                               const Rectangle& reached) const {
  const int right = reached.left + reached.width, top = reached.bottom + reached.height;
  const bool separate = to_centres_.size() > 1;
  gl_->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  if (separate) {
    gl_->BindFramebuffer(GL_FRAMEBUFFER, sum_.name());
    gl_->Clear(GL_COLOR_BUFFER_BIT);
  }
  for (const Eigen::Vector2f& to_centre : to_centres_) {
    gl_->Enable(GL_DEPTH_TEST);
    gl_->BindFramebuffer(GL_FRAMEBUFFER, things_.name());
    gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    draw_things(shading, things, to_centre);
    gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, things_.name());
    gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.name());
    gl_->BlitFramebuffer(reached.left, reached.bottom, right, top, reached.left, reached.bottom,
                         right, top, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    if (!separate) continue;
    gl_->BlendColor(0.0f, 0.0f, 0.0f, 1.0f / static_cast<float>(to_centres_.size()));
    gl_->BlendFunc(GL_CONSTANT_ALPHA, GL_ONE);
    lay_over(sum_, resolved_color_);
  }
}

// Draws a texture over the pixels of a framebuffer, with the current blend function.
void SurfacePass::lay_over(const GlObject& framebuffer, const GlObject& texture) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  overlay_program_.use();
  overlay_program_.set_texture("things", 0, texture.name());
  gl_->Disable(GL_DEPTH_TEST);
  gl_->Enable(GL_BLEND);
  gl_->BindVertexArray(empty_.name());
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->Disable(GL_BLEND);
}

Image SurfacePass::read(bool with_alpha) const {
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, picture_.name());
  const std::size_t width = static_cast<std::size_t>(width_),
                    height = static_cast<std::size_t>(height_);
  std::vector<std::uint8_t> rgba(4 * width * height);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  const std::size_t channels = with_alpha ? 4 : 3;
  Image image{width_, height_, static_cast<int>(channels), {}};
  image.pixels.resize(channels * width * height);
  for (std::size_t row = 0; row < height; ++row) {  // OpenGL stores rows from bottom to top
    const std::uint8_t* from = rgba.data() + 4 * (height - 1 - row) * width;
    std::uint8_t* to = image.pixels.data() + channels * row * width;
    for (std::size_t column = 0; column < width; ++column, from += 4, to += channels) {
      std::copy_n(from, channels, to);
      const int alpha = from[3];
      if (with_alpha && alpha > 0 && alpha < 255)  // the picture is premultiplied by alpha
        for (int i = 0; i < 3; ++i)
          to[i] = static_cast<std::uint8_t>(std::min(255, (255 * from[i] + alpha / 2) / alpha));
    }
  }
  return image;
}

}  // namespace loomstone
