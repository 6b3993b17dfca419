// Colours of surfaces in pictures, web pages and exported files.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "core/base/look.h"

namespace loomstone {

// Front colour of a cloth in linear RGB, by its number in the scene. If there are more cloths than
// colours, the colours repeat.
Eigen::Vector3f cloth_color(std::size_t cloth);
// Colour of a body in linear RGB, by its number. Neighbouring numbers differ slightly.
Eigen::Vector3f body_color(std::size_t body);
// Linear RGB of the colour of a look, or `otherwise` if it has none.
Eigen::Vector3f shown_color(const Look& look, const Eigen::Vector3f& otherwise);

}  // namespace loomstone
