#include <catch2/catch.hpp>

#include "core/collision/continuous.h"

using namespace loomstone;

TEST_CASE("a vertex that falls through a face is hit at half time") {
  const MovingPoints q = {Vec3(0.2, 0.2, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0),
                          Vec3(0.2, 0.2, -1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const Impact impact = continuous_vertex_face(q);
  CHECK(impact.hit);
  CHECK(impact.time == Approx(0.5).margin(1e-9));
}
