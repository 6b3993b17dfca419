#include "renderer/data_pass.h"

#include <algorithm>
#include <limits>

namespace loomstone {
namespace {

const char* data_vertex_shader = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 view, projection;
out vec3 eye_normal;
out float depth;
void main() {
  vec4 p = view * vec4(position, 1.0);
  eye_normal = mat3(view) * normal;
  depth = -p.z;
  gl_Position = projection * p;
}
)";

const char* data_fragment_shader = R"(
in vec3 eye_normal;
in float depth;
uniform float surface_number;
layout(location = 0) out vec4 normal_depth;
layout(location = 1) out float number;
void main() {
  vec3 n = normalize(eye_normal);
  normal_depth = vec4(gl_FrontFacing ? n : -n, depth);
  number = surface_number;
}
)";

}  // namespace

DataPass::DataPass(const GL& gl, int width, int height)
    : gl_(&gl),
      width_(width),
      height_(height),
      program_(gl, "data", data_vertex_shader, data_fragment_shader),
      surface_(make_texture(gl, {GL_RGBA32F, width, height})),
      number_(make_texture(
          gl, {.format = GL_R32F, .width = width, .height = height, .pixel_format = GL_RED})),
      depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height, 1)),
      framebuffer_(make_framebuffer(gl)) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, surface_.name(), 0);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, number_.name(), 0);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
  const GLenum targets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  gl.DrawBuffers(2, targets);
  check_framebuffer(gl, "data pass");
}

SurfaceImages DataPass::draw(const View& view, const MeshBuffers& cloth, const MeshBuffers& bodies,
                             const std::vector<PlacedFloor>& floors) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl_->Viewport(0, 0, width_, height_);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  program_.use();
  program_.set("view", view.view());
  program_.set("projection", view.projection());
  for (Index part = 0; part < cloth.n_parts(); ++part) {
    program_.set("surface_number", static_cast<float>(part + 1));
    cloth.draw_part(part);
  }
  for (Index part = 0; part < bodies.n_parts(); ++part) {
    program_.set("surface_number", static_cast<float>(cloth.n_parts() + part + 1));
    bodies.draw_part(part);
  }
  gl_->Enable(GL_CULL_FACE);  // floors are invisible from below
  for (const PlacedFloor& floor : floors) {
    program_.set("surface_number", static_cast<float>(cloth.n_parts() + floor.body + 1));
    floor.square->draw();
  }
  gl_->Disable(GL_CULL_FACE);
  return read(view);
}

SurfaceImages DataPass::read(const View& view) const {
  const std::size_t width = static_cast<std::size_t>(width_),
                    height = static_cast<std::size_t>(height_);
  std::vector<float> surface(4 * width * height), number(width * height);
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_->ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, surface.data());
  gl_->ReadBuffer(GL_COLOR_ATTACHMENT1);
  gl_->ReadPixels(0, 0, width_, height_, GL_RED, GL_FLOAT, number.data());
  SurfaceImages images{width_, height_, {}, {}, {}};
  images.depth.reserve(width * height);
  images.normal.reserve(3 * width * height);
  images.id.reserve(width * height);
  const Eigen::Matrix3f to_world = view.view().topLeftCorner<3, 3>().transpose();
  for (std::size_t row = height; row-- > 0;) {  // OpenGL returns rows from the bottom up
    for (std::size_t at = row * width; at < (row + 1) * width; ++at) {
      const std::int32_t id = static_cast<std::int32_t>(number[at]);
      const Eigen::Vector3f normal = to_world * Eigen::Vector3f(&surface[4 * at]);
      images.id.push_back(id);
      images.depth.push_back(id > 0 ? surface[4 * at + 3] : std::numeric_limits<float>::infinity());
      for (int axis = 0; axis < 3; ++axis) images.normal.push_back(normal[axis]);
    }
  }
  return images;
}

}  // namespace loomstone
