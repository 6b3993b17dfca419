// Last pass, at full size. The backdrop and the floors have no visible edges and are drawn with one
// sample per pixel. Bodies, curves, cloth and wireframe are drawn over them with
// RenderOptions::samples samples per pixel, only inside their bounding rectangle in the picture.
// Where OpenGL has only one sample per pixel (softpipe), four drawings replace several samples.
// Each drawing is shifted by the position of one sample in the pixel. In both cases, shading is
// evaluated at the centre of the pixel.
#pragma once

#include <vector>

#include "renderer/light_pass.h"
#include "renderer/materials.h"
#include "renderer/renderer.h"
#include "renderer/visible.h"

namespace loomstone {

struct SurfaceOptions {
  ClothPattern pattern;
  bool wireframe;
  bool transparent;  // no backdrop; floors without a colour or texture show only shadows
  bool colored;      // the colour of the cloth shows a field; `range` spans the colour map
  ColorRange range;
  // (cloths) Column [pixels] right of which the colours show the second of the two values of a
  // vertex (MeshBuffers). If empty, they show the first value everywhere.
  std::vector<double> split;
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
  const std::vector<PlacedFloor>& floors;
  const Materials& materials;
  // Number of bodies and obstacles. Curves, if any, are the part of `bodies` with this index.
  Index n_bodies;
};

class SurfacePass {
 public:
  // If `separate`, there is one drawing for each of four samples. Otherwise, one drawing has
  // `per_pixel` samples in each pixel.
  struct Samples {
    int per_pixel;
    bool separate;
  };
  SurfacePass(const GL& gl, int width, int height, Samples samples, const ColorTable& table);
  void draw(const SurfaceShading& shading, const SurfaceThings& things,
            const Rectangle& reached) const;
  Image read(bool with_alpha) const;

 private:
  void draw_surroundings(const SurfaceShading& shading, const SurfaceThings& things) const;
  void draw_things(const SurfaceShading& shading, const SurfaceThings& things,
                   const Eigen::Vector2f& to_centre) const;
  void draw_samples(const SurfaceShading& shading, const SurfaceThings& things,
                    const Rectangle& reached) const;
  void lay_over(const GlObject& framebuffer, const GlObject& texture) const;
  void draw_floors(const std::vector<PlacedFloor>& floors) const;
  void set_common(const Program& program, const SurfaceShading& shading,
                  const Eigen::Vector2f& to_centre = Eigen::Vector2f::Zero()) const;

  const GL* gl_;
  int width_, height_;
  // For each drawing, the vector from its sample to the centre of the pixel [pixels].
  std::vector<Eigen::Vector2f> to_centres_;
  Program background_program_, floor_program_, cloth_program_, body_program_, edge_program_,
      overlay_program_;
  GlObject picture_color_, picture_depth_, picture_;  // one sample per pixel
  // Colour and depth of one drawing. Alpha is 1 on cloth, bodies and curves, and 0 elsewhere.
  GlObject things_color_, things_depth_, things_;
  GlObject resolved_color_, resolved_;  // mean of samples of one drawing; alpha: coverage
  GlObject sum_color_, sum_;            // mean of all drawings
  GlObject color_table_, empty_;
};

}  // namespace loomstone
