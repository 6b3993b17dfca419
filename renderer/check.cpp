// Checks the input of the renderer.
#include "renderer/check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/message.h"
#include "renderer/camera.h"
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
  require(!names.empty(), "render.{} must be empty in this scene, got '{}'", field, value);
  if (std::find(names.begin(), names.end(), value) == names.end())
    fail<InvalidInput>("render.{} must be {}, got '{}'", field, listed(names), value);
}

// Checks the keyframes of a camera.
void check_path(const Camera& camera) {
  const Index n = static_cast<Index>(camera.times.size());
  for (std::size_t i = 0; i < camera.times.size(); ++i)
    require(std::isfinite(camera.times[i]) && (i == 0 || camera.times[i] > camera.times[i - 1]),
            "render.camera.times must be finite and ascending [s], got {} at entry {}; sort them",
            camera.times[i], i);
  require(
      camera.eyes.rows() == n && (camera.targets.rows() == n || camera.targets.rows() == 0),
      "render.camera must have a row of eyes, and of targets if given, for each of its {} times, "
      "got {} and {}",
      n, camera.eyes.rows(), camera.targets.rows());
  require(camera.eyes.allFinite() && camera.targets.allFinite(),
          "render.camera.eyes and targets must be finite [m]");
  for (Index i = 0; i < n; ++i) {
    const Vec3 target = camera.targets.rows() > 0 ? Vec3(camera.targets.row(i)) : camera.target;
    const Vec3 sight = target - camera.eyes.row(i).transpose();
    require(sight.norm() > 0.0 && sight.normalized().cross(camera.up.normalized()).norm() > 1e-6,
            "render.camera: keyframe {} must have a target other than its eye, and a line of sight "
            "that is not parallel to up",
            i);
  }
}

void check_camera(const Camera& camera) {
  check_fields(camera, "render.camera");
  for (const auto& [name, value] :
       {std::pair{"eye", &camera.eye}, {"target", &camera.target}, {"up", &camera.up}})
    if (!value->allFinite()) fail<InvalidInput>("render.camera.{} must be finite [m]", name);
  if (!camera.times.empty()) return check_path(camera);
  require(camera.eyes.rows() == 0 && camera.targets.rows() == 0,
          "render.camera: eyes and targets need times [s], one for each row");
  const Vec3 sight = camera.target - camera.eye;
  if (!camera.fit && sight.norm() == 0.0)
    throw InvalidInput(
        "render.camera: eye and target must differ when fit is off; move one of them or switch fit "
        "on");
  const Vec3 direction = viewing_direction(camera);
  if (camera.up.norm() == 0.0 || direction.cross(camera.up.normalized()).norm() < 1e-6)
    throw InvalidInput(
        "render.camera.up must be neither zero nor parallel to the line from eye to target; tilt "
        "it");
}

void check_rows(const char* what, Index rows, Index wanted) {
  if (rows != wanted)
    fail<InvalidInput>(
        "the frame must have {} rows of {}, got {}; use the topology of the same run", wanted, what,
        rows);
}

void check_finite(const char* what, const Points& points) {
  for (Index row = 0; row < points.rows(); ++row)
    if (!points.row(row).allFinite())
      fail<InvalidInput>(
          "{} of a frame must be finite, but row {} is not; render a frame from before the failure",
          what, row);
}

void check_corners(const char* what, const Triangles& triangles, Index n_vertices) {
  for (Index row = 0; row < triangles.rows(); ++row)
    if (triangles.row(row).minCoeff() < 0 || triangles.row(row).maxCoeff() >= n_vertices)
      fail<InvalidInput>("{} must hold vertex indices in [0, {}), but row {} does not", what,
                         n_vertices, row);
}

void check_owners(const char* what, const std::vector<Index>& owners, std::size_t n) {
  for (Index owner : owners)
    if (owner < 0 || owner >= static_cast<Index>(n))
      fail<InvalidInput>("{} must lie in [0, {}), got {}", what, n, owner);
}

}  // namespace

