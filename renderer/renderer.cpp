// Draws a picture in five stages: shadow map, depth, light, surfaces and colour bar.
#include "renderer/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "renderer/camera.h"
#include "renderer/check.h"
#include "renderer/color_bar.h"
#include "renderer/context.h"
#include "renderer/scalar_field.h"
#include "renderer/surface_pass.h"
#include "renderer/tubes.h"

namespace loomstone {
namespace {

// Returns the square root of the area of each cloth's bounding box in uv [m], or 1 if it is 0.
std::vector<double> pattern_sizes(const FrameTopology& topology) {
  std::vector<double> sizes(topology.cloth_names.size(), 1.0);
  for (std::size_t cloth = 0; cloth < sizes.size(); ++cloth) {
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (Index row = 0; row < topology.corner_uv.rows(); ++row) {
      if (topology.cloth_of_triangle[row / 3] != static_cast<Index>(cloth)) continue;
      low = low.cwiseMin(topology.corner_uv.row(row).transpose());
      high = high.cwiseMax(topology.corner_uv.row(row).transpose());
    }
    const double area = (high - low).prod();
    if (std::isfinite(area) && area > 0.0) sizes[cloth] = std::sqrt(area);
  }
  return sizes;
}

// The plane of a floor: the mean of its vertices and the upward mean normal of its triangles.
struct Plane {
  Vec3 point, normal;
};

Plane floor_plane(const FrameTopology& topology, const Points& x, Index body) {
  Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
  double count = 0.0;
  for (Index row = 0; row < topology.body_triangles.rows(); ++row) {
    if (topology.body_of_triangle[row] != body) continue;
    const Vec3 a = x.row(topology.body_triangles(row, 0)),
               b = x.row(topology.body_triangles(row, 1)),
               c = x.row(topology.body_triangles(row, 2));
    normal += (b - a).cross(c - a);
    sum += a + b + c;
    count += 3.0;
  }
  if (count == 0.0 || normal.norm() == 0.0) return {Vec3::Zero(), Vec3::Zero()};
  if (normal.z() < 0.0) normal = -normal;
  return {sum / count, normal.normalized()};
}

// Removes the triangles of hidden bodies. Their vertices remain, so that frames still match.
FrameTopology shown(const FrameTopology& topology, const RenderOptions& options) {
  FrameTopology rest = topology;
  if (options.hidden.empty()) return rest;
  const std::vector<std::string> hidden = names_in(options.hidden);
  const auto is_hidden = [&](Index body) {
    return std::find(hidden.begin(), hidden.end(), topology.body_names[body]) != hidden.end();
  };
  for (std::size_t body = 0; body < rest.body_is_floor.size(); ++body)
    if (is_hidden(static_cast<Index>(body))) rest.body_is_floor[body] = 0;
  Index n = 0;
  for (Index row = 0; row < topology.body_triangles.rows(); ++row) {
    if (is_hidden(topology.body_of_triangle[row])) continue;
    rest.body_triangles.row(n) = topology.body_triangles.row(row);
    rest.body_of_triangle[n++] = topology.body_of_triangle[row];
  }
  rest.body_triangles.conservativeResize(n, 3);
  rest.body_of_triangle.resize(n);
  return rest;
}

// Bounding rectangle of points [pixels], or the whole picture if a point is too near the eye.
class Reach {
 public:
  Reach(const View& view, int width, int height) : view_(view), width_(width), height_(height) {}
  void include(const Vec3& point) {
    const Vec3 from_eye = point - view_.eye;
    const double depth = std::max(from_eye.dot(view_.forward), 1e-9);
    const Vec2 at(from_eye.dot(view_.right) / (depth * view_.tangent_x),
                  from_eye.dot(view_.up) / (depth * view_.tangent_y));
    low_ = low_.cwiseMin(depth <= view_.near_depth ? Vec2(-1, -1) : at);
    high_ = high_.cwiseMax(depth <= view_.near_depth ? Vec2(1, 1) : at);
  }
  Rectangle rectangle() const {
    const auto pixel = [](double at, int size, int extra) {
      return static_cast<int>(
          std::clamp((0.5 * at + 0.5) * size + extra, 0.0, static_cast<double>(size)));
    };
    const int left = pixel(low_.x(), width_, -2),
              bottom = pixel(low_.y(), height_, -2);  // 2 pixels for line width and rounding
    return {left, bottom, pixel(high_.x(), width_, 3) - left,
            pixel(high_.y(), height_, 3) - bottom};
  }

