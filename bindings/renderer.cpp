// Headless pictures.
#include "renderer/renderer.h"

#include "bindings/descriptions.h"

namespace loomstone {

void bind_renderer(py::module_& m) {
  bind_description<Camera>(m, "Camera", "Where the picture is taken from.");
  bind_description<RenderOptions>(m, "RenderOptions", "How a picture looks.");
  py::class_<Curves>(m, "Curves", "Curves that a picture shows as tubes.")
      .def(py::init([](const py::object& points, const std::vector<Index>& first, const std::vector<double>& value, double radius) {
             const Points x = as_rows<Points>(points, "points");
             return Curves{x, first, Eigen::Map<const Vector>(value.data(), static_cast<Index>(value.size())), radius};
           }),
           py::arg("points"), py::arg("first"), py::arg("value"), py::arg("radius"),
           "(n x 3) points [m] of all curves end to end, (curves + 1) first rows, (n) values from 1 (red) to -1 (blue), radius [m].");
  py::class_<Renderer> c(m, "Renderer", "Draws frames of one run without a display (OSMesa, else EGL).");
  c.def(py::init<const FrameTopology&, const RenderOptions&>(), py::arg("topology"),
        py::arg("options") = RenderOptions{});
  c.def("fit", &Renderer::fit, py::arg("first"), py::call_guard<py::gil_scoped_release>(),
        "A fitted camera shows what it would of this frame, the first of a run; without it of the first that is drawn.");
  c.def("render",
        [](Renderer& self, const Frame& frame, const Curves* curves) {
          Image image;
          {
            const py::gil_scoped_release release;
            image = self.render(frame, curves);
          }
          return py::array_t<std::uint8_t>({image.height, image.width, 3}, image.rgb.data());
        },
        py::arg("frame"), py::arg("curves") = py::none(),
        "Picture of a frame, with curves if given: (height x width x 3) bytes, rows from the top.");
  c.def_property_readonly("backend", &Renderer::backend, "osmesa | egl");
  m.def("write_png",
        [](const std::string& path, const py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>& rgb) {
          if (rgb.ndim() != 3 || rgb.shape(2) != 3)
            throw InvalidInput("image must have shape (height, width, 3), got " +
                               py::str(rgb.attr("shape")).cast<std::string>());
          const Image image{static_cast<int>(rgb.shape(1)), static_cast<int>(rgb.shape(0)),
                            std::vector<std::uint8_t>(rgb.data(), rgb.data() + rgb.size())};
          const py::gil_scoped_release release;
          write_png(path, image);
        },
        py::arg("path"), py::arg("image"), "Writes (height x width x 3) bytes as PNG.");
}

}  // namespace loomstone
