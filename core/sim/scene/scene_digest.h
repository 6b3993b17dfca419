// Hashes of the fields of a scene and of the integrator's options. A checkpoint stores them, so
// that a run cannot resume with another scene or integrator.
#pragma once

#include <map>
#include <string>

#include "core/integration/options.h"
#include "core/parallel/communicator.h"
#include "core/sim/scene/scene.h"

namespace loomstone {

// Returns the hashes of the fields of the scene and of the integrator's options that differ from
// their defaults. The integrator's method has a hash unless it is the default method. Looks do not
// enter the hashes. The keys are names of fields, such as "scene.gravity".
// Floating-point numbers are hashed in single precision, and magnitudes below 1e-12 as zero,
// because the last digits of computed numbers, such as sines, may differ between machines.
std::map<std::string, std::string> digests(const Scene& scene, const IntegratorOptions& options);

// Collective. Throws InvalidInput on all ranks if the digests of any rank differ from those of rank
// 0. The message names the fields whose digests differ.
void check_same_on_ranks(const Communicator& ranks,
                         const std::map<std::string, std::string>& digests);

// Throws a CacheError that lists the fields whose stored and current digests differ, if there are
// any. A checkpoint without digests passes.
void check_digests(const std::map<std::string, std::string>& kept,
                   const std::map<std::string, std::string>& now);

}  // namespace loomstone