 private:
  const View& view_;
  int width_, height_;
  Vec2 low_ = Vec2::Constant(1e9), high_ = Vec2::Constant(-1e9);
};

}  // namespace

struct Renderer::Data {
  FrameTopology topology;
  RenderOptions options;
  std::unique_ptr<Context> context;
  GL gl{};
  std::vector<double> pattern_size;
  ColorTable table;
  std::optional<Framing> framing;  // from the first frame
  Points first_bodies;             // (nb x 3) body vertices of the first frame [m]
  std::optional<MeshBuffers> bodies;
  bool with_curves = false;  // `bodies` also contains the curves of the last picture

  // OpenGL objects, created and destroyed while the context is current.
  struct Passes {
    MeshBuffers cloth;
    ShadowPass shadow;
    DepthPass depth;
    LightPass light;
    SurfacePass surface;
    std::vector<SquareBuffers> floors;
  };
  std::optional<Passes> passes;

  void fit(const Frame& first);
  Image draw_row(const Frame& frame, const std::string& color_by, const Curves* curves,
                 const ColorRange* shown);
  void draw(const Frame& frame, const std::array<Vector, 2>& values, const SurfaceOptions& look,
            const Curves* curves);
  void place_bodies(const Frame& frame, const Curves* curves);
  std::vector<double> middles(const Frame& frame, const View& view) const;
  std::vector<const SquareBuffers*> place_floors(const Frame& frame);
};

Renderer::Renderer(const FrameTopology& topology, const RenderOptions& options)
    : data_(std::make_unique<Data>()) {
  check_topology(topology);
  check_options(options, 8, 16384);  // general limits, checked before OpenGL is loaded
  check_hidden(topology, options);
  Data& d = *data_;
  d.topology = shown(topology, options);
  d.options = options;
  d.context = create_context();
  const Current current(*d.context);
  d.gl = load_functions(*d.context);
  GLint most_samples = 1, most_pixels = 0;
  d.gl.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
  d.gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most_pixels);
  check_options(options, most_samples, most_pixels);
  d.pattern_size = pattern_sizes(topology);
  d.table = color_table(options.color_map);
  const int w = options.width, h = options.height, half_w = (w + 1) / 2, half_h = (h + 1) / 2;
  d.passes.emplace(Data::Passes{MeshBuffers(d.gl, drawn_cloth(topology), options.wireframe),
                                ShadowPass(d.gl),
                                DepthPass(d.gl, half_w, half_h),
                                LightPass(d.gl, half_w, half_h),
                                SurfacePass(d.gl, w, h, options.samples, d.table),
                                {}});
  if (options.floor)
    for (std::uint8_t is_floor : d.topology.body_is_floor)
      if (is_floor) d.passes->floors.emplace_back(d.gl);
}

Renderer::~Renderer() {
  const Current current(*data_->context);
  data_->passes.reset();
  data_->bodies.reset();
}

const std::string& Renderer::backend() const { return data_->context->backend(); }

