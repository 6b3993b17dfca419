// Renders normals and depths at half the width and height of the picture.
#include "renderer/depth_pass.h"

namespace loomstone {
namespace {

const char* depth_vertex_shader = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 view, projection;
out vec4 normal_depth;
void main() {
  vec4 p = view * vec4(position, 1.0);
  normal_depth = vec4(mat3(view) * normal, -p.z);
  gl_Position = projection * p;
}
)";

const char* depth_fragment_shader = R"(
in vec4 normal_depth;
out vec4 surface;
void main() {
  vec3 n = normalize(normal_depth.xyz);
  surface = vec4(gl_FrontFacing ? n : -n, normal_depth.w);
}
)";

}  // namespace

DepthPass::DepthPass(const GL& gl, int width, int height)
    : gl_(&gl),
      width_(width),
      height_(height),
      program_(gl, "depth", depth_vertex_shader, depth_fragment_shader),
      surface_(make_texture(gl, {GL_RGBA32F, width, height})),
      depth_(make_renderbuffer(gl, GL_DEPTH_COMPONENT24, width, height, 1)),
      framebuffer_(make_framebuffer(gl)) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, surface_.name(), 0);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
  check_framebuffer(gl, "depth pass");
}

void DepthPass::draw(const View& view, const MeshBuffers& cloth, const MeshBuffers& bodies,
                     const std::vector<PlacedFloor>& floors) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl_->Viewport(0, 0, width_, height_);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  program_.use();
  program_.set("view", view.view());
  program_.set("projection", view.projection());
  cloth.draw();
  bodies.draw();
  gl_->Enable(GL_CULL_FACE);  // floors are invisible from below
  for (const PlacedFloor& floor : floors) floor.square->draw();
  gl_->Disable(GL_CULL_FACE);
}

}  // namespace loomstone
