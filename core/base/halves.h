// A SIMD vector in two halves, each of which is a native vector or itself a Halves. Arithmetic,
// comparisons and bitwise operations behave like those of gcc's vector types. If a register holds
// only four doubles, gcc 12 compares vectors of eight doubles element by element and moves them
// through memory. Halves stay in registers.
#pragma once

#include <type_traits>

#define LOOMSTONE_INLINE inline __attribute__((always_inline))
#define LOOMSTONE_INLINE_LAMBDA __attribute__((always_inline))

namespace loomstone {

template <class Vector>
struct VectorTypes {
  using Scalar = std::remove_cvref_t<decltype(Vector{}[0])>;
};

// Mask type of a vector: integers of the same size as the elements of the vector. All bits of an
// integer are 1 for true and 0 for false.
template <class Vector>
struct MaskType {
  using Bits =
      std::conditional_t<sizeof(typename VectorTypes<Vector>::Scalar) == 8, long long, int>;
  typedef Bits type __attribute__((vector_size(sizeof(Vector))));
};
template <class Lanes>
using MaskOf = typename MaskType<Lanes>::type;

template <class Half_>
struct Halves {
  using Half = Half_;
  using Scalar = typename VectorTypes<Half>::Scalar;
  using Mask = MaskOf<Halves>;
  static constexpr int size = sizeof(Half) / sizeof(Scalar);  // number of lanes of one half
  Half low, high;

  LOOMSTONE_INLINE Scalar operator[](int i) const { return i < size ? low[i] : high[i - size]; }
  LOOMSTONE_INLINE friend Halves operator-(const Halves& a) { return {-a.low, -a.high}; }
  LOOMSTONE_INLINE friend Halves operator~(const Halves& a) { return {~a.low, ~a.high}; }

#define LOOMSTONE_OPERATOR(op)                                                              \
  LOOMSTONE_INLINE friend Halves operator op(const Halves& a, const Halves& b) {            \
    return {a.low op b.low, a.high op b.high};                                              \
  }                                                                                         \
  LOOMSTONE_INLINE friend Halves operator op(const Halves& a, Scalar b) {                   \
    return {a.low op b, a.high op b};                                                       \
  }                                                                                         \
  LOOMSTONE_INLINE friend Halves operator op(Scalar a, const Halves& b) {                   \
    return {a op b.low, a op b.high};                                                       \
  }                                                                                         \
  LOOMSTONE_INLINE Halves& operator op## = (const Halves& b) { return *this = *this op b; } \
  LOOMSTONE_INLINE Halves& operator op## = (Scalar b) { return *this = *this op b; }
  LOOMSTONE_OPERATOR(+)
  LOOMSTONE_OPERATOR(-)
  LOOMSTONE_OPERATOR(*)
  LOOMSTONE_OPERATOR(/)
  LOOMSTONE_OPERATOR(&)
  LOOMSTONE_OPERATOR(|)
#undef LOOMSTONE_OPERATOR

#define LOOMSTONE_COMPARISON(op)                                               \
  LOOMSTONE_INLINE friend Mask operator op(const Halves& a, const Halves& b) { \
    return {a.low op b.low, a.high op b.high};                                 \
  }                                                                            \
  LOOMSTONE_INLINE friend Mask operator op(const Halves& a, Scalar b) {        \
    return {a.low op b, a.high op b};                                          \
  }
  LOOMSTONE_COMPARISON(<)
  LOOMSTONE_COMPARISON(>)
  LOOMSTONE_COMPARISON(<=)
  LOOMSTONE_COMPARISON(>=)
  LOOMSTONE_COMPARISON(!=)
#undef LOOMSTONE_COMPARISON
};

template <class Half>
struct VectorTypes<Halves<Half>> {
  using Scalar = typename Halves<Half>::Scalar;
};
template <class Half>
struct MaskType<Halves<Half>> {
  using type = Halves<MaskOf<Half>>;
};

template <class Vector>
inline constexpr bool in_halves = false;
template <class Half>
inline constexpr bool in_halves<Halves<Half>> = true;

}  // namespace loomstone
