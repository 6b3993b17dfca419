// Draws the depth, the normal and the number of the visible surface at the centre of each pixel of
// the picture.
#pragma once

#include "renderer/camera.h"
#include "renderer/image.h"
#include "renderer/mesh_buffers.h"

namespace loomstone {

class DataPass {
 public:
  DataPass(const GL& gl, int width, int height);
  SurfaceImages draw(const View& view, const MeshBuffers& cloth, const MeshBuffers& bodies,
                     const std::vector<PlacedFloor>& floors) const;

 private:
  SurfaceImages read(const View& view) const;

  const GL* gl_;
  int width_, height_;
  Program program_;
  GlObject surface_, number_, depth_, framebuffer_;
};

}  // namespace loomstone
