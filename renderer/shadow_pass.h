// First pass: depth as the light sees it.
#pragma once

#include "renderer/mesh_buffers.h"

namespace loomstone {

// A parallel light that covers a ball.
struct LightView {
  Float4x4 matrix;          // world to the cube [-1, 1]^3; depth is linear, 2 radius deep
  Eigen::Vector3f towards;  // unit vector to the light, world
  float radius;             // [m]
};

// Covers the box of what casts shadows. Moves in whole texels and grows in steps, so that shadows
// do not crawl from frame to frame.
LightView make_light_view(const Vec3& direction, const Vec3& low, const Vec3& high);

class ShadowPass {
 public:
  static constexpr int resolution = 1536;
  explicit ShadowPass(const GL& gl);
  void draw(const LightView& light, const MeshBuffers& cloth, const MeshBuffers& bodies) const;
  GLuint depth() const { return depth_.name(); }

 private:
  const GL* gl_;
  Program program_;
  GlObject depth_, framebuffer_;
};

}  // namespace loomstone
