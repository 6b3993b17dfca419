// Binds the renderer, which draws without a display.
#include "renderer/renderer.h"

#include <optional>
#include <utility>

#include <pybind11/typing.h>

#include "bindings/descriptions.h"
#include "core/base/message.h"
#include "renderer/framing.h"
#include "renderer/scalar_field.h"
#include "renderer/surface_colors.h"

namespace loomstone {

namespace {
using Pairs = std::vector<std::pair<double, double>>;

void bind_curves(py::module_& m) {
  py::class_<Curves>(m, "Curves", "Curves that are drawn as tubes in a picture.")
      .def(py::init([](const py::object& points, const std::vector<Index>& first,
                       const std::vector<double>& value, double radius) {
             const Points x = as_rows<Points>(points, "points");
             return Curves{x, first,
                           Eigen::Map<const Vector>(value.data(), static_cast<Index>(value.size())),
                           radius};
           }),
           py::arg("points"), py::arg("first"), py::arg("value"), py::arg("radius"),
           "points (n x 3) of all curves, concatenated [m]; first (curves + 1), the row where "
           "each curve starts; value (n), from\n"
           "1 (red) to -1 (blue); radius of the tubes [m].");
}

void bind_write_png(py::module_& m) {
  m.def(
      "write_png",
      [](const std::string& path,
         const py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>& rgb) {
        if (rgb.ndim() != 3 || (rgb.shape(2) != 3 && rgb.shape(2) != 4))
          fail<InvalidInput>("image must have shape (height, width, 3 or 4), got {}",
                             py::str(rgb.attr("shape")).cast<std::string>());
        const Image image{static_cast<int>(rgb.shape(1)), static_cast<int>(rgb.shape(0)),
                          static_cast<int>(rgb.shape(2)),
                          std::vector<std::uint8_t>(rgb.data(), rgb.data() + rgb.size())};
        const py::gil_scoped_release release;
        write_png(path, image);
      },
      py::arg("path"), py::arg("image"),
      "Writes an image of (height x width x 3 or 4) bytes as PNG.");
}

std::vector<ColorRange> ranges_of(const Pairs& pairs) {
  std::vector<ColorRange> ranges;
  for (const auto& [low, high] : pairs) ranges.push_back({low, high});
  return ranges;
}

Pairs pairs_of(const std::vector<ColorRange>& ranges) {
  Pairs pairs;
  for (const ColorRange& range : ranges) pairs.emplace_back(range.low, range.high);
  return pairs;
}

ColorTable table_of(const py::array_t<std::uint8_t, py::array::c_style>& colors) {
  ColorTable table;
  if (colors.ndim() != 2 || colors.shape(0) != static_cast<py::ssize_t>(table.size()) ||
      colors.shape(1) != 3)
    fail<InvalidInput>("table must be bytes of shape (256, 3), got {}",
                       py::str(colors.attr("shape")).cast<std::string>());
  for (std::size_t i = 0; i < table.size(); ++i)
    std::copy_n(colors.data() + 3 * i, 3, table[i].begin());
  return table;
}

using Arrays = py::typing::Tuple<py::array_t<float>, py::array_t<float>, py::array_t<std::int32_t>>;

Arrays arrays_of(const SurfaceImages& images) {
  return py::make_tuple(py::array_t<float>({images.height, images.width}, images.depth.data()),
                        py::array_t<float>({images.height, images.width, 3}, images.normal.data()),
                        py::array_t<std::int32_t>({images.height, images.width}, images.id.data()));
}

void bind_drawing(py::class_<Renderer>& c) {
  c.def(
      "render",
      [](Renderer& self, const Frame& frame, const Curves* curves,
         const std::optional<Pairs>& value_ranges) {
        Image image;
        const std::vector<ColorRange> values = ranges_of(value_ranges.value_or(Pairs{}));
        {
          const py::gil_scoped_release release;
          image = self.render(frame, curves, value_ranges ? &values : nullptr);
        }
        return py::array_t<std::uint8_t>({image.height, image.width, image.channels},
                                         image.pixels.data());
      },
      py::arg("frame"), py::arg("curves") = py::none(), py::arg("value_ranges") = py::none(),
      "Renders a frame, with curves if given, to (height x width x 3) bytes with rows from "
      "the top, or (height x width x 4) with alpha if the background is none. Automatic colours "
      "span\nvalue_ranges, one (minimum, maximum) for each row of color_by. By default they span "
      "the values of this frame.");
  c.def(
      "surfaces",
      [](Renderer& self, const Frame& frame, const Curves* curves) {
        SurfaceImages images;
        {
          const py::gil_scoped_release release;
          images = self.surfaces(frame, curves);
        }
        return arrays_of(images);
      },
      py::arg("frame"), py::arg("curves") = py::none(),
      "Returns what the middle of each pixel shows, as a tuple of arrays with rows from the "
      "top.\n\n"
      "depth (height x width): distance along the viewing direction [m], infinity without a "
      "surface\n"
      "normal (height x width x 3): unit normal on the visible side, world frame; zero without a "
      "surface\n"
      "id (height x width): 0 without a surface, from 1 the cloths, then bodies and obstacles in "
      "the order of the topology, and last the curves");
}

}  // namespace

void bind_renderer(py::module_& m) {
  bind_description<Camera>(m, "Camera", "Position and view of the camera, and its motion.");
  bind_description<RenderOptions>(m, "RenderOptions", "Options of a picture.");
  bind_curves(m);
  bind_write_png(m);
  m.def("scalar_field", &scalar_field, py::arg("name"), py::arg("topology"), py::arg("frame"),
        "Values (n) of a field of color_by, other than strain_split, at the vertices of the cloth. "
        "Values of triangles are averaged with their rest areas as weights.");
  m.def("cloth_color", &cloth_color, py::arg("cloth"),
        "Default front colour of a cloth in linear RGB (3), by its index in the scene.");
  m.def("body_color", &body_color, py::arg("body"),
        "Default colour of a body or obstacle in linear RGB (3), by its index.");
  m.def("shown_color", &shown_color, py::arg("look"), py::arg("otherwise"),
        "Colour of a look in linear RGB (3), or `otherwise` if the look has none.");
  m.def("legend_width", &legend_width, py::arg("height"),
        "Width that the legend of a field takes at the right edge of a picture [pixels].");
  py::class_<CameraFit>(
      m, "CameraFit",
      "Finds a camera that shows cloth, bodies and obstacles of several frames "
      "as large as possible beside the legend. Floors and hidden bodies are left out. The "
      "direction of view is that of the camera of the options.")
      .def(py::init<const FrameTopology&, const RenderOptions&>(), py::arg("topology"),
           py::arg("options"))
      .def("include", &CameraFit::include, py::arg("frame"),
           py::call_guard<py::gil_scoped_release>(), "Includes a frame.")
      .def("camera", &CameraFit::camera, "Returns the camera.");
  py::class_<Renderer> c(
      m, "Renderer", "Draws frames of one run without a display, with OSMesa, EGL or softpipe.");
  c.def(py::init([](const FrameTopology& topology, const RenderOptions& options,
                    const std::optional<py::array_t<std::uint8_t, py::array::c_style>>& table,
                    bool diverging) {
          return std::make_unique<Renderer>(topology, options,
                                            table ? table_of(*table) : grey_table(), diverging);
        }),
        py::arg("topology"), py::arg("options") = RenderOptions{}, py::arg("table") = py::none(),
        py::arg("diverging") = false,
        "table (256 x 3): bytes, the colours of fields in sRGB; None: shades of grey. diverging: "
        "whether automatic colours are centred on the neutral value of a field");
  c.def("fit", &Renderer::fit, py::arg("first"), py::call_guard<py::gil_scoped_release>(),
        "Fits the camera to this frame, usually the first of a run. Without this call, it is "
        "fitted to the first frame rendered.");
  bind_drawing(c);
  c.def(
      "value_ranges",
      [](const Renderer& self, const Frame& frame) { return pairs_of(self.value_ranges(frame)); },
      py::arg("frame"),
      "Returns the minimum and maximum value that each row of color_by shows in a frame; (0, 0) "
      "for the row \"cloth\".");
  c.def(
      "color_ranges",
      [](const Renderer& self, const Frame& frame, const std::optional<Pairs>& value_ranges) {
        const std::vector<ColorRange> values = ranges_of(value_ranges.value_or(Pairs{}));
        return pairs_of(self.color_ranges(frame, value_ranges ? &values : nullptr));
      },
      py::arg("frame"), py::arg("value_ranges") = py::none(),
      "Returns the values at both ends of the colours of each row of color_by, with value_ranges "
      "as in render; (0, 0) for the row \"cloth\".");
  c.def_property_readonly("backend", &Renderer::backend,
                          "library that provides OpenGL: osmesa | egl | softpipe");
}

}  // namespace loomstone