std::vector<const SquareBuffers*> Renderer::Data::place_floors(const Frame& frame) {
  std::vector<const SquareBuffers*> placed;
  if (!options.floor) return placed;
  const double reach = 6.0 * framing->radius();  // the floor shader assumes this factor
  std::size_t next = 0;
  for (std::size_t body = 0; body < topology.body_is_floor.size(); ++body) {
    if (!topology.body_is_floor[body]) continue;
    SquareBuffers& square = passes->floors[next++];
    const Plane plane = floor_plane(topology, frame.body_vertices, static_cast<Index>(body));
    if (plane.normal.norm() == 0.0) continue;
    const Vec3 centre =
        framing->centre() - plane.normal.dot(framing->centre() - plane.point) * plane.normal;
    const Vec3 aside = std::abs(plane.normal.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    const Vec3 b = plane.normal.cross(aside).normalized(), a = b.cross(plane.normal);
    square.update(centre, reach * a, reach * b, plane.normal);
    placed.push_back(&square);
  }
  return placed;
}

// Curves differ from frame to frame, so buffers that contain them serve only one picture.
void Renderer::Data::place_bodies(const Frame& frame, const Curves* curves) {
  if (curves) {
    const BodiesAndTubes all =
        bodies_and_tubes(topology, first_bodies, frame.body_vertices, *curves);
    bodies.emplace(gl, all.mesh, false);
    bodies->update(all.positions, all.values, Vector());
    with_curves = true;
    return;
  }
  if (!bodies || with_curves) bodies.emplace(gl, drawn_bodies(topology, first_bodies), false);
  with_curves = false;
  bodies->update(frame.body_vertices,
                 Eigen::Map<const Vector>(topology.body_pole.data(),
                                          static_cast<Index>(topology.body_pole.size())),
                 Vector());
}

// For each cloth, the middle of the range of columns that it covers [pixels].
std::vector<double> Renderer::Data::middles(const Frame& frame, const View& view) const {
  const std::size_t n = topology.cloth_names.size();
  std::vector<double> low(n, 1.0), high(n, -1.0);
  for (Index vertex = 0; vertex < frame.positions.rows(); ++vertex) {
    const Vec3 from_eye = frame.positions.row(vertex).transpose() - view.eye;
    const double depth = from_eye.dot(view.forward);
    if (depth <= view.near_depth) continue;
    const double at = std::clamp(from_eye.dot(view.right) / (depth * view.tangent_x), -1.0, 1.0);
    const std::size_t cloth = static_cast<std::size_t>(topology.cloth_of_vertex[vertex]);
    low[cloth] = std::min(low[cloth], at);
    high[cloth] = std::max(high[cloth], at);
  }
  for (std::size_t cloth = 0; cloth < n; ++cloth)
    low[cloth] = (0.5 + 0.25 * (low[cloth] + high[cloth])) * options.width;
  return low;
}

void Renderer::Data::draw(const Frame& frame, const std::array<Vector, 2>& values,
                          const SurfaceOptions& look, const Curves* curves) {
  passes->cloth.update(frame.positions, values[0], values[1]);
  place_bodies(frame, curves);
  const std::vector<const SquareBuffers*> floors = place_floors(frame);

  const View view =
      make_view(options.camera, static_cast<double>(options.width) / options.height, *framing);
  Vec3 low = framing->centre(), high = low;  // box of everything that casts shadows [m]
  Reach reach(view, options.width, options.height);
  const auto include = [&](const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    reach.include(p);
  };
  for (Index vertex = 0; vertex < frame.positions.rows(); ++vertex)
    include(frame.positions.row(vertex));
  for (Index vertex = 0; vertex < frame.body_vertices.rows(); ++vertex)
    if (!topology.body_is_floor[topology.body_of_vertex[vertex]])
      include(frame.body_vertices.row(vertex));
  for (Index i = 0; curves && i < curves->points.rows(); ++i) include(curves->points.row(i));

  const LightView light = make_light_view(options.light_direction, low, high);
  if (options.shadows) passes->shadow.draw(light, passes->cloth, *bodies);
  passes->depth.draw(view, passes->cloth, *bodies, floors);
  passes->light.draw(view, light, {options.shadows, options.ambient_occlusion, framing->radius()},
                     passes->depth, passes->shadow);
  passes->surface.draw({view, light, look, passes->light},
                       {passes->cloth, *bodies, floors, pattern_size}, reach.rectangle());
}

Image Renderer::Data::draw_row(const Frame& frame, const std::string& color_by,
                               const Curves* curves, const ColorRange* shown) {
  SurfaceOptions look{options.pattern, options.wireframe, color_by != "cloth", {0.0, 1.0}, {}};
  std::array<Vector, 2> values;
  if (look.colored) {
    values = row_fields(color_by, topology, frame);
    if (values[1].size() > 0)
      look.split = middles(
          frame,
          make_view(options.camera, static_cast<double>(options.width) / options.height, *framing));
    look.range = color_range(options, color_by, shown ? *shown : value_range(color_by, values));
  }
  draw(frame, values, look, curves);
  Image image = passes->surface.read();
  if (look.colored) draw_color_bar(image, table, look.range, scalar_field_title(color_by));
  return image;
}

void Renderer::Data::fit(const Frame& first) {
  framing = make_framing(topology, first);
  first_bodies = first.body_vertices;
  bodies.reset();
}

void Renderer::fit(const Frame& first) {
  check_frame(data_->topology, data_->options, first);
  const Current current(*data_->context);
  data_->fit(first);
}

std::vector<ColorRange> Renderer::value_ranges(const Frame& frame) const {
  const Data& d = *data_;
  check_frame(d.topology, d.options, frame);
  std::vector<ColorRange> ranges;
  for (const std::string& row : names_in(d.options.color_by))
    ranges.push_back(row == "cloth" ? ColorRange{0.0, 0.0}
                                    : value_range(row, row_fields(row, d.topology, frame)));
  return ranges;
}

Image Renderer::render(const Frame& frame, const Curves* curves,
                       const std::vector<ColorRange>* values) {
  Data& d = *data_;
  check_frame(d.topology, d.options, frame);
  if (!d.framing) fit(frame);
  const Current current(*d.context);
  Image image{d.options.width, 0, {}};
  const std::vector<std::string> rows = names_in(d.options.color_by);
  check_values(rows.size(), values);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const Image below = d.draw_row(frame, rows[row], curves, values ? &(*values)[row] : nullptr);
    image.rgb.insert(image.rgb.end(), below.rgb.begin(), below.rgb.end());
    image.height += below.height;
  }
  return image;
}

}  // namespace loomstone
