// The header of a Stanford PLY file: encoding, elements and their properties.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh/file_formats.h"

namespace loomstone::ply {

enum class Encoding { Text, Little, Big };

enum class Type { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

// The role of a property in a mesh.
enum class Use { None, X, Y, Z, U, V, Corners, CornerUv };

struct Property {
  Use use;
  bool list;
  Type count_type, type;
};

struct Element {
  std::string name;
  std::int64_t count;
  std::vector<Property> properties;

  bool has(Use use) const {
    return std::any_of(properties.begin(), properties.end(),
                       [use](const Property& each) { return each.use == use; });
  }
};

struct Header {
  Encoding encoding = Encoding::Text;
  std::vector<Element> elements;

  bool has_vertex_uv() const;
  bool has_corner_uv() const;
};

// Reads the header up to the line end_header. Throws CacheError with the line number if the header
// is malformed or does not declare vertices and faces.
Header read_header(LineReader& lines, const std::string& name);

}  // namespace loomstone::ply
