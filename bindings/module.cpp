// The Python module loomstone._core, which converts arguments and forwards calls to the core.
#include "bindings/bindings.h"
#include "core/base/simd.h"

PYBIND11_MODULE(_core, m) {
  loomstone::check_instruction_set();
  m.doc() = "C++ core of loomstone; use the package loomstone instead of this module.";
  m.attr("__version__") = LOOMSTONE_VERSION;
  loomstone::bind_base(m);
  loomstone::bind_mesh(m);
  loomstone::bind_parallel(m);
  loomstone::bind_rigid(m);
  loomstone::bind_magnetics(m);
  loomstone::bind_soft_bodies(m);
  loomstone::bind_scene(m);
  loomstone::bind_integrators(m);
  loomstone::bind_limits(m);
  loomstone::bind_collision(m);
  loomstone::bind_replay(m);
  loomstone::bind_cache(m);
  loomstone::bind_renderer(m);
  loomstone::bind_simulation(m);
}
