// Headless rendering of frames with OSMesa, or with surfaceless EGL if OSMesa is missing. Both are
// loaded at run time.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/base/choice.h"
#include "core/base/field.h"
#include "core/base/frame.h"
#include "renderer/color_map.h"

namespace loomstone {

// Description of the camera.
struct Camera {
  Vec3 eye = Vec3(0, 0, 0);
  Vec3 target = Vec3(0, 0, 0);
  Vec3 up = Vec3(0, 0, 1);
  double field_of_view_degrees = 35.0;
  bool fit = true;  // move the eye so that the first frame fills the picture; only the direction
                    // from `target` to `eye` is used

  static auto fields() {
    using C = Camera;
    return std::make_tuple(
        field("eye", &C::eye,
              "position of the camera [m]; with fit, only its direction from target matters"),
        field("target", &C::target, "point at which the camera looks [m]"),
        field("up", &C::up, "upward direction of the picture"),
        field("field_of_view_degrees", &C::field_of_view_degrees, "degrees", between(1.0, 170.0),
              "vertical field of view"),
        field("fit", &C::fit,
              "whether the first frame of a run fills the picture, seen from the direction eye - "
              "target"));
  }
};

enum class ClothPattern { Plain, Weave, Checker };  // the shader uses the same numbers
constexpr auto choices(ClothPattern) {
  return std::array{ChoiceName{ClothPattern::Weave, "weave"},
                    ChoiceName{ClothPattern::Checker, "checker"},
                    ChoiceName{ClothPattern::Plain, "plain"}};
}

// Description of a picture.
struct RenderOptions {
  int width = 1280, height = 720;
  int samples = 4;  // per pixel (MSAA)
  ClothPattern pattern = ClothPattern::Weave;
  std::string color_by =
      "cloth";  // "cloth" or a scalar field; fields joined by + become rows of the picture
  double color_low = 0.0, color_high = 0.0;  // if equal, the drawn values define the range
  ColorMap color_map = ColorMap::Viridis;
  bool wireframe = false;
  bool shadows = true, ambient_occlusion = true;
  bool floor = true;    // draw bodies that are floors as a large ground plane
  std::string hidden;   // names of bodies and obstacles to hide, joined by +
  int field_lines = 0;  // number of magnetic field lines
  Vec3 light_direction = Vec3(-0.5, -0.6, 1.0);  // towards the light
  Camera camera;

  static auto fields() {
    using O = RenderOptions;
    return std::make_tuple(
        field("width", &O::width, "pixels", between(16, 16384), "width of the picture"),
        field("height", &O::height, "pixels", between(16, 16384),
              "height of the picture, or of each of its rows if color_by joins several fields"),
        field("samples", &O::samples, "1", between(1, 16), "samples per pixel"),
        field("pattern", &O::pattern, "pattern on the cloth"),
        field(
            "color_by", &O::color_by,
            "cloth | stretch | strain_weft | strain_warp | strain_shear | strain_split (left half "
            "of each cloth: weft, right half: warp) | contact (2: forced to intersect); strain is "
            "U - I, as in limits; fields joined by + are drawn one below another"),
        field("color_low", &O::color_low, "1", unlimited(),
              "value at the low end of the colour map"),
        field("color_high", &O::color_high, "1", unlimited(),
              "value at the high end of the colour map; if equal to color_low, colours span the "
              "values of all frames drawn together"),
        field("color_map", &O::color_map, "colour map"),
        field("wireframe", &O::wireframe, "whether the edges of the cloth's triangles are drawn"),
        field("shadows", &O::shadows, "whether soft shadows are drawn"),
        field("ambient_occlusion", &O::ambient_occlusion, "whether ambient occlusion is drawn"),
        field("floor", &O::floor, "whether floors are drawn as a large ground plane"),
        field("hidden", &O::hidden, "names of hidden bodies and obstacles, joined by +"),
        field("field_lines", &O::field_lines, "1", between(0, 100000),
              "number of magnetic field lines; 0: none"),
        field("light_direction", &O::light_direction, "direction towards the light"),
        field("camera", &O::camera, "Camera"));
  }
};

// Curves drawn as tubes, stored one after another.
struct Curves {
  Points points;             // (n x 3) [m]
  std::vector<Index> first;  // (curves + 1) row of `points` where each curve starts
  Vector value;              // (n) colour: 1 red, 0 yellow, -1 blue
  double radius = 0.0;       // of the tubes [m]
};

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // rows from the top, 3 bytes per pixel
};

struct ColorRange {
  double low, high;
};

class Renderer {
 public:
  // Throws Unsupported if neither OSMesa nor EGL can be loaded.
  Renderer(const FrameTopology& topology, const RenderOptions& options);
  ~Renderer();
  // Determines the region of a fitted camera, the length scale of shading and the sharp edges of
  // bodies from the given frame. If fit() is called with the first frame of a sequence, no picture
  // depends on the frames drawn before it. Without a call of fit(), the first rendered frame is
  // used.
  void fit(const Frame& first);
  // Minimum and maximum of the values that each row of color_by shows in a frame; 0 and 0 for
  // "cloth".
  std::vector<ColorRange> value_ranges(const Frame& frame) const;
  // Draws a frame. `values` holds the range of automatic colours for each row of color_by, for
  // example over all frames of a run. If null, the values of this frame define the range. Only one
  // thread at a time may use a Renderer, but several Renderers may exist at once.
  Image render(const Frame& frame, const Curves* curves = nullptr,
               const std::vector<ColorRange>* values = nullptr);
  const std::string& backend() const;  // "osmesa" | "egl"

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

void write_png(const std::string& path,
               const Image& image);  // writes under a temporary name, then renames the file

}  // namespace loomstone
