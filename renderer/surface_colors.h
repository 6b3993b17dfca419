// Colours of surfaces in pictures, web pages and exported files.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "core/base/look.h"

namespace loomstone {

// Returns the default front colour of a cloth in linear RGB, by the index of the cloth in the
// scene. If there are more cloths than colours, the colours repeat.
Eigen::Vector3f cloth_color(std::size_t cloth);
// Returns the default colour of a body or obstacle in linear RGB, by its index. Colours of
// consecutive indices differ slightly.
Eigen::Vector3f body_color(std::size_t body);
// Returns the colour of a look (core/base/look.h) in linear RGB, or `otherwise` if the look has no
// colour.
Eigen::Vector3f shown_color(const Look& look, const Eigen::Vector3f& otherwise);

}  // namespace loomstone
