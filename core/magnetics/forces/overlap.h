// Detection of solid magnets that overlap, and of thin wires that meet. The force between
// overlapping magnets has no meaning, because two magnets cannot fill the same space.
#pragma once

#include <string>
#include <vector>

#include "core/magnetics/sources/body.h"

namespace loomstone {

// Returns whether two bodies overlap by more than 1e-6 of the sum of their radii
// (Source::radius()). This tolerance allows for rounding. Bodies may touch. Dipoles, currents and
// cells fill no space, so they never overlap. The test is exact for pairs of hard cuboids and for
// pairs with a sphere. For other pairs, a lattice of points on the surface of each body is tested.
bool overlap(const MagneticBody& a, const MagneticBody& b);

// Returns the outward unit normal of a solid source's surface at the surface point closest to
// `point`. If several surface points are equally close, for example if `point` is the centre of a
// sphere, the normal may be zero. Vectors are in the axes of the source.
Vec3 outward_normal(const Source& solid, const Vec3& point);
// Returns the nearest point just above the surface of a solid source if `point` lies inside or on
// the surface and its outward_normal() is not zero, and otherwise `point`. Points are in the axes
// of the source [m].
Vec3 moved_outside(const Source& solid, const Vec3& point);

// Throws InvalidInput if two bodies overlap or two thin wires meet. The message names the first
// such pair in the order of `bodies`. `names` contains the names of the bodies.
void check_no_overlap(const std::vector<MagneticBody>& bodies,
                      const std::vector<std::string>& names);

}  // namespace loomstone
