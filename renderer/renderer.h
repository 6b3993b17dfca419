// Headless pictures of frames: OSMesa, else EGL surfaceless, loaded at run time.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/base/field.h"
#include "core/base/frame.h"

namespace loomstone {

// Description.
struct Camera {
  Vec3 eye = Vec3(0, 0, 0);
  Vec3 target = Vec3(0, 0, 0);
  Vec3 up = Vec3(0, 0, 1);
  double field_of_view_degrees = 35.0;
  bool fit = true;   // eye and target are chosen so that the scene fills the picture, seen from `eye` - `target`'s direction
};

// Description.
struct RenderOptions {
  int width = 1280, height = 720;
  int samples = 4;                      // MSAA
  std::string pattern = "weave";        // cloth surface: "weave" | "checker" | "plain"
  std::string color_by = "cloth";       // "cloth" | "stretch" | "strain_weft" | "strain_warp" | "strain_shear" | "contact"
  double color_low = 0.0, color_high = 0.0;   // equal: taken from the frame
  std::string color_map = "viridis";
  bool wireframe = false;
  bool shadows = true, ambient_occlusion = true;
  bool floor = true;                    // draw bodies that are floors as a large ground plane
  Vec3 light_direction = Vec3(-0.5, -0.6, 1.0);   // towards the light
  Camera camera;
};

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;   // rows from the top, 3 bytes a pixel
};

class Renderer {
 public:
  // Throws Unsupported with one sentence where neither OSMesa nor EGL can be loaded.
  Renderer(const FrameTopology& topology, const RenderOptions& options);
  ~Renderer();
  Image render(const Frame& frame);
  const std::string& backend() const;   // "osmesa" | "egl"

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

void write_png(const std::string& path, const Image& image);   // libpng; under another name, then renamed

}  // namespace loomstone
