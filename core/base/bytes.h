// Memory that containers occupy on the heap, for reports about memory. The size of the container
// object itself is not included; it counts as memory of the object that contains it.
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

namespace loomstone {

template <class T>
concept CountsBytes = requires(const T& object) {
  { object.bytes() } -> std::convertible_to<std::size_t>;
};

template <CountsBytes T>
std::size_t bytes_of(const T& object);
template <class T, class Allocator>
std::size_t bytes_of(const std::vector<T, Allocator>& list);
template <class T>
std::size_t bytes_of(const std::unique_ptr<T>& pointer);

template <class Derived>
std::size_t bytes_of(const Eigen::PlainObjectBase<Derived>& table) {
  constexpr bool on_heap = Derived::SizeAtCompileTime == Eigen::Dynamic;
  return on_heap ? static_cast<std::size_t>(table.size()) * sizeof(typename Derived::Scalar) : 0;
}

template <CountsBytes T>
std::size_t bytes_of(const T& object) {
  return object.bytes();
}

template <class T, class Allocator>
std::size_t bytes_of(const std::vector<T, Allocator>& list) {
  std::size_t sum = list.capacity() * sizeof(T);
  if constexpr (!std::is_trivially_copyable_v<T> && requires(const T& item) { bytes_of(item); })
    for (const T& item : list) sum += bytes_of(item);
  return sum;
}

template <class T>
std::size_t bytes_of(const std::unique_ptr<T>& pointer) {
  return pointer ? sizeof(T) + bytes_of(*pointer) : 0;
}

// Returns the sum of bytes_of() over several containers.
template <class First, class... Others>
  requires(sizeof...(Others) > 0)
std::size_t bytes_of(const First& first, const Others&... others) {
  return bytes_of(first) + (bytes_of(others) + ...);
}

}  // namespace loomstone
