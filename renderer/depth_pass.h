// Second of the four passes in renderer.cpp, at half the width and height of the picture: normals
// and depths of the visible surfaces, for the light pass.
#pragma once

#include "renderer/camera.h"
#include "renderer/mesh_buffers.h"

namespace loomstone {

class DepthPass {
 public:
  DepthPass(const GL& gl, int width, int height);  // size of this pass [pixels]
  void draw(const View& view, const MeshBuffers& cloth, const MeshBuffers& bodies,
            const std::vector<PlacedFloor>& floors) const;
  // Texture with the unit normal in eye space (xyz) and the depth [m] (w), which is 0 for
  // background.
  GLuint surface() const { return surface_.name(); }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  const GL* gl_;
  int width_, height_;
  Program program_;
  GlObject surface_, depth_, framebuffer_;
};

}  // namespace loomstone
