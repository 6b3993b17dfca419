// Arithmetic without denormal numbers. Where a system is undisturbed, a converging iteration
// produces ever smaller numbers, and processors take up to a hundred times as long for denormal
// ones. All threads of a solve by conjugate gradients flush these to zero, so results have the same
// bits on any number of threads.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace loomstone {

// While an object of this class exists, denormal numbers count as zero on the thread that has made
// it. Has no effect on processors without SSE2.
class FlushToZero {
 public:
#if defined(__SSE2__)
  FlushToZero() : before_(_mm_getcsr() & both) { _mm_setcsr(_mm_getcsr() | both); }
  ~FlushToZero() { _mm_setcsr((_mm_getcsr() & ~both) | before_); }
#else
  FlushToZero() {}
  ~FlushToZero() {}
#endif
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;

#if defined(__SSE2__)
 private:
  static constexpr unsigned both = 0x8040;  // bits of MXCSR: for results and for operands
  unsigned before_;
#endif
};

}  // namespace loomstone
