// Colours of cloths, which pictures and exported files share.
#pragma once

#include <cstddef>

#include <Eigen/Core>

namespace loomstone {

// Front colour of a cloth in linear RGB, by its number in the scene. If there are more cloths than
// colours, the colours repeat.
Eigen::Vector3f cloth_color(std::size_t cloth);

}  // namespace loomstone
