// Renders the shadow map.
#include "renderer/shadow_pass.h"

#include <cmath>

namespace loomstone {
namespace {

const char* shadow_vertex_shader = R"(
layout(location = 0) in vec3 position;
uniform mat4 light;
void main() { gl_Position = light * vec4(position, 1.0); }
)";

const char* shadow_fragment_shader = R"(
void main() {}
)";

}  // namespace

LightView make_light_view(const Vec3& direction, const Vec3& low, const Vec3& high) {
  const Vec3 towards = direction.normalized();
  const Vec3 aside = std::abs(towards.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 right = aside.cross(towards).normalized(), up = towards.cross(right);
  const double tight = std::max(1e-9, 0.5 * (high - low).norm()) * 1.02;
  const double radius = std::pow(1.1, std::ceil(std::log(tight) / std::log(1.1)));
  const double texel = 2.0 * radius / ShadowPass::resolution;
  const Vec3 centre = 0.5 * (low + high);
  const double x = texel * std::round(centre.dot(right) / texel),
               y = texel * std::round(centre.dot(up) / texel);
  const double z = centre.dot(towards);
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = right.transpose() / radius;
  m.block<1, 3>(1, 0) = up.transpose() / radius;
  m.block<1, 3>(2, 0) = -towards.transpose() / radius;
  m(0, 3) = -x / radius;
  m(1, 3) = -y / radius;
  m(2, 3) = z / radius;
  return {m.cast<float>(), towards.cast<float>(), static_cast<float>(radius)};
}

ShadowPass::ShadowPass(const GL& gl)
    : gl_(&gl),
      program_(gl, "shadow", shadow_vertex_shader, shadow_fragment_shader),
      depth_(make_texture(gl, {.format = GL_DEPTH_COMPONENT32F,
                               .width = resolution,
                               .height = resolution,
                               .pixel_format = GL_DEPTH_COMPONENT})),
      framebuffer_(make_framebuffer(gl)) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.name(), 0);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  check_framebuffer(gl, "shadow pass");
}

void ShadowPass::draw(const LightView& light, const MeshBuffers& cloth,
                      const MeshBuffers& bodies) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  gl_->Viewport(0, 0, resolution, resolution);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->Clear(GL_DEPTH_BUFFER_BIT);
  program_.use();
  program_.set("light", light.matrix);
  cloth.draw();
  bodies.draw();
}

}  // namespace loomstone
