// Refusals, each with what must hold, what came, where, and what to do.
#include "renderer/check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "renderer/camera.h"
#include "renderer/color_map.h"
#include "renderer/scalar_field.h"

namespace loomstone {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

void check_name(const std::string& field, const std::string& value,
                const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), value) == names.end())
    throw InvalidInput("render." + field + " must be " + listed(names) + ", got '" + value + "'");
}

void check_camera(const Camera& camera) {
  check_fields(camera, "render.camera");
  for (const auto& [name, value] :
       {std::pair{"eye", &camera.eye}, {"target", &camera.target}, {"up", &camera.up}})
    if (!value->allFinite())
      throw InvalidInput(std::string("render.camera.") + name + " must be finite");
  const Vec3 sight = camera.target - camera.eye;
  if (!camera.fit && sight.norm() == 0.0)
    throw InvalidInput(
        "render.camera: eye and target must differ when fit is off; move one of them or switch fit "
        "on");
  const Vec3 direction = viewing_direction(camera);
  if (camera.up.norm() == 0.0 || direction.cross(camera.up.normalized()).norm() < 1e-6)
    throw InvalidInput(
        "render.camera.up must not vanish nor lie along the line from eye to target; tilt it");
}

void check_rows(const char* what, Index rows, Index wanted) {
  if (rows != wanted)
    throw InvalidInput(std::string("the frame must have ") + std::to_string(wanted) + " rows of " +
                       what + ", got " + std::to_string(rows) +
                       "; use the topology of the same run");
}

void check_finite(const char* what, const Points& points) {
  for (Index row = 0; row < points.rows(); ++row)
    if (!points.row(row).allFinite())
      throw InvalidInput(std::string(what) + " of a frame must be finite, row " +
                         std::to_string(row) + " is not; render a frame from before the failure");
}

void check_corners(const char* what, const Triangles& triangles, Index n_vertices) {
  for (Index row = 0; row < triangles.rows(); ++row)
    if (triangles.row(row).minCoeff() < 0 || triangles.row(row).maxCoeff() >= n_vertices)
      throw InvalidInput(std::string(what) + " must index " + std::to_string(n_vertices) +
                         " vertices, row " + std::to_string(row) + " does not");
}

void check_owners(const char* what, const std::vector<Index>& owners, std::size_t n) {
  for (Index owner : owners)
    if (owner < 0 || owner >= static_cast<Index>(n))
      throw InvalidInput(std::string(what) + " must lie in [0, " + std::to_string(n) + "), got " +
                         std::to_string(owner));
}

}  // namespace

void check_options(const RenderOptions& options, int most_samples, int most_pixels) {
  check_fields(options, "render");
  if (std::max(options.width, options.height) > most_pixels)
    throw InvalidInput("render.width and height must be at most " + std::to_string(most_pixels) +
                       " here, got " + std::to_string(options.width) + " x " +
                       std::to_string(options.height));
  if ((options.samples != 1 && options.samples != 2 && options.samples != 4 &&
       options.samples != 8) ||
      options.samples > most_samples)
    throw InvalidInput("render.samples must be 1, 2, 4 or 8 and at most " +
                       std::to_string(most_samples) + " with this OpenGL, got " +
                       std::to_string(options.samples));
  check_name("pattern", options.pattern, {"weave", "checker", "plain"});
  std::vector<std::string> fields = {"cloth"};
  fields.insert(fields.end(), scalar_field_names().begin(), scalar_field_names().end());
  for (const std::string& row : names_in(options.color_by)) check_name("color_by", row, fields);
  check_name("color_map", options.color_map, color_map_names());
  if (options.color_low > options.color_high)
    throw InvalidInput("render.color_low must be at most color_high, got " +
                       std::to_string(options.color_low) + " and " +
                       std::to_string(options.color_high) + "; exchange them");
  if (!options.light_direction.allFinite() || options.light_direction.norm() == 0.0)
    throw InvalidInput("render.light_direction must be finite and not zero");
  check_camera(options.camera);
}

void check_topology(const FrameTopology& t) {
  const Index n = static_cast<Index>(t.cloth_of_vertex.size()), m = t.triangles.rows();
  if (t.corner_uv.rows() != 3 * m || static_cast<Index>(t.cloth_of_triangle.size()) != m)
    throw InvalidInput(
        "the topology must have one cloth and three rows of corner_uv for each of its " +
        std::to_string(m) + " triangles, got " + std::to_string(t.cloth_of_triangle.size()) +
        " and " + std::to_string(t.corner_uv.rows()));
  if (static_cast<Index>(t.body_of_triangle.size()) != t.body_triangles.rows() ||
      t.body_is_floor.size() != t.body_names.size())
    throw InvalidInput(
        "the topology must name a body for each body triangle and say of each body whether it is a "
        "floor");
  if (!t.body_pole.empty() && t.body_pole.size() != t.body_of_vertex.size())
    throw InvalidInput("the topology must have a pole for each body vertex or none, got " +
                       std::to_string(t.body_pole.size()));
  if (!t.corner_uv.allFinite()) throw InvalidInput("corner_uv of the topology must be finite");
  check_corners("triangles", t.triangles, n);
  check_corners("body_triangles", t.body_triangles, static_cast<Index>(t.body_of_vertex.size()));
  check_owners("cloth_of_triangle", t.cloth_of_triangle, t.cloth_names.size());
  check_owners("cloth_of_vertex", t.cloth_of_vertex, t.cloth_names.size());
  check_owners("body_of_triangle", t.body_of_triangle, t.body_names.size());
  check_owners("body_of_vertex", t.body_of_vertex, t.body_names.size());
}

void check_hidden(const FrameTopology& topology, const RenderOptions& options) {
  if (options.hidden.empty()) return;
  for (const std::string& name : names_in(options.hidden))
    check_name("hidden", name, topology.body_names);
}

void check_frame(const FrameTopology& topology, const RenderOptions& options, const Frame& frame) {
  const Index m = topology.triangles.rows(),
              n = static_cast<Index>(topology.cloth_of_vertex.size());
  check_rows("positions", frame.positions.rows(), n);
  check_rows("body_positions", frame.body_positions.rows(),
             static_cast<Index>(topology.body_of_vertex.size()));
  check_finite("positions", frame.positions);
  check_finite("body_positions", frame.body_positions);
  for (const std::string& row : names_in(options.color_by)) {
    if (row == "contact") check_rows("contact", static_cast<Index>(frame.contact.size()), n);
    if (row == "stretch") {
      check_rows("stretch", static_cast<Index>(frame.stretch.size()), m);
      if (!frame.stretch.allFinite()) throw InvalidInput("stretch of a frame must be finite");
    }
    if (row.rfind("strain", 0) == 0) {
      check_rows("strain", frame.strain.rows(), m);
      check_finite("strain", frame.strain);
    }
  }
}

void check_values(std::size_t rows, const std::vector<ColorRange>* values) {
  if (!values) return;
  if (values->size() != rows)
    throw InvalidInput("value_ranges must have a range for each of the " + std::to_string(rows) +
                       " rows of color_by, got " + std::to_string(values->size()) +
                       "; take them from value_ranges() of the same options");
  for (const ColorRange& range : *values)
    if (!(range.low <= range.high) || !std::isfinite(range.high - range.low))
      throw InvalidInput("value_ranges must be finite, the least value of each first");
}

}  // namespace loomstone
