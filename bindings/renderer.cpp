// Binds the renderer, which draws without a display.
#include "renderer/renderer.h"

#include <optional>
#include <utility>

#include "bindings/descriptions.h"
#include "core/base/message.h"
#include "renderer/cloth_colors.h"

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
        if (rgb.ndim() != 3 || rgb.shape(2) != 3)
          fail<InvalidInput>("image must have shape (height, width, 3), got {}",
                             py::str(rgb.attr("shape")).cast<std::string>());
        const Image image{static_cast<int>(rgb.shape(1)), static_cast<int>(rgb.shape(0)),
                          std::vector<std::uint8_t>(rgb.data(), rgb.data() + rgb.size())};
        const py::gil_scoped_release release;
        write_png(path, image);
      },
      py::arg("path"), py::arg("image"), "Writes an image of (height x width x 3) bytes as PNG.");
}

}  // namespace

void bind_renderer(py::module_& m) {
  bind_description<Camera>(m, "Camera", "Position and view of the camera.");
  bind_description<RenderOptions>(m, "RenderOptions", "Options of a picture.");
  bind_curves(m);
  bind_write_png(m);
  m.def("cloth_color", &cloth_color, py::arg("cloth"),
        "Front colour of a cloth in linear RGB (3), by its number in the scene.");
  py::class_<Renderer> c(m, "Renderer",
                         "Draws frames of one run without a display, by OSMesa or else by EGL.");
  c.def(py::init<const FrameTopology&, const RenderOptions&>(), py::arg("topology"),
        py::arg("options") = RenderOptions{});
  c.def("fit", &Renderer::fit, py::arg("first"), py::call_guard<py::gil_scoped_release>(),
        "Fits the camera to this frame, usually the first of a run. Without this call, it is "
        "fitted to the first frame rendered.");
  c.def(
      "render",
      [](Renderer& self, const Frame& frame, const Curves* curves,
         const std::optional<Pairs>& value_ranges) {
        Image image;
        std::vector<ColorRange> values;
        for (const auto& [low, high] : value_ranges.value_or(Pairs{}))
          values.push_back({low, high});
        {
          const py::gil_scoped_release release;
          image = self.render(frame, curves, value_ranges ? &values : nullptr);
        }
        return py::array_t<std::uint8_t>({image.height, image.width, 3}, image.rgb.data());
      },
      py::arg("frame"), py::arg("curves") = py::none(), py::arg("value_ranges") = py::none(),
      "Renders a frame, with curves if given, to (height x width x 3) bytes with rows from "
      "the top. Automatic colours span\n"
      "value_ranges, one (minimum, maximum) for each row of color_by. By default they span "
      "the values of this frame.");
  c.def(
      "value_ranges",
      [](const Renderer& self, const Frame& frame) {
        Pairs pairs;
        for (const ColorRange& range : self.value_ranges(frame))
          pairs.emplace_back(range.low, range.high);
        return pairs;
      },
      py::arg("frame"),
      "Returns the minimum and maximum value that each row of color_by shows in a frame; (0, 0) "
      "for a row that shows the cloth.");
  c.def_property_readonly("backend", &Renderer::backend,
                          "library that provides OpenGL: osmesa | egl");
}

}  // namespace loomstone
