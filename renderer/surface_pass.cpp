// Draws the final picture and reads its pixels.
#include "renderer/surface_pass.h"

#include <cstring>

#include "renderer/cloth_colors.h"
#include "renderer/surface_shaders.h"

namespace loomstone {
namespace {

using Rgb = Eigen::Vector3f;

// The back of a cloth is paler.
Rgb back_of(const Rgb& front) { return 0.72f * front + 0.28f * Rgb(0.55f, 0.53f, 0.48f); }

}  // namespace

SurfacePass::SurfacePass(const GL& gl, int width, int height, int samples, const ColorTable& table)
    : gl_(&gl),
      width_(width),
      height_(height),
      background_program_(gl, "background", whole_picture_vertex_shader(),
                          background_fragment_shader()),
      floor_program_(gl, "floor", surface_vertex_shader(), floor_fragment_shader()),
      cloth_program_(gl, "cloth", surface_vertex_shader(), cloth_fragment_shader()),
      body_program_(gl, "body", surface_vertex_shader(), body_fragment_shader()),
      edge_program_(gl, "edge", surface_vertex_shader(), edge_fragment_shader()),
      overlay_program_(gl, "overlay", whole_picture_vertex_shader(), overlay_fragment_shader()),
      picture_color_(make_renderbuffer(gl, GL_RGBA8, width, height, 1)),
      picture_depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height, 1)),
      picture_(make_framebuffer(gl)),
      things_color_(make_renderbuffer(gl, GL_RGBA8, width, height, samples)),
      things_depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height, samples)),
      things_(make_framebuffer(gl)),
      resolved_color_(make_texture(gl, {GL_RGBA8, width, height})),
      resolved_(make_framebuffer(gl)),
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
}

void SurfacePass::set_common(const Program& program, const SurfaceShading& shading) const {
  const Float4x4 to_eye = shading.view.view();
  program.use();
  program.set("view", to_eye);
  program.set("projection", shading.view.projection());
  program.set("size", Eigen::Vector2f(static_cast<float>(width_), static_cast<float>(height_)));
  program.set("towards_light",
              Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * shading.light.towards));
  program.set("up", Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * Eigen::Vector3f::UnitZ()));
  program.set("towards_eye", 0.0f);
  program.set("colored", shading.options.colored ? 1 : 0);
  program.set_texture("light_seen", 0, shading.seen.result());
}

void SurfacePass::draw_floors(const std::vector<const SquareBuffers*>& floors) const {
  gl_->Enable(GL_CULL_FACE);  // floors are invisible from below
  for (const SquareBuffers* floor : floors) floor->draw();
  gl_->Disable(GL_CULL_FACE);
}

void SurfacePass::draw_surroundings(const SurfaceShading& shading,
                                    const std::vector<const SquareBuffers*>& floors) const {
  set_common(floor_program_, shading);
  draw_floors(floors);
  // The backdrop lies on the far plane and is drawn last, so each pixel is shaded only once.
  set_common(background_program_, shading);
  gl_->BindVertexArray(empty_.name());
  gl_->DepthFunc(GL_LEQUAL);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->DepthFunc(GL_LESS);
}

void SurfacePass::draw_things(const SurfaceShading& shading, const SurfaceThings& things) const {
  const SurfaceOptions& options = shading.options;
  set_common(floor_program_, shading);
  gl_->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);  // floors only write depth here
  draw_floors(things.floors);
  gl_->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

  set_common(cloth_program_, shading);
  cloth_program_.set_texture("color_table", 1, color_table_.name());
  cloth_program_.set("pattern", static_cast<int>(options.pattern));
  cloth_program_.set("value_range", Eigen::Vector2f(static_cast<float>(options.range.low),
                                                    static_cast<float>(options.range.high)));
  for (Index part = 0; part < things.cloth.n_parts(); ++part) {
    const Rgb front = cloth_color(static_cast<std::size_t>(part));
    cloth_program_.set("front_color", front);
    cloth_program_.set("back_color", back_of(front));
    cloth_program_.set("checker_color", Rgb(0.66f, 0.63f, 0.57f));
    cloth_program_.set("pattern_size",
                       static_cast<float>(things.pattern_size[static_cast<std::size_t>(part)]));
    cloth_program_.set("split",
                       options.split.empty()
                           ? 1e9f
                           : static_cast<float>(options.split[static_cast<std::size_t>(part)]));
    things.cloth.draw_part(part);
  }
  if (options.wireframe) {
    set_common(edge_program_, shading);
    edge_program_.set("towards_eye", 8e-4f);
    gl_->Enable(GL_BLEND);
    gl_->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    gl_->DepthMask(GL_FALSE);
    things.cloth.draw_edges();
    gl_->DepthMask(GL_TRUE);
    gl_->Disable(GL_BLEND);
  }

  set_common(body_program_, shading);
  things.bodies.draw();
}

void SurfacePass::draw(const SurfaceShading& shading, const SurfaceThings& things,
                       const Rectangle& reached) const {
  gl_->Viewport(0, 0, width_, height_);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  gl_->Clear(GL_DEPTH_BUFFER_BIT);
  draw_surroundings(shading, things.floors);
  if (reached.width <= 0 || reached.height <= 0) return;

  gl_->Enable(GL_SCISSOR_TEST);
  gl_->Scissor(reached.left, reached.bottom, reached.width, reached.height);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, things_.name());
  gl_->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  draw_things(shading, things);

  const int right = reached.left + reached.width, top = reached.bottom + reached.height;
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, things_.name());
  gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.name());
  gl_->BlitFramebuffer(reached.left, reached.bottom, right, top, reached.left, reached.bottom,
                       right, top, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, picture_.name());
  overlay_program_.use();
  overlay_program_.set_texture("things", 0, resolved_color_.name());
  gl_->Disable(GL_DEPTH_TEST);
  gl_->Enable(GL_BLEND);
  // Resolved colours are premultiplied by their coverage.
  gl_->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_->BindVertexArray(empty_.name());
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->Disable(GL_BLEND);
  gl_->Disable(GL_SCISSOR_TEST);
}

Image SurfacePass::read() const {
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, picture_.name());
  const std::size_t n = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  std::vector<std::uint8_t> rgba(4 * n);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  Image image{width_, height_, std::vector<std::uint8_t>(3 * n)};
  for (int row = 0; row < height_; ++row) {  // OpenGL stores rows from the bottom
    const std::uint8_t* from =
        rgba.data() + 4 * static_cast<std::size_t>(height_ - 1 - row) * width_;
    std::uint8_t* to = image.rgb.data() + 3 * static_cast<std::size_t>(row) * width_;
    for (int column = 0; column < width_; ++column, from += 4, to += 3) std::memcpy(to, from, 3);
  }
  return image;
}

}  // namespace loomstone
