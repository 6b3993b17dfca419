// Third pass, half size: how much of the light and how much of the surroundings each point sees,
// then smoothed.
#pragma once

#include "renderer/depth_pass.h"
#include "renderer/shadow_pass.h"

namespace loomstone {

struct LightPassOptions {
  bool shadows, ambient_occlusion;
  double scale;  // radius of the scene [m]
};

class LightPass {
 public:
  LightPass(const GL& gl, int width, int height);
  void draw(const View& view, const LightView& light, const LightPassOptions& options,
            const DepthPass& depth, const ShadowPass& shadow) const;
  GLuint result() const {
    return first_.name();
  }  // x: light seen, y: surroundings seen, z: depth [m], 0 where nothing is

 private:
  const GL* gl_;
  int width_, height_;
  Program light_program_, blur_program_;
  GlObject first_, second_, first_framebuffer_, second_framebuffer_, empty_;
};

}  // namespace loomstone
