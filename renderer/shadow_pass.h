// First pass: the shadow map, which contains depths as seen from the light source.
#pragma once

#include "renderer/mesh_buffers.h"

namespace loomstone {

// A directional light whose shadow map covers a ball.
struct LightView {
  Float4x4 matrix;          // world to [-1, 1]^3, into which the ball exactly fits
  Eigen::Vector3f towards;  // unit vector towards the light, world frame
  float radius;             // radius of the ball [m]
};

// Returns a view that covers the bounding box [low, high] of everything that casts shadows. The map
// moves by whole texels and changes its size in steps of 10 %, so that the edges of shadows do not
// shimmer.
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
