// Third of the four passes in renderer.cpp, at half the width and height of the picture: the
// smoothed fractions of the light source and of the surroundings that are visible from each point.
#pragma once

#include "renderer/depth_pass.h"
#include "renderer/shadow_pass.h"

namespace loomstone {

struct LightPassOptions {
  bool shadows, ambient_occlusion;
  double scale;  // radius of the framed region [m]
};

class LightPass {
 public:
  LightPass(const GL& gl, int width, int height);
  void draw(const View& view, const LightView& light, const LightPassOptions& options,
            const DepthPass& depth, const ShadowPass& shadow) const;
  // Texture with the visible fractions of the light (x) and of the surroundings (y), and the depth
  // [m] (z), which is 0 for background.
  GLuint result() const { return first_.name(); }

 private:
  const GL* gl_;
  int width_, height_;
  Program light_program_, blur_program_;
  GlObject first_, second_, first_framebuffer_, second_framebuffer_, empty_;
};

}  // namespace loomstone
