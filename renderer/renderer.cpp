// Draws a picture in four passes: shadow map, depth, light and surfaces. Data images (depth,
// normals, surface numbers) are drawn in a single pass of their own.
#include "renderer/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "renderer/camera.h"
#include "renderer/check.h"
#include "renderer/context.h"
#include "renderer/data_pass.h"
#include "renderer/scalar_field.h"
#include "renderer/surface_pass.h"
#include "renderer/tubes.h"
#include "renderer/visible.h"

namespace loomstone {

struct Renderer::Data {
  FrameTopology topology;
  std::vector<Index> casting;  // vertices of visible bodies and obstacles other than floors
  RenderOptions options;
  bool diverging = false;  // whether the colour map is diverging
  std::unique_ptr<Context> context;
  GL gl{};
  std::optional<Framing> framing;  // set by fit()
  Points first_bodies;             // (nb x 3) body vertices of the frame given to fit() [m]
  std::optional<MeshBuffers> bodies;
  bool with_curves = false;  // whether `bodies` also contains the curves of one picture

  // OpenGL objects, created and destroyed while the context is current.
  struct Passes {
    MeshBuffers cloth;
    ShadowPass shadow;
    DepthPass depth;
    LightPass light;
    SurfacePass surface;
    Materials materials;
    std::vector<SquareBuffers> floors;
    std::optional<DataPass> data = {};  // made when it is first used
  };
  std::optional<Passes> passes;

