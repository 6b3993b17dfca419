// Converts texture images to and from numpy arrays. An image can also be given as the path of a
// file, which loomstone.base.images reads.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "core/base/look.h"
#include "core/base/message.h"

namespace loomstone {

using Texture = std::shared_ptr<const TextureImage>;

// Makes an image from an array (height x width x 3 or 4) of bytes. Throws InvalidInput for other
// arrays.
inline Texture texture_of(const pybind11::array& array) {
  const auto bytes = pybind11::array_t<std::uint8_t, pybind11::array::c_style>::ensure(array);
  if (!bytes || array.dtype().kind() != 'u' || array.dtype().itemsize() != 1 || bytes.ndim() != 3 ||
      (bytes.shape(2) != 3 && bytes.shape(2) != 4))
    fail<InvalidInput>(
        "a texture must be bytes (uint8) of shape (height, width, 3) or (height, width, 4), got {} "
        "of shape {}",
        pybind11::str(array.dtype()).cast<std::string>(),
        pybind11::str(array.attr("shape")).cast<std::string>());
  TextureImage image{static_cast<int>(bytes.shape(1)), static_cast<int>(bytes.shape(0)), {}};
  const std::size_t channels = static_cast<std::size_t>(bytes.shape(2)),
                    n = static_cast<std::size_t>(bytes.size()) / channels;
  image.rgba.resize(4 * n, 255);
  for (std::size_t i = 0; i < n; ++i)
    std::copy_n(bytes.data() + channels * i, channels, &image.rgba[4 * i]);
  return std::make_shared<const TextureImage>(std::move(image));
}

}  // namespace loomstone

namespace pybind11::detail {

template <>
struct type_caster<loomstone::Texture> {
  PYBIND11_TYPE_CASTER(loomstone::Texture,
                       io_name("str | os.PathLike[str] | numpy.typing.NDArray[numpy.uint8] | None",
                               "numpy.typing.NDArray[numpy.uint8] | None"));

  bool load(handle source, bool) {
    if (source.is_none()) return true;
    object image = reinterpret_borrow<object>(source);
    if (isinstance<str>(source) || hasattr(source, "__fspath__"))
      image = module_::import("loomstone.base.images").attr("read_image")(source);
    if (!isinstance<array>(image)) return false;
    value = loomstone::texture_of(reinterpret_borrow<array>(image));
    return true;
  }
  static handle cast(const loomstone::Texture& image, return_value_policy, handle) {
    if (!image) return none().release();
    return array_t<std::uint8_t>({image->height, image->width, 4}, image->rgba.data()).release();
  }
};

}  // namespace pybind11::detail
