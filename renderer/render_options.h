// Descriptions of cameras and pictures.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/choice.h"
#include "core/base/field.h"
#include "core/base/types.h"

namespace loomstone {

// Description of the camera.
struct Camera {
  Vec3 eye = Vec3(0, 0, 0);
  Vec3 target = Vec3(0, 0, 0);
  Vec3 up = Vec3(0, 0, 1);
  double field_of_view_degrees = 35.0;
  // Whether the eye is moved so that cloth and visible bodies and obstacles except floors fill the
  // picture. Then only the direction from `target` to `eye` is used. No effect with keyframes.
  bool fit = true;
  double turn = 0.0;          // [degrees/s]
  std::vector<double> times;  // times of keyframes, ascending [s]
  Points eyes, targets;       // (times x 3) [m]; without targets, `target` is used

  static auto fields() {
    using C = Camera;
    return std::make_tuple(
        field("eye", &C::eye,
              "position of the camera [m]; with fit, only its direction from target matters"),
        field("target", &C::target, "point at which the camera looks [m]"),
        field("up", &C::up, "upward direction of the picture"),
        field("field_of_view_degrees", &C::field_of_view_degrees, "degrees", between(1.0, 170.0),
              "vertical field of view"),
        field(
            "fit", &C::fit,
            "whether cloth and bodies of all frames drawn together fill the picture, seen from the "
            "direction eye - target; without effect if there are times"),
        field("turn", &C::turn, "degrees/s", unlimited(),
              "speed, in simulated time, at which the camera turns about the axis up through "
              "target, or through the middle of the scene with fit; positive: counter-clockwise "
              "seen from above"),
        field("times", &C::times, "times of keyframes of the camera [s], ascending; empty: none"),
        field("eyes", &C::eyes,
              "(times x 3) positions of the camera [m], on a smooth path through all of them"),
        field("targets", &C::targets,
              "(times x 3) points at which the camera looks [m]; empty: target"));
  }
};

enum class ClothPattern { Plain, Weave, Checker };  // the cloth shader uses these values
constexpr auto choices(ClothPattern) {
  return std::array{ChoiceName{ClothPattern::Weave, "weave"},
                    ChoiceName{ClothPattern::Checker, "checker"},
                    ChoiceName{ClothPattern::Plain, "plain"}};
}

enum class Background { Backdrop, None };
constexpr auto choices(Background) {
  return std::array{ChoiceName{Background::Backdrop, "backdrop"},
                    ChoiceName{Background::None, "none",
                               "transparent: pictures have an alpha channel, and floors without a "
                               "colour or texture only show shadows"}};
}

// Description of a picture.
struct RenderOptions {
  int width = 1280, height = 720;
  int samples = 4;  // samples per pixel (MSAA)
  ClothPattern pattern = ClothPattern::Weave;
  std::string color_by =
      "cloth";  // "cloth" or a scalar field; fields joined by + become rows of the picture
  std::optional<double> color_low, color_high;  // empty: automatic; see color_range()
  std::string color_map = "viridis";            // its colours are an argument of Renderer
  bool wireframe = false;
  bool shadows = true, ambient_occlusion = true;
  Background background = Background::Backdrop;
  bool floor = true;    // draw floors, each as a large square
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
        field("samples", &O::samples, "1", between(1, 16), "samples per pixel: 1, 2, 4 or 8"),
        field("pattern", &O::pattern, "pattern on cloth that has no texture"),
        field(
            "color_by", &O::color_by,
            "cloth | stretch | strain_weft | strain_warp | strain_shear | strain_split (left half "
            "of each cloth: weft, right half: warp) | contact (2: forced to intersect); strain is "
            "U - I, as in limits; fields joined by + are drawn one below another"),
        field("color_low", &O::color_low, "1", unlimited(),
              "value at the low end of the colour map; None: the smallest value of all frames that "
              "are drawn together"),
        field("color_high", &O::color_high, "1", unlimited(),
              "value at the high end of the colour map; None: the largest value of these frames"),
        field("color_map", &O::color_map,
              "colour map: a name of matplotlib, such as viridis, magma, cividis or RdBu_r, or "
              "diverging, which is coolwarm; diverging maps are centred on the neutral value"),
        field("wireframe", &O::wireframe, "whether the edges of the cloth's triangles are drawn"),
        field("shadows", &O::shadows, "whether soft shadows are drawn"),
        field("ambient_occlusion", &O::ambient_occlusion, "whether ambient occlusion is drawn"),
        field("background", &O::background, "background"),
        field("floor", &O::floor, "whether floors are drawn as a large ground plane"),
        field("hidden", &O::hidden, "names of hidden bodies and obstacles, joined by +"),
        field("field_lines", &O::field_lines, "1", between(0, 100000),
              "number of magnetic field lines; 0: none"),
        field("light_direction", &O::light_direction, "direction towards the light"),
        field("camera", &O::camera, "Camera"));
  }
};

}  // namespace loomstone
