// Checks of a scene's descriptions, and the names of its parts in messages.
#pragma once

#include <string>

#include "core/sim/scene/scene.h"

namespace loomstone {

// Numbers, names, sizes and references of all descriptions. Throws InvalidInput.
void check_scene(const Scene& scene);

// Name of a surface in reports and files: that given, or what it is with its place, or with the
// next number of which no other surface has the name.
std::string name_of(const Scene& scene, const char* kind, std::size_t index, std::size_t count,
                    const std::string& given);

// "cloths[1]" with its name where it has one.
std::string item(const char* list, std::size_t index, const std::string& name);

}  // namespace loomstone
