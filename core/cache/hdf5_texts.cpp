// Strings are stored with a fixed length, padded with zeros, in attributes and in datasets. VTK
// expects such strings. Strings of variable length would need a heap in the HDF5 file, which an
// interrupted write could damage.
#include <algorithm>

#include "core/cache/hdf5_handles.h"

namespace loomstone {

using namespace hdf5;

namespace {

bool is_ascii(const std::vector<std::string>& texts) {
  return std::all_of(texts.begin(), texts.end(), [](const std::string& text) {
    return std::all_of(text.begin(), text.end(),
                       [](char letter) { return static_cast<unsigned char>(letter) < 128; });
  });
}

std::size_t longest(const std::vector<std::string>& texts) {
  std::size_t length = 1;  // HDF5 has no fixed-length strings of length 0
  for (const std::string& text : texts) length = std::max(length, text.size());
  return length;
}

// Returns an HDF5 string type with the length of the longest string. The caller must close it.
hid_t type_of(const std::vector<std::string>& texts) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, longest(texts));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, is_ascii(texts) ? H5T_CSET_ASCII : H5T_CSET_UTF8);
  return type;
}

std::string joined(const std::vector<std::string>& texts) {
  const std::size_t length = longest(texts);
  std::string bytes(texts.size() * length, '\0');
  for (std::size_t i = 0; i < texts.size(); ++i)
    texts[i].copy(bytes.data() + i * length, texts[i].size());
  return bytes;
}

// Returns the number of bytes of the UTF-8 character that begins with the byte `lead`, or 0 if no
// character begins with it.
std::size_t length_of_character(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  return lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
}

// Returns whether a string is valid UTF-8. Overlong encodings, surrogates and code points above
// 0x10FFFF are invalid.
bool is_utf8(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
    const std::size_t length = length_of_character(byte(0));
    if (length == 0 || at + length > text.size()) return false;
    for (std::size_t i = 1; i < length; ++i)
      if ((byte(i) & 0xC0) != 0x80) return false;
    if (length == 3 && ((byte(0) == 0xE0 && byte(1) < 0xA0) || (byte(0) == 0xED && byte(1) > 0x9F)))
      return false;
    if (length == 4 && ((byte(0) == 0xF0 && byte(1) < 0x90) || (byte(0) == 0xF4 && byte(1) > 0x8F)))
      return false;
    at += length;
  }
  return true;
}

std::vector<std::string> split(const std::string& bytes, std::size_t length) {
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < bytes.size(); at += length) {
    const std::string text = bytes.substr(at, length);
    texts.push_back(text.substr(0, text.find_last_not_of('\0') + 1));
  }
  return texts;
}

void write_attribute(hid_t file, const std::string& name, const std::string& object,
                     const std::string& attribute, const std::vector<std::string>& texts,
                     hid_t space) {
  const std::string tried = "write attribute " + attribute + " of " + object;
  const Id type(type_of(texts));
  const Id made(checked(H5Acreate_by_name(file, object.c_str(), attribute.c_str(), type, space,
                                          H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                        name, tried));
  checked(H5Awrite(made, type, joined(texts).data()), name, tried);
}

void write_dataset(hid_t file, const std::string& name, const std::string& path,
                   const std::vector<std::string>& texts, hid_t space) {
  const Id type(type_of(texts));
  const Id made(
      checked(H5Dcreate2(file, path.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
              name, "create " + path));
  if (!texts.empty())
    checked(H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, joined(texts).data()), name,
            "write " + path);
}

}  // namespace

void Hdf5File::write_text_attribute(const std::string& object, const std::string& name,
                                    const std::string& text) {
  const Quiet quiet;
  const Id space(H5Screate(H5S_SCALAR));
  loomstone::write_attribute(file_, shared_->name, object, name, {text}, space);
}

void Hdf5File::write_text_attribute(const std::string& object, const std::string& name,
                                    const std::vector<std::string>& texts) {
  const Quiet quiet;
  const hsize_t count = texts.size();
  const Id space(H5Screate_simple(1, &count, nullptr));
  loomstone::write_attribute(file_, shared_->name, object, name, texts, space);
}

void Hdf5File::describe(const std::string& path, const std::string& unit,
                        const std::string& meaning) {
  write_text_attribute(path, "units", unit);
  write_text_attribute(path, "description", meaning);
}

void Hdf5File::describe(const std::string& path, const std::vector<Column>& columns) {
  std::vector<std::string> units, meanings;
  for (const Column& column : columns) {
    units.push_back(column.unit);
    meanings.push_back(column.meaning);
  }
  write_text_attribute(path, "units", units);
  write_text_attribute(path, "description", meanings);
}

std::string Hdf5File::text_attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  const std::string tried = "read attribute " + name + " of " + object;
  const Id attribute(
      checked(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
              shared_->name, tried));
  const Id type(checked(H5Aget_type(attribute), shared_->name, tried));
  const Id space(checked(H5Aget_space(attribute), shared_->name, tried));
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0 ||
      H5Sget_simple_extent_npoints(space) != 1)
    damaged(shared_->name, "attribute " + name + " of " + object + " is not a string");
  std::string text(H5Tget_size(type), '\0');
  checked(H5Aread(attribute, type, text.data()), shared_->name, tried);
  return text.c_str();
}

void Hdf5File::write_text(const std::string& path, const std::string& text) {
  const Quiet quiet;
  const Id space(H5Screate(H5S_SCALAR));
  write_dataset(file_, shared_->name, path, {text}, space);
}

void Hdf5File::write_texts(const std::string& path, const std::vector<std::string>& texts) {
  const Quiet quiet;
  const hsize_t count = texts.size();
  const Id space(H5Screate_simple(1, &count, nullptr));
  write_dataset(file_, shared_->name, path, texts, space);
}

std::vector<std::string> Hdf5File::read_texts(const std::string& path) const {
  const Quiet quiet;
  const Id dataset(
      checked(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), shared_->name, "open " + path));
  const Id type(checked(H5Dget_type(dataset), shared_->name, "read the type of " + path));
  const Id space(checked(H5Dget_space(dataset), shared_->name, "read the shape of " + path));
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0)
    damaged(shared_->name, path + " does not hold strings");
  const auto count =
      static_cast<std::size_t>(std::max<hssize_t>(H5Sget_simple_extent_npoints(space), 0));
  const std::size_t length = H5Tget_size(type);
  if (static_cast<double>(count) * static_cast<double>(length) >
      static_cast<double>(this->length()))
    damaged(shared_->name, path + " claims to be larger than the file");
  std::string bytes(count * length, '\0');
  if (count > 0)
    checked(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), shared_->name,
            "read " + path);
  const std::vector<std::string> texts = split(bytes, length);
  for (const std::string& text : texts)
    if (!is_utf8(text)) damaged(shared_->name, path + " is not UTF-8");
  return texts;
}

std::string Hdf5File::read_text(const std::string& path) const {
  const std::vector<std::string> texts = read_texts(path);
  if (texts.size() != 1) damaged(shared_->name, path + " is not a single string");
  return texts[0];
}

}  // namespace loomstone
