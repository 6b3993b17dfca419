// Last pass, at full size. The backdrop and the floor have no visible edges and take one sample per
// pixel. Bodies, cloth and wireframe are drawn over them with several samples per pixel, only
// inside their bounding rectangle in the picture.
#pragma once

#include "renderer/color_map.h"
#include "renderer/light_pass.h"
#include "renderer/scalar_field.h"

namespace loomstone {

struct Rectangle {
  int left, bottom, width, height;  // pixels, from the lower left corner
};

struct SurfaceOptions {
  ClothPattern pattern;
  bool wireframe;
  bool colored;  // colour the cloth by its values, mapped from `range`
  ColorRange range;
  std::vector<double> split;  // per cloth: column right of which its second value is shown
                              // [pixels]; if empty, the first value is shown everywhere
};

// Inputs of shading that all surfaces share.
struct SurfaceShading {
  const View& view;
  const LightView& light;
  const SurfaceOptions& options;
  const LightPass& seen;
};

// The surfaces to draw.
struct SurfaceThings {
  const MeshBuffers& cloth;
  const MeshBuffers& bodies;
  const std::vector<const SquareBuffers*>& floors;
  const std::vector<double>&
      pattern_size;  // per cloth: edge of a square with the area of its bounding box in uv [m]
};

class SurfacePass {
 public:
  SurfacePass(const GL& gl, int width, int height, int samples, const ColorTable& table);
  void draw(const SurfaceShading& shading, const SurfaceThings& things,
            const Rectangle& reached) const;
  Image read() const;

 private:
  void draw_surroundings(const SurfaceShading& shading,
                         const std::vector<const SquareBuffers*>& floors) const;
  void draw_things(const SurfaceShading& shading, const SurfaceThings& things) const;
  void draw_floors(const std::vector<const SquareBuffers*>& floors) const;
  void set_common(const Program& program, const SurfaceShading& shading) const;

  const GL* gl_;
  int width_, height_;
  Program background_program_, floor_program_, cloth_program_, body_program_, edge_program_,
      overlay_program_;
  GlObject picture_color_, picture_depth_, picture_;  // one sample per pixel
  GlObject things_color_, things_depth_, things_;     // several samples; alpha is the coverage
  GlObject resolved_color_, resolved_;
  GlObject color_table_, empty_;
};

}  // namespace loomstone
