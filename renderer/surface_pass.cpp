// Draws the picture itself and reads it back.
#include "renderer/surface_pass.h"

#include <array>
#include <cstring>

#include "renderer/surface_shaders.h"

namespace loomstone {
namespace {

using Rgb = Eigen::Vector3f;

// Linear colours of cloths in turn, front; the back is paler. Our choice.
const std::array<Rgb, 6> palette = {Rgb(0.055f, 0.135f, 0.27f), Rgb(0.50f, 0.155f, 0.085f), Rgb(0.245f, 0.31f, 0.185f),
                                    Rgb(0.56f, 0.36f, 0.11f),   Rgb(0.25f, 0.115f, 0.215f), Rgb(0.60f, 0.55f, 0.455f)};

Rgb back_of(const Rgb& front) { return 0.72f * front + 0.28f * Rgb(0.55f, 0.53f, 0.48f); }

}  // namespace

SurfacePass::SurfacePass(const GL& gl, int width, int height, int samples, const ColorTable& table)
    : gl_(&gl), width_(width), height_(height),
      background_program_(gl, "background", whole_picture_vertex_shader(), background_fragment_shader()),
      floor_program_(gl, "floor", surface_vertex_shader(), floor_fragment_shader()),
      cloth_program_(gl, "cloth", surface_vertex_shader(), cloth_fragment_shader()),
      body_program_(gl, "body", surface_vertex_shader(), body_fragment_shader()),
      edge_program_(gl, "edge", surface_vertex_shader(), edge_fragment_shader()),
      color_(make_renderbuffer(gl, GL_RGBA8, width, height, samples)),
      depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height, samples)),
      framebuffer_(make_framebuffer(gl)), resolved_(make_renderbuffer(gl, GL_RGBA8, width, height, 1)),
      resolved_framebuffer_(make_framebuffer(gl)),
      color_table_(make_texture(gl, GL_RGB8, 256, 1, GL_LINEAR, table.data(), GL_RGB, GL_UNSIGNED_BYTE)),
      empty_(make_vertex_array(gl)) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
  check_framebuffer(gl, "surface pass");
  gl.BindFramebuffer(GL_FRAMEBUFFER, resolved_framebuffer_.name());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, resolved_.name());
  check_framebuffer(gl, "resolved picture");
}

void SurfacePass::set_common(const Program& program, const View& view, const LightView& light,
                             const SurfaceOptions& options, const LightPass& seen) const {
  const Float4x4 to_eye = view.view();
  program.use();
  program.set("view", to_eye);
  program.set("projection", view.projection());
  program.set("size", Eigen::Vector2f(static_cast<float>(width_), static_cast<float>(height_)));
  program.set("towards_light", Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * light.towards));
  program.set("up", Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * Eigen::Vector3f::UnitZ()));
  program.set("towards_eye", 0.0f);
  program.set("colored", options.colored ? 1 : 0);
  program.set_texture("light_seen", 0, seen.result());
}

void SurfacePass::draw(const View& view, const LightView& light, const SurfaceOptions& options, const LightPass& seen,
                       const MeshBuffers& cloth, const MeshBuffers& bodies,
                       const std::vector<const SquareBuffers*>& floors, const std::vector<double>& pattern_size) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl_->Viewport(0, 0, width_, height_);
  gl_->Clear(GL_DEPTH_BUFFER_BIT);
  gl_->Enable(GL_DEPTH_TEST);

  set_common(cloth_program_, view, light, options, seen);
  cloth_program_.set_texture("color_table", 1, color_table_.name());
  cloth_program_.set("pattern", options.pattern == "weave" ? 1 : options.pattern == "checker" ? 2 : 0);
  cloth_program_.set("value_range", Eigen::Vector2f(static_cast<float>(options.range.low),
                                                    static_cast<float>(options.range.high)));
  for (Index part = 0; part < cloth.n_parts(); ++part) {
    const Rgb& front = palette[static_cast<std::size_t>(part) % palette.size()];
    cloth_program_.set("front_color", front);
    cloth_program_.set("back_color", back_of(front));
    cloth_program_.set("checker_color", Rgb(0.66f, 0.63f, 0.57f));
    cloth_program_.set("pattern_size", static_cast<float>(pattern_size[static_cast<std::size_t>(part)]));
    cloth.draw_part(part);
  }
  if (options.wireframe) {
    set_common(edge_program_, view, light, options, seen);
    edge_program_.set("towards_eye", 8e-4f);
    gl_->Enable(GL_BLEND);
    gl_->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl_->DepthMask(GL_FALSE);
    cloth.draw_edges();
    gl_->DepthMask(GL_TRUE);
    gl_->Disable(GL_BLEND);
  }

  set_common(body_program_, view, light, options, seen);
  bodies.draw();

  set_common(floor_program_, view, light, options, seen);
  gl_->Enable(GL_CULL_FACE);
  for (const SquareBuffers* floor : floors) floor->draw();
  gl_->Disable(GL_CULL_FACE);

  // The backdrop last and at the far end, where nothing was drawn: each pixel is shaded once.
  set_common(background_program_, view, light, options, seen);
  gl_->BindVertexArray(empty_.name());
  gl_->DepthFunc(GL_LEQUAL);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->DepthFunc(GL_LESS);
}

Image SurfacePass::read() const {
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_framebuffer_.name());
  gl_->BlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, resolved_framebuffer_.name());
  const std::size_t n = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  std::vector<std::uint8_t> rgba(4 * n);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  Image image{width_, height_, std::vector<std::uint8_t>(3 * n)};
  for (int row = 0; row < height_; ++row) {   // OpenGL counts rows from below
    const std::uint8_t* from = rgba.data() + 4 * static_cast<std::size_t>(height_ - 1 - row) * width_;
    std::uint8_t* to = image.rgb.data() + 3 * static_cast<std::size_t>(row) * width_;
    for (int column = 0; column < width_; ++column, from += 4, to += 3) std::memcpy(to, from, 3);
  }
  return image;
}

}  // namespace loomstone
