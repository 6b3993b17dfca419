// Hashes of a scene's fields in a checkpoint, so that a run is not resumed with another scene.
#pragma once

#include <map>
#include <string>

#include "core/integration/options.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

// A hash of the integrator's method and of each field of Scene and of the integrator that differs
// from its default, by name ("scene.gravity"). Numbers are hashed in single precision, those below
// 1e-12 as zero, because another machine's sines may differ in the last digits.
std::map<std::string, std::string> digests(const Scene& scene, const IntegratorOptions& options);

// Throws CacheError naming the fields in which a checkpoint's digests differ; those of earlier
// versions have none.
void check_digests(const std::map<std::string, std::string>& kept,
                   const std::map<std::string, std::string>& now);

}  // namespace loomstone
