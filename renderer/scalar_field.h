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
// a vertex, weighted by their areas in uv. Strain is U - I, the measure of the strain limits, where
// U is the right stretch tensor. `name` must not be strain_split, which consists of two fields.
Vector scalar_field(const std::string& name, const FrameTopology& topology, const Frame& frame);

// Returns the values shown on the left and on the right half of each cloth in a row of the picture.
// The second vector is empty if both halves show the same field.
std::array<Vector, 2> row_fields(const std::string& row, const FrameTopology& topology,
                                 const Frame& frame);
// Returns the smallest and the largest value in `fields`. For the field contact, the range is
// always 0 to 2. If there are no values, it is 0 to 1.
ColorRange value_range(const std::string& row, const std::array<Vector, 2>& fields);
// Returns the range from color_low to color_high. An end that is not given is taken from the range
// `values`. For fields other than contact, `values` is first changed in two steps. In the first
// step, if the map is diverging, `values` is replaced by a range centred on the neutral value (1
// for stretch, 0 for strains). If only one of color_low and color_high is given, and color_low is
// below or color_high above the neutral value, the centred range reaches just as far as this end.
// Otherwise, it reaches just far enough to contain `values`. In the second step, a range narrower
// than 1e-6 max(1, |low|) is widened to this width, where `low` is its low end. If only one end is
// given and all values are beyond it, the result begins or ends there and has almost no width.
ColorRange color_range(const RenderOptions& options, const std::string& row,
                       const ColorRange& values, bool diverging);

}  // namespace loomstone
