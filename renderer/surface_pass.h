// Last pass, full size with several samples a pixel: background, floor, bodies, cloth, its edges.
#pragma once

#include "renderer/color_map.h"
#include "renderer/light_pass.h"
#include "renderer/scalar_field.h"

namespace loomstone {

struct SurfaceOptions {
  std::string pattern;      // "weave" | "checker" | "plain"
  bool wireframe;
  bool colored;             // by values between low and high
  ColorRange range;
};

class SurfacePass {
 public:
  SurfacePass(const GL& gl, int width, int height, int samples, const ColorTable& table);
  // pattern_size: edge of the square that each cloth would fill, from its uv [m].
  void draw(const View& view, const LightView& light, const SurfaceOptions& options, const LightPass& seen,
            const MeshBuffers& cloth, const MeshBuffers& bodies, const std::vector<const SquareBuffers*>& floors,
            const std::vector<double>& pattern_size) const;
  Image read() const;

 private:
  void set_common(const Program& program, const View& view, const LightView& light, const SurfaceOptions& options,
                  const LightPass& seen) const;

  const GL* gl_;
  int width_, height_;
  Program background_program_, floor_program_, cloth_program_, body_program_, edge_program_;
  GlObject color_, depth_, framebuffer_, resolved_, resolved_framebuffer_, color_table_, empty_;
};

}  // namespace loomstone
