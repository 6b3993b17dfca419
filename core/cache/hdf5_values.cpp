// Functions of Hdf5File for numeric attributes and for arrays of fixed shape.
#include <algorithm>
#include <utility>

#include "core/cache/hdf5_handles.h"

namespace loomstone {

using namespace hdf5;

void Hdf5File::write_attribute(const std::string& object, const std::string& name,
                               std::span<const std::int64_t> values) {
  const Quiet quiet;
  const hsize_t length = values.size();
  const Id space(length == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &length, nullptr));
  const std::string tried = "write attribute " + name + " of " + object;
  const Id attribute(checked(H5Acreate_by_name(file_, object.c_str(), name.c_str(), H5T_STD_I64LE,
                                               space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             shared_->name, tried));
  checked(H5Awrite(attribute, H5T_NATIVE_INT64, values.data()), shared_->name, tried);
}

// Opens the object and the attribute in each call, because writing through a handle that was open
// during a flush fails (HDF5 1.10.8).
void Hdf5File::update_attribute(const std::string& object, const std::string& name,
                                std::int64_t value) {
  const Quiet quiet;
  const std::string tried = "write attribute " + name + " of " + object;
  const Id owner(checked(H5Oopen(file_, object.c_str(), H5P_DEFAULT), shared_->name, tried));
  const Id attribute(checked(H5Aopen(owner, name.c_str(), H5P_DEFAULT), shared_->name, tried));
  checked(H5Awrite(attribute, H5T_NATIVE_INT64, &value), shared_->name, tried);
}

bool Hdf5File::has_attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  return has(object) && H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::int64_t Hdf5File::attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  const std::string tried = "read attribute " + name + " of " + object;
  const Id attribute(
      checked(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
              shared_->name, tried));
  const Id space(checked(H5Aget_space(attribute), shared_->name, tried));
  if (H5Sget_simple_extent_npoints(space) != 1)
    damaged(shared_->name, "attribute " + name + " of " + object + " is not a single number");
  std::int64_t value = 0;
  checked(H5Aread(attribute, H5T_NATIVE_INT64, &value), shared_->name, tried);
  return value;
}

void Hdf5File::write_array(const std::string& path, Number type,
                           const std::vector<std::int64_t>& shape, const void* values) {
  const Quiet quiet;
  const std::vector<hsize_t> lengths(shape.begin(), shape.end());
  const Id space(shape.empty()
                     ? H5Screate(H5S_SCALAR)
                     : H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr));
  const Id dataset(checked(
      H5Dcreate2(file_, path.c_str(), native(type), space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      shared_->name, "create " + path));
  if (H5Sget_simple_extent_npoints(space) > 0)
    checked(H5Dwrite(dataset, native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), shared_->name,
            "write " + path);
}

std::int64_t Hdf5File::open_to_read_array(const std::string& path, Number type,
                                          std::vector<std::int64_t>& shape) const {
  const Quiet quiet;
  Id dataset(checked(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), shared_->name, "open " + path));
  const Id space(checked(H5Dget_space(dataset), shared_->name, "read the shape of " + path));
  const Id stored(checked(H5Dget_type(dataset), shared_->name, "read the type of " + path));
  if (H5Tequal(stored, native(type)) <= 0)
    damaged(shared_->name, path + " holds another type of number than expected");
  hsize_t lengths[H5S_MAX_RANK] = {};
  const int rank = H5Sget_simple_extent_dims(space, lengths, nullptr);
  double bytes = static_cast<double>(H5Tget_size(stored));
  for (int axis = 0; axis < rank; ++axis) bytes *= static_cast<double>(lengths[axis]);
  if (bytes > static_cast<double>(length()))
    damaged(shared_->name, path + " claims to be larger than the file");
  shape.assign(lengths, lengths + std::max(rank, 0));
  return std::exchange(dataset.id, -1);
}

void Hdf5File::finish_reading_array(std::int64_t dataset, const std::string& path, Number type,
                                    void* values) const {
  const Quiet quiet;
  const Id owner(dataset), space(H5Dget_space(dataset));
  if (H5Sget_simple_extent_npoints(space) > 0)
    checked(H5Dread(dataset, native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), shared_->name,
            "read " + path);
}

}  // namespace loomstone
