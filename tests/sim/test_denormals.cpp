// Tests that the solver meets no denormal numbers, for which processors take up to a hundred times
// as long.
#include <catch2/catch.hpp>

#if defined(__SSE2__)

#include <xmmintrin.h>

#include "core/mesh/generators.h"
#include "tests/sim/sim_support.h"

using namespace loomstone;

TEST_CASE("a solve has no denormal operands, and leaves the thread's arithmetic as it was") {
  constexpr unsigned flags = 0x3f, denormal_operand = 0x2;  // bits of MXCSR
  const char* method =
      GENERATE("semi-implicit-euler", "bdf2", "implicit-midpoint", "nonlinear-midpoint");
  CAPTURE(method);
  // A flat sheet that falls about its pinned corner. The effect of the pin decays along the sheet
  // to values that could be denormal.
  Scene scene;
  Cloth cloth;
  cloth.mesh = test::share(grid_cells(0.6, 0.6, 24, 24));
  cloth.material.bending_weft = cloth.material.bending_warp = 1e-5;
  cloth.pins = {0};
  scene.cloths = {cloth};
  scene.collisions = false;
  Simulation sim(scene, test::step_of(1e-3, method), 1);
  const unsigned before = _mm_getcsr() & ~flags;
  _mm_setcsr(before);
  for (int i = 0; i < 20; ++i) sim.step();
  CHECK((_mm_getcsr() & ~flags) == before);
  CHECK((_mm_getcsr() & denormal_operand) == 0);
}

#endif
