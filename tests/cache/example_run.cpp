#include "example_run.h"

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
  for (int i = 0; i < topology.corner_uv.size(); ++i)
    topology.corner_uv.data()[i] = 0.1 * std::sin(i);
  topology.cloth_of_triangle.assign(static_cast<std::size_t>(triangle), 0);
  for (int i = triangle / 2; i < triangle; ++i)
    topology.cloth_of_triangle[static_cast<std::size_t>(i)] = 1;
  topology.cloth_of_vertex.assign(static_cast<std::size_t>(2 * side * side), 0);
  for (int i = side * side; i < 2 * side * side; ++i)
    topology.cloth_of_vertex[static_cast<std::size_t>(i)] = 1;
  topology.cloth_names = {"skirt", "a name with \xC3\xA9"};
  topology.body_triangles.resize(0, 3);
  if (with_bodies) {
    topology.body_triangles.resize(6, 3);
    topology.body_triangles << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2, 4, 5, 6, 4, 6, 7;
    topology.body_of_triangle = {0, 0, 0, 0, 1, 1};
    topology.body_of_vertex = {0, 0, 0, 0, 1, 1, 1, 1};
    topology.body_names = {"tetrahedron", "floor"};
    topology.body_is_floor = {0, 1};
  }
  return topology;
}

StepReport example_report(std::int64_t step) {
  const double x = static_cast<double>(step);
  StepReport report;
  report.step = step;
  report.time = 1e-3 * x;
  for (std::size_t i = 0; i < report.seconds.size(); ++i)
    report.seconds[i] = std::sqrt(x + static_cast<double>(i));
  report.busy_least = 0.5 * x;
  report.busy_mean = 0.7 * x;
  report.busy_most = 0.9 * x;
  report.newton_iterations = static_cast<int>(step % 7);
  report.linear_iterations = static_cast<int>(step * 3);
  report.linear_residual = 1e-9 / (1 + x);
  report.contacts = step * 11;
  report.impacts = step * 5;
  report.truncated = step % 3;
  report.substeps = static_cast<int>(1 + step % 64);
  report.unresolved = step % 2;
  report.intersections = step % 4;
  report.forced = step % 6;
  report.wanted_motion = std::sin(2 * x);
  report.withheld_motion = std::sin(3 * x);
  report.withheld = std::sin(x);
  report.truncated_momentum = std::sin(4 * x);
  report.contact_acceleration = std::sin(5 * x);
  report.limit_sweeps = static_cast<int>(step % 9);
  report.rate_sweeps = static_cast<int>(step % 8);
  report.limit_evaluations = step * 13;
  report.limit_rounds = static_cast<int>(step % 5);
  report.limit_retreats = static_cast<int>(step % 4);
  report.limit_excess = std::sin(6 * x);
  report.weft_excess = std::sin(7 * x);
  report.warp_excess = std::sin(8 * x);
  report.shear_excess = std::sin(9 * x);
  report.beyond_limit = step % 10;
  report.worst_element = step % 11 - 1;
  report.broken_limits = step % 7;
  report.weft_strain = std::sin(10 * x);
  report.warp_strain = std::sin(11 * x);
  report.shear_strain = std::sin(12 * x);
  report.max_stretch = 1 + std::exp(-x);
  report.kinetic_energy = std::cos(x);
  report.membrane_energy = std::cos(2 * x);
  report.bending_energy = std::cos(3 * x);
  report.gravity_energy = std::cos(4 * x);
  report.contact_energy = std::cos(5 * x);
  report.body_kinetic_energy = std::cos(6 * x);
  report.body_gravity_energy = std::cos(7 * x);
  report.magnetic_energy = std::cos(8 * x);
  report.magnetic_substeps = 3;
  report.magnetic_error = std::cos(9 * x);
  report.circuit_current = std::sin(20 * x);
  report.circuit_energy = std::sin(21 * x);
  report.circuit_heat = std::sin(22 * x);
  report.circuit_supply = std::sin(23 * x);
  report.bearing_work = std::sin(24 * x);
  return report;
}

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
  frame.body_positions.resize(static_cast<Eigen::Index>(topology.body_of_vertex.size()), 3);
  fill(frame.positions, 0);
  fill(frame.velocities, 1);
  fill(frame.strain, 2);
  fill(frame.stretch, 3);
  fill(frame.body_positions, 4);
  for (Eigen::Index i = 0; i < n_vertices; ++i) frame.contact.push_back((i + index) % 3 == 0);
  frame.report = example_report(frame.step);
  return frame;
}

