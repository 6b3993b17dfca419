// Checks of the description of a scene, and names of its parts for messages and reports.
#pragma once

#include <string>
#include <vector>

#include "core/sim/scene/scene.h"

namespace loomstone {

// Checks numbers, names and array sizes of a scene. Other checks follow when the model is built.
// Throws InvalidInput.
void check_scene(const Scene& scene);

// Throws InvalidInput unless `vertices` are distinct indices in [0, n). `where` is the name of the
// list in the message.
void check_vertices(const std::string& where, const std::vector<Index>& vertices, Index n);

// Returns the name of a surface in reports and files. It is `given` or, if that is empty, the kind
// and index, such as "cloth0". While another surface has this name, the index is increased by
// `count`, the number of surfaces of this kind.
std::string name_of(const Scene& scene, const char* kind, std::size_t index, std::size_t count,
                    const std::string& given);

// Returns the name of a list entry for messages, for example: cloths[1] ("flag").
std::string item(const char* list, std::size_t index, const std::string& name);

}  // namespace loomstone
