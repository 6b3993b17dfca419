// Fields that colour cloth: numbers of a frame, one for each vertex, and the range they are
// shown in.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/base/frame.h"
#include "renderer/renderer.h"

namespace loomstone {

const std::vector<std::string>&
scalar_field_names();  // what a row of pictures may be coloured by, without "cloth"
std::string scalar_field_title(const std::string& name);
// Names joined by +: the rows of color_by from the top, what is hidden.
std::vector<std::string> names_in(const std::string& joined);

// The fields of the left and the right half of each cloth; the same but for strain_split.
std::array<std::string, 2> halves(const std::string& name);

// (n) values at the cloth's vertices. Those of triangles are averaged with the triangles' rest
// areas (areas in uv) as weights, so the picture is smooth and shows slightly less than the
// extremes. Strain is U - I, the measure of strain limits. contact is 0, 1, or 2 where triangles
// were forced to intersect.
Vector scalar_field(const std::string& name, const FrameTopology& topology, const Frame& frame);

// Those that the halves of a row show; the second is empty where it is the first.
std::array<Vector, 2> row_fields(const std::string& row, const FrameTopology& topology,
                                 const Frame& frame);
// Least and greatest of them; 0 to 2 for contact, 0 to 1 where there are no values.
ColorRange value_range(const std::string& row, const std::array<Vector, 2>& fields);
// The range that the options ask for; else that of the values, about their neutral number (0, or 1
// for stretch) where the map is diverging. Never empty.
ColorRange color_range(const RenderOptions& options, const std::string& row,
                       const ColorRange& values);

}  // namespace loomstone
