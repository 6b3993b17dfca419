// Hashes of the fields of a scene. A checkpoint stores them, so that a run cannot resume with
// another scene.
#pragma once

#include <map>
#include <string>

#include "core/integration/options.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

// Returns a hash of each field of Scene and of the integrator that differs from its default, by
// name ("scene.gravity"), and of the integrator's method. Numbers are hashed in single precision,
// and magnitudes below 1e-12 as zero, because sines may differ in the last digits between machines.
std::map<std::string, std::string> digests(const Scene& scene, const IntegratorOptions& options);

// Throws a CacheError that lists the fields whose digests differ. Checkpoints without digests pass.
void check_digests(const std::map<std::string, std::string>& kept,
                   const std::map<std::string, std::string>& now);

}  // namespace loomstone