  void fit(const Frame& first);
  View view(double time) const {
    return make_view(options.camera, static_cast<double>(options.width) / options.height, *framing,
                     time, legend_share(options));
  }
  ColorRange shown_range(const std::string& row, const std::array<Vector, 2>& fields,
                         const ColorRange* values) const {
    return color_range(options, row, values ? *values : value_range(row, fields), diverging);
  }
  Image draw_row(const Frame& frame, const std::string& color_by, const Curves* curves,
                 const ColorRange* values);
  void draw(const Frame& frame, const std::array<Vector, 2>& values, const SurfaceOptions& look,
            const Curves* curves);
  void place_bodies(const Frame& frame, const Curves* curves);
  std::vector<double> middles(const Frame& frame, const View& view) const;
  std::vector<PlacedFloor> place_floors(const Frame& frame);
};

Renderer::Renderer(const FrameTopology& topology, const RenderOptions& options,
                   const ColorTable& table, bool diverging)
    : data_(std::make_unique<Data>()) {
  check_topology(topology);
  check_options(options, 8, 16384);  // general limits, checked before OpenGL is loaded
  check_hidden(topology, options);
  Data& d = *data_;
  d.topology = shown(topology, options);
  d.casting = casting_vertices(d.topology);
  d.options = options;
  d.diverging = diverging;
  d.context = create_context();
  const Current current(*d.context);
  d.gl = load_functions(*d.context);
  GLint most_samples = 1, most_pixels = 0;
  d.gl.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
  d.gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most_pixels);
  const bool separate = most_samples < 2;  // no MSAA: 4 drawings replace 2 or 4 samples per pixel
  check_options(options, separate ? 4 : most_samples, most_pixels);
  const SurfacePass::Samples samples{options.samples, separate && options.samples > 1};
  const int w = options.width, h = options.height, half_w = (w + 1) / 2, half_h = (h + 1) / 2;
  d.passes.emplace(Data::Passes{MeshBuffers(d.gl, drawn_cloth(topology), options.wireframe),
                                ShadowPass(d.gl),
                                DepthPass(d.gl, half_w, half_h),
                                LightPass(d.gl, half_w, half_h),
                                SurfacePass(d.gl, w, h, samples, table),
                                Materials(d.gl, topology),
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

std::vector<PlacedFloor> Renderer::Data::place_floors(const Frame& frame) {
  std::vector<PlacedFloor> placed;
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
    const PlaneUv uv = floor_uv(topology, frame.body_vertices, static_cast<Index>(body));
    const Vec2 middle = uv.at(centre), to_a = uv.gradient * (reach * a),
               to_b = uv.gradient * (reach * b);
    placed.push_back({static_cast<Index>(body),
                      &square,
                      {middle.cast<float>(), to_a.cast<float>(), to_b.cast<float>()}});
  }
  return placed;
}

// Curves differ from frame to frame, so buffers that contain curves are used for one picture only.
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

// Returns for each cloth the middle of the range of columns that it covers [pixels]. This is the
// middle of the picture if no vertex of the cloth lies beyond the near clipping plane.
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
  const std::vector<PlacedFloor> floors = place_floors(frame);

  const View view = this->view(frame.time);
  Vec3 low = framing->centre(), high = low;  // box around this centre and all shadow casters [m]
  Reach reach(view, options.width, options.height);
  const auto include = [&](const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    reach.include(p);
  };
  for (Index vertex = 0; vertex < frame.positions.rows(); ++vertex)
    include(frame.positions.row(vertex));
  for (const Index vertex : casting) include(frame.body_vertices.row(vertex));
  for (Index i = 0; curves && i < curves->points.rows(); ++i) include(curves->points.row(i));

  const LightView light = make_light_view(options.light_direction, low, high);
  if (options.shadows) passes->shadow.draw(light, passes->cloth, *bodies);
  passes->depth.draw(view, passes->cloth, *bodies, floors);
  passes->light.draw(view, light, {options.shadows, options.ambient_occlusion, framing->radius()},
                     passes->depth, passes->shadow);
  passes->surface.draw({view, light, look, passes->light},
                       {passes->cloth, *bodies, floors, passes->materials,
                        static_cast<Index>(topology.body_names.size())},
                       reach.rectangle());
}

Image Renderer::Data::draw_row(const Frame& frame, const std::string& color_by,
                               const Curves* curves, const ColorRange* values) {
  const bool transparent = options.background == Background::None;
  SurfaceOptions look{options.pattern,     options.wireframe, transparent,
                      color_by != "cloth", {0.0, 1.0},        {}};
  std::array<Vector, 2> fields;
  if (look.colored) {
    fields = row_fields(color_by, topology, frame);
    if (fields[1].size() > 0) look.split = middles(frame, view(frame.time));
    look.range = shown_range(color_by, fields, values);
  }
  draw(frame, fields, look, curves);
  return passes->surface.read(transparent);
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

std::vector<ColorRange> Renderer::color_ranges(const Frame& frame,
                                               const std::vector<ColorRange>* values) const {
  const Data& d = *data_;
  check_frame(d.topology, d.options, frame);
  const std::vector<std::string> rows = names_in(d.options.color_by);
  check_values(rows.size(), values);
  std::vector<ColorRange> ranges;
  for (std::size_t row = 0; row < rows.size(); ++row)
    ranges.push_back(rows[row] == "cloth"
                         ? ColorRange{0.0, 0.0}
                         : d.shown_range(rows[row], row_fields(rows[row], d.topology, frame),
                                         values ? &(*values)[row] : nullptr));
  return ranges;
}

Image Renderer::render(const Frame& frame, const Curves* curves,
                       const std::vector<ColorRange>* values) {
  Data& d = *data_;
  check_frame(d.topology, d.options, frame);
  if (!d.framing) fit(frame);
  const Current current(*d.context);
  Image image{d.options.width, 0, 3, {}};
  const std::vector<std::string> rows = names_in(d.options.color_by);
  check_values(rows.size(), values);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const Image below = d.draw_row(frame, rows[row], curves, values ? &(*values)[row] : nullptr);
    image.pixels.insert(image.pixels.end(), below.pixels.begin(), below.pixels.end());
    image.height += below.height;
    image.channels = below.channels;
  }
  return image;
}

SurfaceImages Renderer::surfaces(const Frame& frame, const Curves* curves) {
  Data& d = *data_;
  check_frame(d.topology, d.options, frame);
  if (!d.framing) fit(frame);
  const Current current(*d.context);
  if (!d.passes->data) d.passes->data.emplace(d.gl, d.options.width, d.options.height);
  d.passes->cloth.update(frame.positions, Vector(), Vector());
  d.place_bodies(frame, curves);
  return d.passes->data->draw(d.view(frame.time), d.passes->cloth, *d.bodies,
                              d.place_floors(frame));
}

}  // namespace loomstone
