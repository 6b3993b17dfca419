#include "example_run.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include <stdlib.h>

namespace loomstone::testing {

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "loomstone-cache-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("no temporary directory");
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

FrameTopology example_topology(int side, bool with_bodies) {
  FrameTopology topology;
  const int n_cells = (side - 1) * (side - 1);
  topology.triangles.resize(4 * n_cells, 3);
  int triangle = 0;
  for (int cloth = 0; cloth < 2; ++cloth)
    for (int i = 0; i + 1 < side; ++i)
      for (int j = 0; j + 1 < side; ++j) {
        const int corner = cloth * side * side + i * side + j;
        topology.triangles.row(triangle++) << corner, corner + 1, corner + side;
        topology.triangles.row(triangle++) << corner + 1, corner + side + 1, corner + side;
      }
  topology.corner_uv.resize(triangle * 3, 2);
  // In the second half of the triangles of the second cloth, the texture coordinate u is shifted by
  // 1, so the texture has a seam between the two halves.
  for (int corner = 0; corner < 3 * triangle; ++corner) {
    const int vertex = topology.triangles.data()[corner];
    const double shift = corner >= 9 * triangle / 4 ? 1.0 : 0.0;
    topology.corner_uv.row(corner) << shift + 0.1 * std::sin(vertex), 0.1 * std::cos(vertex);
  }
  topology.cloth_of_triangle.assign(static_cast<std::size_t>(triangle), 0);
  for (int i = triangle / 2; i < triangle; ++i)
    topology.cloth_of_triangle[static_cast<std::size_t>(i)] = 1;
  topology.cloth_of_vertex.assign(static_cast<std::size_t>(2 * side * side), 0);
  for (int i = side * side; i < 2 * side * side; ++i)
    topology.cloth_of_vertex[static_cast<std::size_t>(i)] = 1;
  topology.cloth_names = {"skirt", "a name with \xC3\xA9"};
  topology.cloth_looks = {Look{}, Look{Vec3(1, 0, 0.5), {}, {}, 0.0}};
  topology.body_triangles.resize(0, 3);
  if (with_bodies) {
    topology.body_triangles.resize(6, 3);
    topology.body_triangles << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2, 4, 5, 6, 4, 6, 7;
    topology.body_of_triangle = {0, 0, 0, 0, 1, 1};
    topology.body_of_vertex = {0, 0, 0, 0, 1, 1, 1, 1};
    topology.body_names = {"tetrahedron", "floor"};
    topology.body_is_floor = {0, 1};
    const TextureImage image{2, 1, {1, 2, 3, 4, 5, 6, 7, 8}};
    topology.body_looks = {Look{{}, 0.25, std::make_shared<const TextureImage>(image), 0.5},
                           Look{Vec3(0.1, 0.2, 1.0), {}, {}, 0.0}};
    topology.body_corner_uv = Points2::Zero(18, 2);
    topology.body_corner_uv(3, 1) = 0.75;
  }
  return topology;
}

namespace {

constexpr int steps_per_frame = 4;

StepReport example_report(std::int64_t step) {
  const double x = static_cast<double>(step);
  StepReport report;
  // Each number depends on the step and on its place in the report.
  int place = 0;
  for_each_number(report, [&](const std::string&, const auto&, auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    ++place;
    if constexpr (std::is_floating_point_v<Value>)
      value = std::sin(place * (1 + x));
    else
      value = static_cast<Value>(step * place % 1009);
  });
  report.step = step;
  report.time = 1e-3 * x;
  return report;
}

}  // namespace

Frame example_frame(const FrameTopology& topology, int index) {
  const auto n_vertices = static_cast<Eigen::Index>(topology.cloth_of_vertex.size());
  const auto n_triangles = topology.triangles.rows();
  const auto fill = [index](auto& values, double phase) {
    for (Eigen::Index i = 0; i < values.size(); ++i)
      values.data()[i] = std::sin(phase + 0.37 * index + 0.011 * static_cast<double>(i));
  };
  Frame frame;
  frame.step = index * steps_per_frame;
  frame.time = 1e-3 * static_cast<double>(frame.step);
  frame.positions.resize(n_vertices, 3);
  frame.velocities.resize(n_vertices, 3);
  frame.strain.resize(n_triangles, 3);
  frame.stretch.resize(n_triangles);
  frame.body_vertices.resize(static_cast<Eigen::Index>(topology.body_of_vertex.size()), 3);
  fill(frame.positions, 0);
  fill(frame.velocities, 1);
  fill(frame.strain, 2);
  fill(frame.stretch, 3);
  fill(frame.body_vertices, 4);
  for (Eigen::Index i = 0; i < n_vertices; ++i) frame.contact.push_back((i + index) % 3 == 0);
  frame.report = example_report(frame.step);
  return frame;
}

void write_example(FrameWriter& writer, const FrameTopology& topology, int index) {
  writer.write(example_frame(topology, index));
}

namespace {

template <class A, class B>
bool same_bits(const A& a, const B& b) {
  return a.size() == b.size() &&
         (a.size() == 0 ||
          std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(*a.data())) ==
              0);
}

template <class A>
bool same_matrix(const A& a, const A& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && same_bits(a, b);
}

bool same_number(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool same_looks(const std::vector<Look>& a, const std::vector<Look>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Look& x, const Look& y) {
    return x.color == y.color && x.roughness == y.roughness && x.texture_width == y.texture_width &&
           (x.texture == y.texture || (x.texture && y.texture && *x.texture == *y.texture));
  });
}

}  // namespace

bool same(const FrameTopology& a, const FrameTopology& b) {
  return same_matrix(a.triangles, b.triangles) && same_matrix(a.corner_uv, b.corner_uv) &&
         a.cloth_of_triangle == b.cloth_of_triangle && a.cloth_of_vertex == b.cloth_of_vertex &&
         a.cloth_names == b.cloth_names && same_matrix(a.body_triangles, b.body_triangles) &&
         a.body_of_triangle == b.body_of_triangle && a.body_of_vertex == b.body_of_vertex &&
         a.body_names == b.body_names && a.body_is_floor == b.body_is_floor &&
         same_bits(a.body_pole, b.body_pole) && same_looks(a.cloth_looks, b.cloth_looks) &&
         same_looks(a.body_looks, b.body_looks) && same_matrix(a.body_corner_uv, b.body_corner_uv);
}

namespace {

bool same(const StepReport& a, const StepReport& b) {
  std::vector<double> numbers[2];
  for (const int i : {0, 1})
    for_each_number(i == 0 ? a : b, [&](const std::string&, const auto&, const auto& value) {
      numbers[i].push_back(static_cast<double>(value));
    });
  return same_bits(numbers[0], numbers[1]);
}

}  // namespace

bool same(const Frame& a, const Frame& b) {
  return same_number(a.time, b.time) && a.step == b.step && same_matrix(a.positions, b.positions) &&
         same_matrix(a.velocities, b.velocities) && same_matrix(a.strain, b.strain) &&
         same_bits(a.stretch, b.stretch) && a.contact == b.contact &&
         same_matrix(a.body_vertices, b.body_vertices) && same(a.report, b.report);
}

}  // namespace loomstone::testing
