#include "core/magnetics/sources/source.h"

#include "core/base/message.h"

namespace loomstone {

void Source::potential_block(const double*, Index, double*) const {
  throw Unsupported(
      "only hard magnets and dipoles have a scalar potential, got a current or an induced body");
}

void Source::vector_potential_block(const double*, Index, double*) const {
  throw Unsupported("only loops and solenoids have a vector potential here, got another source");
}

void check_points(const ConstPointsRef& points, const char* name) {
  if (points.allFinite()) return;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      fail<InvalidInput>("{} must be finite [m], but row {} is not", name, i);
}

}  // namespace loomstone
