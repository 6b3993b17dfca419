// SIMD with eight doubles or floats. A kernel is a function template whose parameter is the vector
// type Lanes. It is inlined into up to three functions, its variants, each of which is compiled for
// one instruction set. LOOMSTONE_WIDEST(kernel)(arguments) calls the variant for `instruction_set`.
// All variants give bitwise identical results, because the compiler neither fuses nor reorders
// operations.
#pragma once

#include <type_traits>

#include "core/base/halves.h"

namespace loomstone {

inline constexpr int n_lanes = 8;

typedef double Lanes512 __attribute__((vector_size(8 * n_lanes)));
typedef double HalfLanes __attribute__((vector_size(4 * n_lanes)));
typedef double QuarterLanes __attribute__((vector_size(2 * n_lanes)));
using Lanes256 = Halves<HalfLanes>;
using Lanes128 = Halves<Halves<QuarterLanes>>;

// FloatLanes<Lanes> is the vector of eight floats in a kernel whose vector of eight doubles is
// Lanes. With AVX2, the eight floats fit into one register.
typedef float Floats256 __attribute__((vector_size(4 * n_lanes)));
typedef float HalfFloats __attribute__((vector_size(2 * n_lanes)));
template <class Lanes>
using FloatLanes =
    std::conditional_t<std::is_same_v<Lanes, Lanes128>, Halves<HalfFloats>, Floats256>;

enum class InstructionSet { baseline, v3, v4 };
// The widest InstructionSet that the build and the processor support. The environment variable
// LOOMSTONE_INSTRUCTIONS can restrict it to x86-64 or x86-64-v3.
extern const InstructionSet instruction_set;
// Throws InvalidInput if the environment variable LOOMSTONE_INSTRUCTIONS has an unknown value.
void check_instruction_set();

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(__clang__) || \
    !defined(__x86_64__)
#define LOOMSTONE_SEVERAL_SETS 0
#else
#define LOOMSTONE_SEVERAL_SETS 1
#endif

// Calls the variant of a kernel that is compiled for `instruction_set`. `Kernel` is the type of a
// function object whose first argument has the type Lanes of the variant. The value of this
// argument is not used. The arguments of the kernel follow.
template <class Kernel>
class Widest {
 public:
  template <class... Arguments>
  LOOMSTONE_INLINE decltype(auto) operator()(Arguments&&... arguments) const {
#if LOOMSTONE_SEVERAL_SETS
    if (instruction_set == InstructionSet::v4) return v4<Passed<Arguments>...>(arguments...);
    if (instruction_set == InstructionSet::v3) return v3<Passed<Arguments>...>(arguments...);
#endif
    return baseline<Passed<Arguments>...>(arguments...);
  }

