// Scalar fields at vertices and the ranges of their colours.
#include "renderer/scalar_field.h"

#include <algorithm>
#include <cmath>

namespace loomstone {

const std::vector<std::string>& scalar_field_names() {
  static const std::vector<std::string> names = {"stretch",      "strain_weft",  "strain_warp",
                                                 "strain_shear", "strain_split", "contact"};
  return names;
}

std::vector<std::string> names_in(const std::string& joined) {
  std::vector<std::string> names;
  std::size_t first = 0;
  for (std::size_t end = 0; end != std::string::npos; first = end + 1) {
    end = joined.find('+', first);
    names.push_back(joined.substr(first, end == std::string::npos ? end : end - first));
  }
  return names;
}

std::array<std::string, 2> halves(const std::string& name) {
  if (name == "strain_split") return {"strain_weft", "strain_warp"};
  return {name, name};
}

namespace {

// Component of U - I (column 0 weft, 1 warp, 2 shear), where U is the right stretch tensor. U is
// computed from the Green strain E by C = I + 2 E, d = sqrt(det C) and
// U = (C + d I) / sqrt(tr C + 2 d) (docs/method.md, M21).
double corotational(const Eigen::RowVector3d& green, int column) {
  const double c11 = 1.0 + 2.0 * green[0], c22 = 1.0 + 2.0 * green[1], c12 = 2.0 * green[2];
  const double d = std::sqrt(std::max(0.0, c11 * c22 - c12 * c12)),
               s = std::sqrt(std::max(0.0, c11 + c22 + 2.0 * d));
  if (s == 0.0) return column == 2 ? 0.0 : -1.0;
  return column == 2 ? c12 / s : ((column == 0 ? c11 : c22) + d) / s - 1.0;
}

}  // namespace

Vector scalar_field(const std::string& name, const FrameTopology& topology, const Frame& frame) {
  const Index n = static_cast<Index>(topology.cloth_of_vertex.size());
  Vector sum = Vector::Zero(n);
  if (name == "contact") {
    for (Index vertex = 0; vertex < n; ++vertex) sum[vertex] = frame.contact[vertex];
    return sum;
  }
  const int column = name == "strain_weft"    ? 0
                     : name == "strain_warp"  ? 1
                     : name == "strain_shear" ? 2
                                              : -1;
  Vector weight = Vector::Zero(n);
  for (Index triangle = 0; triangle < topology.triangles.rows(); ++triangle) {
    const double value =
        column < 0 ? frame.stretch[triangle] : corotational(frame.strain.row(triangle), column);
    const Vec2 a = topology.corner_uv.row(3 * triangle),
               b = topology.corner_uv.row(3 * triangle + 1),
               c = topology.corner_uv.row(3 * triangle + 2);
    const double area = 0.5 * std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x());
    for (int corner = 0; corner < 3; ++corner) {
      sum[topology.triangles(triangle, corner)] += area * value;
      weight[topology.triangles(triangle, corner)] += area;
    }
  }
  for (Index vertex = 0; vertex < n; ++vertex)
    if (weight[vertex] > 0.0) sum[vertex] /= weight[vertex];
  return sum;
}

std::array<Vector, 2> row_fields(const std::string& row, const FrameTopology& topology,
                                 const Frame& frame) {
  const std::array<std::string, 2> names = halves(row);
  return {scalar_field(names[0], topology, frame),
          names[1] == names[0] ? Vector() : scalar_field(names[1], topology, frame)};
}

ColorRange value_range(const std::string& row, const std::array<Vector, 2>& fields) {
  if (row == "contact") return {0.0, 2.0};
  if (fields[0].size() == 0) return {0.0, 1.0};
  const Vector& other = fields[1].size() > 0 ? fields[1] : fields[0];
  return {std::min(fields[0].minCoeff(), other.minCoeff()),
          std::max(fields[0].maxCoeff(), other.maxCoeff())};
}

ColorRange color_range(const RenderOptions& options, const std::string& row,
                       const ColorRange& values, bool diverging) {
  ColorRange range = values;
  const auto least = [](double value) { return 1e-6 * std::max(1.0, std::abs(value)); };
  if (row != "contact") {
    if (diverging) {
      const double neutral = row == "stretch" ? 1.0 : 0.0;
      double reach = std::max(neutral - range.low, range.high - neutral);
      if (options.color_low && !options.color_high && *options.color_low < neutral)
        reach = neutral - *options.color_low;
      if (options.color_high && !options.color_low && *options.color_high > neutral)
        reach = *options.color_high - neutral;
      range = {neutral - reach, neutral + reach};
    }
    // In a range of this width, values that differ only by rounding have the same colour.
    const double width = least(range.low);
    if (range.high - range.low < width) range = {range.low - 0.5 * width, range.low + 0.5 * width};
  }
  const auto &low = options.color_low, &high = options.color_high;
  if (low) range = {*low, std::max(range.high, *low + least(*low))};
  if (high) range = {low ? *low : std::min(range.low, *high - least(*high)), *high};
  return range;
}

}  // namespace loomstone
