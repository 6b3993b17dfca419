// What a checkpoint says about the scene it is of, so that a run is not continued as another.
#pragma once

#include <map>
#include <string>

#include "core/integration/options.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

// A hash of each field of Scene and IntegratorOptions that differs from its default, by name
// ("scene.gravity"). Numbers count to single precision, and below 1e-12 as zero: the last digits of
// another machine's sines make no other scene.
std::map<std::string, std::string> digests(const Scene& scene, const IntegratorOptions& options);

// Throws CacheError naming the fields in which a checkpoint's digests differ; those of earlier
// versions have none.
void check_digests(const std::map<std::string, std::string>& kept,
                   const std::map<std::string, std::string>& now);

}  // namespace loomstone