 private:
  // Numbers and pointers are passed by value, so that kernels need not load them again after each
  // store.
  template <class Argument>
  using Passed = std::conditional_t<std::is_scalar_v<std::remove_reference_t<Argument>>,
                                    std::remove_cvref_t<Argument>, Argument&>;

#if LOOMSTONE_SEVERAL_SETS
  template <class... Arguments>
  __attribute__((target("arch=x86-64-v4"))) static decltype(auto) v4(Arguments... a) {
    return Kernel{}(Lanes512{}, a...);
  }
  template <class... Arguments>
  __attribute__((target("arch=x86-64-v3"))) static decltype(auto) v3(Arguments... a) {
    return Kernel{}(Lanes256{}, a...);
  }
#endif
  template <class... Arguments>
  static decltype(auto) baseline(Arguments... a) {
    return Kernel{}(Lanes128{}, a...);
  }
};

template <class Kernel>
LOOMSTONE_INLINE Widest<Kernel> widest(Kernel) {
  return {};
}
#define LOOMSTONE_WIDEST(kernel)                                          \
  ::loomstone::widest([](auto lanes, auto&&... arguments)                 \
                          LOOMSTONE_INLINE_LAMBDA -> decltype(auto) {     \
                            return kernel<decltype(lanes)>(arguments...); \
                          })

template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_all(double a) {
  return Lanes{} + a;
}

template <class Lanes, class Number>
LOOMSTONE_INLINE Lanes lanes_load(const Number* p) {
  if constexpr (in_halves<Lanes>) {
    return {lanes_load<typename Lanes::Half>(p), lanes_load<typename Lanes::Half>(p + Lanes::size)};
  } else {
    Lanes r;
    __builtin_memcpy(&r, p, sizeof(Lanes));
    return r;
  }
}

template <class Lanes, class Number>
LOOMSTONE_INLINE void lanes_store(Number* p, const Lanes& a) {
  if constexpr (in_halves<Lanes>)
    lanes_store(p, a.low), lanes_store(p + Lanes::size, a.high);
  else
    __builtin_memcpy(p, &a, sizeof(Lanes));
}

// Returns a vector whose lane l contains value(first + l). Callers leave `first` at 0, and mark
// `value` with LOOMSTONE_INLINE_LAMBDA.
template <class Lanes, class Value>
LOOMSTONE_INLINE Lanes lanes_of(const Value& value, int first = 0) {
  if constexpr (in_halves<Lanes>) {
    return {lanes_of<typename Lanes::Half>(value, first),
            lanes_of<typename Lanes::Half>(value, first + Lanes::size)};
  } else if constexpr (sizeof(Lanes) == sizeof(Lanes512)) {
    return Lanes{value(0), value(1), value(2), value(3), value(4), value(5), value(6), value(7)};
  } else if constexpr (sizeof(Lanes) == sizeof(HalfLanes)) {
    return Lanes{value(first), value(first + 1), value(first + 2), value(first + 3)};
  } else {
    return Lanes{value(first), value(first + 1)};
  }
}

template <class Lanes>
LOOMSTONE_INLINE void lanes_put(Lanes& a, int lane, double value) {
  if constexpr (in_halves<Lanes>)
    lane < Lanes::size ? lanes_put(a.low, lane, value)
                       : lanes_put(a.high, lane - Lanes::size, value);
  else
    a[lane] = value;
}

// Selects eight or four lanes by index. Indices 0 to 7 denote lanes of a, 8 to 15 lanes of b.
template <int... index, class Lanes>
LOOMSTONE_INLINE auto lanes_shuffle(const Lanes& a, const Lanes& b) {
  if constexpr (in_halves<Lanes>) {
    constexpr int from[] = {index...};
    using Result = std::conditional_t<sizeof...(index) == n_lanes, Lanes, HalfLanes>;
    return lanes_of<Result>([&](int l) LOOMSTONE_INLINE_LAMBDA {
      return from[l] < n_lanes ? a[from[l]] : b[from[l] - n_lanes];
    });
  } else {
    return __builtin_shufflevector(a, b, index...);
  }
}

// Returns eight lanes with entries of the four-lane vector `a`. `index` selects the entry for each
// lane.
template <class Lanes, int... index>
LOOMSTONE_INLINE Lanes lanes_spread(const HalfLanes& a) {
  if constexpr (in_halves<Lanes>) {
    constexpr int from[] = {index...};
    return lanes_of<Lanes>([&](int l) LOOMSTONE_INLINE_LAMBDA { return a[from[l]]; });
  } else {
    return __builtin_shufflevector(a, a, index...);
  }
}

template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_select(const MaskOf<Lanes>& where, const Lanes& yes, const Lanes& no) {
  if constexpr (in_halves<Lanes>)
    return {lanes_select(where.low, yes.low, no.low), lanes_select(where.high, yes.high, no.high)};
  else
    return where ? yes : no;
}

template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_sqrt(const Lanes& a) {
  if constexpr (in_halves<Lanes>) {
    return {lanes_sqrt(a.low), lanes_sqrt(a.high)};
  } else {
    Lanes r;
    for (unsigned i = 0; i < sizeof(Lanes) / sizeof(double); ++i) r[i] = __builtin_sqrt(a[i]);
    return r;
  }
}

template <class Mask>
LOOMSTONE_INLINE bool lanes_any(const Mask& mask) {
  long long any = 0;
  for (int i = 0; i < n_lanes; ++i) any |= mask[i];
  return any != 0;
}

// Returns the sum of the lanes, added in a fixed order.
template <class Lanes>
LOOMSTONE_INLINE double lanes_sum(const Lanes& a) {
  return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]));
}

template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_min(const Lanes& a, const Lanes& b) {
  return lanes_select(a < b, a, b);
}
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_max(const Lanes& a, const Lanes& b) {
  return lanes_select(a > b, a, b);
}
template <class Lanes>
LOOMSTONE_INLINE Lanes lanes_max0(const Lanes& a) {
  return lanes_max(a, Lanes{});
}

}  // namespace loomstone