void check_options(const RenderOptions& options, int most_samples, int most_pixels) {
  check_fields(options, "render");
  if (std::max(options.width, options.height) > most_pixels)
    fail<InvalidInput>("render.width and height must be at most {} with this OpenGL, got {} x {}",
                       most_pixels, options.width, options.height);
  if ((options.samples != 1 && options.samples != 2 && options.samples != 4 &&
       options.samples != 8) ||
      options.samples > most_samples)
    fail<InvalidInput>(
        "render.samples must be 1, 2, 4 or 8 and at most {} with this OpenGL, got {}", most_samples,
        options.samples);
  std::vector<std::string> fields = {"cloth"};
  fields.insert(fields.end(), scalar_field_names().begin(), scalar_field_names().end());
  for (const std::string& row : names_in(options.color_by)) check_name("color_by", row, fields);
  if (options.color_low && options.color_high && !(*options.color_low < *options.color_high))
    fail<InvalidInput>("render.color_low must be less than color_high, got {} and {}",
                       *options.color_low, *options.color_high);
  if (!options.light_direction.allFinite() || options.light_direction.norm() == 0.0)
    throw InvalidInput("render.light_direction must be finite and not zero");
  check_camera(options.camera);
}

void check_topology(const FrameTopology& t) {
  const Index n = static_cast<Index>(t.cloth_of_vertex.size()), m = t.triangles.rows();
  if (t.corner_uv.rows() != 3 * m || static_cast<Index>(t.cloth_of_triangle.size()) != m)
    fail<InvalidInput>(
        "the topology must have one cloth and three rows of corner_uv for each of its {} "
        "triangles, got {} and {}",
        m, t.cloth_of_triangle.size(), t.corner_uv.rows());
  if (static_cast<Index>(t.body_of_triangle.size()) != t.body_triangles.rows() ||
      t.body_is_floor.size() != t.body_names.size())
    throw InvalidInput(
        "the topology must give the body of every body triangle, and for every body whether it is "
        "a floor");
  if (!t.body_pole.empty() && t.body_pole.size() != t.body_of_vertex.size())
    fail<InvalidInput>(
        "the topology must have a pole for each of its {} body vertices or none, got {}",
        t.body_of_vertex.size(), t.body_pole.size());
  if (!t.corner_uv.allFinite()) throw InvalidInput("corner_uv of the topology must be finite");
  require(t.cloth_looks.empty() || t.cloth_looks.size() == t.cloth_names.size(),
          "the topology must have a look for each of its {} cloths or none, got {}",
          t.cloth_names.size(), t.cloth_looks.size());
  require(t.body_looks.empty() || t.body_looks.size() == t.body_names.size(),
          "the topology must have a look for each of its {} bodies or none, got {}",
          t.body_names.size(), t.body_looks.size());
  require(
      t.body_corner_uv.rows() == 0 || t.body_corner_uv.rows() == 3 * t.body_triangles.rows(),
      "the topology must have three rows of body_corner_uv for each of its {} body triangles or "
      "none, got {}",
      t.body_triangles.rows(), t.body_corner_uv.rows());
  require(t.body_corner_uv.allFinite(), "body_corner_uv of the topology must be finite");
  for (const std::vector<Look>* looks : {&t.cloth_looks, &t.body_looks})
    for (const Look& look : *looks) check_look(look, "look");
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
  check_rows("body_vertices", frame.body_vertices.rows(),
             static_cast<Index>(topology.body_of_vertex.size()));
  check_finite("positions", frame.positions);
  check_finite("body_vertices", frame.body_vertices);
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
    fail<InvalidInput>(
        "value_ranges must have a range for each of the {} rows of color_by, got {}; take them "
        "from value_ranges() of the same options",
        rows, values->size());
  for (const ColorRange& range : *values)
    if (!(range.low <= range.high) || !std::isfinite(range.high - range.low))
      throw InvalidInput("value_ranges must be finite with low <= high");
}

}  // namespace loomstone
