// GLSL sources of the surface pass. They are assembled from parts, some of which several shaders
// share.
#pragma once

#include <string>

namespace loomstone {

std::string whole_picture_vertex_shader();
std::string surface_vertex_shader();
std::string background_fragment_shader();
std::string floor_fragment_shader();
// If `moved`, the shader receives its inputs at the position of the sample and extrapolates them to
// the centre of the pixel.
std::string cloth_fragment_shader(bool moved);
std::string body_fragment_shader(bool moved);
std::string edge_fragment_shader();
std::string overlay_fragment_shader();

}  // namespace loomstone