void write_example(FrameWriter& writer, const FrameTopology& topology, int index) {
  for (int step = (index - 1) * steps_per_frame + 1; step <= index * steps_per_frame; ++step)
    if (step > 0) writer.record(example_report(step));
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

}  // namespace

bool same(const FrameTopology& a, const FrameTopology& b) {
  return same_matrix(a.triangles, b.triangles) && same_matrix(a.corner_uv, b.corner_uv) &&
         a.cloth_of_triangle == b.cloth_of_triangle && a.cloth_of_vertex == b.cloth_of_vertex &&
         a.cloth_names == b.cloth_names && same_matrix(a.body_triangles, b.body_triangles) &&
         a.body_of_triangle == b.body_of_triangle && a.body_of_vertex == b.body_of_vertex &&
         a.body_names == b.body_names && a.body_is_floor == b.body_is_floor;
}

bool same(const StepReport& a, const StepReport& b) {
  return a.step == b.step && same_number(a.time, b.time) && same_bits(a.seconds, b.seconds) &&
         same_number(a.busy_least, b.busy_least) && same_number(a.busy_mean, b.busy_mean) &&
         same_number(a.busy_most, b.busy_most) && a.newton_iterations == b.newton_iterations &&
         a.linear_iterations == b.linear_iterations &&
         same_number(a.linear_residual, b.linear_residual) && a.contacts == b.contacts &&
         a.impacts == b.impacts && a.truncated == b.truncated && a.substeps == b.substeps &&
         a.unresolved == b.unresolved && a.intersections == b.intersections &&
         same_number(a.withheld, b.withheld) && a.forced == b.forced &&
         same_number(a.wanted_motion, b.wanted_motion) &&
         same_number(a.withheld_motion, b.withheld_motion) &&
         same_number(a.truncated_momentum, b.truncated_momentum) &&
         same_number(a.contact_acceleration, b.contact_acceleration) &&
         a.limit_sweeps == b.limit_sweeps && a.rate_sweeps == b.rate_sweeps &&
         a.limit_evaluations == b.limit_evaluations &&
         same_number(a.limit_excess, b.limit_excess) && same_number(a.weft_excess, b.weft_excess) &&
         same_number(a.warp_excess, b.warp_excess) && same_number(a.shear_excess, b.shear_excess) &&
         a.beyond_limit == b.beyond_limit && a.worst_element == b.worst_element &&
         a.limit_rounds == b.limit_rounds && a.limit_retreats == b.limit_retreats &&
         a.broken_limits == b.broken_limits && same_number(a.weft_strain, b.weft_strain) &&
         same_number(a.warp_strain, b.warp_strain) && same_number(a.shear_strain, b.shear_strain) &&
         same_number(a.max_stretch, b.max_stretch) &&
         same_number(a.kinetic_energy, b.kinetic_energy) &&
         same_number(a.membrane_energy, b.membrane_energy) &&
         same_number(a.bending_energy, b.bending_energy) &&
         same_number(a.gravity_energy, b.gravity_energy) &&
         same_number(a.contact_energy, b.contact_energy) &&
         same_number(a.body_kinetic_energy, b.body_kinetic_energy) &&
         same_number(a.body_gravity_energy, b.body_gravity_energy) &&
         same_number(a.magnetic_energy, b.magnetic_energy) &&
         a.magnetic_substeps == b.magnetic_substeps &&
         same_number(a.magnetic_error, b.magnetic_error) &&
         same_number(a.circuit_current, b.circuit_current) &&
         same_number(a.circuit_energy, b.circuit_energy) &&
         same_number(a.circuit_heat, b.circuit_heat) &&
         same_number(a.circuit_supply, b.circuit_supply) &&
         same_number(a.bearing_work, b.bearing_work);
}

bool same(const Frame& a, const Frame& b) {
  return same_number(a.time, b.time) && a.step == b.step && same_matrix(a.positions, b.positions) &&
         same_matrix(a.velocities, b.velocities) && same_matrix(a.strain, b.strain) &&
         same_bits(a.stretch, b.stretch) && a.contact == b.contact &&
         same_matrix(a.body_positions, b.body_positions) && same(a.report, b.report);
}

}  // namespace loomstone::testing
