// Headless pictures of frames: OSMesa, else EGL surfaceless, loaded at run time.
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

// Description.
struct Camera {
  Vec3 eye = Vec3(0, 0, 0);
  Vec3 target = Vec3(0, 0, 0);
  Vec3 up = Vec3(0, 0, 1);
  double field_of_view_degrees = 35.0;
  bool fit = true;  // eye and target are chosen so that the first frame fills the picture, seen
                    // from `eye` - `target`'s direction

  static auto fields() {
    using C = Camera;
    return std::make_tuple(
        field("eye", &C::eye,
              "where the camera is [m]; with fit, only the direction from target counts"),
        field("target", &C::target, "what the camera looks at [m]"),
        field("up", &C::up, "direction that is up"),
        field("field_of_view_degrees", &C::field_of_view_degrees, "degrees", between(1.0, 170.0),
              "vertical field of view"),
        field("fit", &C::fit,
              "the first frame of a run fills the picture, seen from the direction eye - target"));
  }
};

enum class ClothPattern { Plain, Weave, Checker };  // numbers as in the shader
constexpr auto choices(ClothPattern) {
  return std::array{ChoiceName{ClothPattern::Weave, "weave"},
                    ChoiceName{ClothPattern::Checker, "checker"},
                    ChoiceName{ClothPattern::Plain, "plain"}};
}

// Description.
struct RenderOptions {
  int width = 1280, height = 720;
  int samples = 4;  // MSAA
  ClothPattern pattern = ClothPattern::Weave;
  std::string color_by =
      "cloth";  // "cloth" or a scalar field; several joined by + lie one below another
  double color_low = 0.0, color_high = 0.0;  // equal: taken from what is drawn
  ColorMap color_map = ColorMap::Viridis;
  bool wireframe = false;
  bool shadows = true, ambient_occlusion = true;
  bool floor = true;    // draw bodies that are floors as a large ground plane
  std::string hidden;   // bodies and obstacles that are not drawn, joined by +
  int field_lines = 0;  // of magnets
  Vec3 light_direction = Vec3(-0.5, -0.6, 1.0);  // towards the light
  Camera camera;

  static auto fields() {
    using O = RenderOptions;
    return std::make_tuple(
        field("width", &O::width, "pixels", between(16, 16384), "width of the picture"),
        field("height", &O::height, "pixels", between(16, 16384),
              "height of the picture; of each where there are several"),
        field("samples", &O::samples, "1", between(1, 16), "samples a pixel"),
        field("pattern", &O::pattern, "surface of the cloth"),
        field("color_by", &O::color_by,
              "cloth | stretch | strain_weft | strain_warp | strain_shear | strain_split (of each "
              "cloth the left half shows weft, "
              "the right one warp) | contact (2: forced to intersect); strain is U - I, as limits "
              "are; pictures of several, joined "
              "by +, lie one below another"),
        field("color_low", &O::color_low, "1", unlimited(), "value at the low end of the colours"),
        field("color_high", &O::color_high, "1", unlimited(),
              "value at the high end; equal to color_low: both span all frames that are drawn "
              "together"),
        field("color_map", &O::color_map, "colour map"),
        field("wireframe", &O::wireframe, "draws the edges of the cloth's triangles over it"),
        field("shadows", &O::shadows, "soft shadows"),
        field("ambient_occlusion", &O::ambient_occlusion, "ambient occlusion"),
        field("floor", &O::floor, "draws bodies that are floors as a large ground plane"),
        field("hidden", &O::hidden,
              "names of bodies and obstacles that are not drawn, joined by +"),
        field("field_lines", &O::field_lines, "1", between(0, 100000),
              "lines of the magnets' field that are drawn; 0: none"),
        field("light_direction", &O::light_direction, "towards the light"),
        field("camera", &O::camera, "Camera"));
  }
};

// Curves drawn as tubes in a picture, end to end.
struct Curves {
  Points points;             // (n x 3) [m]
  std::vector<Index> first;  // (curves + 1) rows of `points`
  Vector value;              // (n) colour: 1 red, 0 yellow, -1 blue
  double radius = 0.0;       // of the tubes [m]
};

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // rows from the top, 3 bytes a pixel
};

struct ColorRange {
  double low, high;
};

class Renderer {
 public:
  // Throws Unsupported with one sentence where neither OSMesa nor EGL can be loaded.
  Renderer(const FrameTopology& topology, const RenderOptions& options);
  ~Renderer();
  // What a fitted camera shows, the scale of shading and which edges of bodies are sharp follow
  // from this frame: the first of a sequence, so that no picture depends on what was drawn before
  // it. Without it from the first frame that is drawn.
  void fit(const Frame& first);
  // Least and greatest value that each row of color_by shows in a frame; 0 and 0 where it shows the
  // cloth.
  std::vector<ColorRange> value_ranges(const Frame& frame) const;
  // `values`: what automatic colours span, one range a row, as of all frames of a run; without it
  // those of this frame. One thread at a time may use a Renderer; several may live at once.
  Image render(const Frame& frame, const Curves* curves = nullptr,
               const std::vector<ColorRange>* values = nullptr);
  const std::string& backend() const;  // "osmesa" | "egl"

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

void write_png(const std::string& path,
               const Image& image);  // libpng; under another name, then renamed

}  // namespace loomstone
