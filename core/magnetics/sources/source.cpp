#include "core/magnetics/sources/source.h"

#include <string>

#include "core/base/error.h"

namespace loomstone {

void Source::potential_block(const double*, Index, double*) const {
  throw Unsupported(
      "a scalar potential is that of hard magnets and dipoles, got a current or an induced body");
}

void Source::vector_potential_block(const double*, Index, double*) const {
  throw Unsupported("a vector potential is that of loops and solenoids, got another source");
}

void check_points(const ConstPointsRef& points, const char* name) {
  if (points.allFinite()) return;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw InvalidInput(std::string(name) + " must be finite [m], but row " + std::to_string(i) +
                         " is not");
}

}  // namespace loomstone
