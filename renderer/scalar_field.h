// Scalar fields that colour the cloth, one number per vertex, and the range of their colours.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/base/frame.h"
#include "renderer/renderer.h"

namespace loomstone {

const std::vector<std::string>&
scalar_field_names();  // the names that color_by may contain besides "cloth"
// Splits a string of names joined by "+". The options color_by (one name per row of the picture,
// from the top) and hidden have this format.
std::vector<std::string> names_in(const std::string& joined);

// Returns the names of the fields shown on the left and on the right half of each cloth. They
// differ only for strain_split.
std::array<std::string, 2> halves(const std::string& name);

// Returns (n) values at the cloth vertices. The field contact is 0 without contact, 1 in contact,
// and 2 where triangles were forced to intersect. The other fields are means over the triangles at
// a vertex, weighted by their areas in uv. Strain is U - I, the measure of the strain limits.
Vector scalar_field(const std::string& name, const FrameTopology& topology, const Frame& frame);

// Returns the values shown on the left and on the right half of each cloth in a row of the picture.
// The second vector is empty if both halves show the same field.
std::array<Vector, 2> row_fields(const std::string& row, const FrameTopology& topology,
                                 const Frame& frame);
// Returns the smallest and the largest value of both fields. For the field contact, the range is
// always 0 to 2. If there are no values, it is 0 to 1.
ColorRange value_range(const std::string& row, const std::array<Vector, 2>& fields);
// Returns the range from color_low to color_high. An end that is not given is that of the range
// `values`. For fields other than contact, `values` is first changed. If the map is diverging,
// `values` becomes a range centred on the neutral value (1 for stretch, 0 for strains). This range
// reaches as far as a single given end on its own side (color_low below the neutral value,
// color_high above it), or else just far enough to contain `values`. If `values` then has almost no
// width, it is widened. If all values are beyond a single given end, the result begins or ends
// there and has almost no width.
ColorRange color_range(const RenderOptions& options, const std::string& row,
                       const ColorRange& values, bool diverging);

}  // namespace loomstone
