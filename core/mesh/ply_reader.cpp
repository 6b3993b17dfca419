// Reads Stanford PLY: a header that declares elements and their properties, then the values as text
// or binary.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>

#include "core/mesh/file_formats.h"

namespace loomstone {
namespace {

enum class Type { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

constexpr std::array<std::size_t, 8> bytes_of_type = {1, 1, 2, 2, 4, 4, 4, 8};

bool parse_type(std::string_view word, Type& type) {
  static constexpr std::array<std::pair<std::string_view, Type>, 16> names = {{
      {"char", Type::Int8},
      {"uchar", Type::UInt8},
      {"short", Type::Int16},
      {"ushort", Type::UInt16},
      {"int", Type::Int32},
      {"uint", Type::UInt32},
      {"float", Type::Float32},
      {"double", Type::Float64},
      {"int8", Type::Int8},
      {"uint8", Type::UInt8},
      {"int16", Type::Int16},
      {"uint16", Type::UInt16},
      {"int32", Type::Int32},
      {"uint32", Type::UInt32},
      {"float32", Type::Float32},
      {"float64", Type::Float64},
  }};
  for (const auto& [name, value] : names) {
    if (name == word) {
      type = value;
      return true;
    }
  }
  return false;
}

// What a property is for.
enum class Use { None, X, Y, Z, U, V, Corners, CornerUv };

Use use_of(std::string_view element, std::string_view property, bool list) {
  if (element == "vertex" && !list) {
    if (property == "x") return Use::X;
    if (property == "y") return Use::Y;
    if (property == "z") return Use::Z;
    if (property == "s" || property == "u" || property == "texture_u") return Use::U;
    if (property == "t" || property == "v" || property == "texture_v") return Use::V;
  }
  if (element == "face" && list) {
    if (property == "vertex_indices" || property == "vertex_index") return Use::Corners;
    if (property == "texcoord") return Use::CornerUv;
  }
  return Use::None;
}

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

enum class Encoding { Text, Little, Big };

class PlyParser {
 public:
  PlyParser(std::string_view content, const std::string& name, bool with_uv)
      : lines_(content), name_(name), with_uv_(with_uv) {}

  RawMesh parse() {
    header();
    body_ = lines_.rest();
    for (const Element& element : elements_) {
      element_ = &element;
      for (row_ = 0; row_ < element.count; ++row_) row(element);
    }
    finish();
    return std::move(raw_);
  }

 private:
  [[noreturn]] void malformed(const std::string& what) const {
    throw_malformed(name_, lines_.number(), what);
  }

  void header() {
    std::string_view line;
    if (!lines_.next(line) || line != "ply") malformed("a PLY file must begin with \"ply\"");
    bool has_format = false;
    while (lines_.next(line)) {
      const std::string whole(line);
      const std::string_view keyword = next_word(line);
      if (keyword == "end_header") {
        if (!has_format) malformed("the header must state a format, got none");
        check_header();
        return;
      }
      if (keyword == "format") {
        const std::string_view format = next_word(line);
        has_format = true;
        if (format == "ascii")
          encoding_ = Encoding::Text;
        else if (format == "binary_little_endian")
          encoding_ = Encoding::Little;
        else if (format == "binary_big_endian")
          encoding_ = Encoding::Big;
        else
          malformed("the format must be ascii, binary_little_endian or binary_big_endian, got \"" +
                    whole + "\"");
      } else if (keyword == "element") {
        Element element;
        element.name = next_word(line);
        if (!parse_number(next_word(line), element.count) || element.count < 0 ||
            element.count > std::numeric_limits<Index>::max()) {
          malformed("an element must have a name and a count below 2^31, got \"" + whole + "\"");
        }
        elements_.push_back(element);
      } else if (keyword == "property") {
        if (elements_.empty())
          malformed("a property must follow an element, got \"" + whole + "\"");
        property(line, whole);
      } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
        malformed("the header must consist of format, comment, element and property lines, got \"" +
                  whole + "\"");
      }
    }
    malformed("the header must end with end_header, got the end of the file");
  }

  void property(std::string_view line, const std::string& whole) {
    Property result{Use::None, false, Type::UInt8, Type::UInt8};
    std::string_view word = next_word(line);
    bool known = true;
    if (word == "list") {
      result.list = true;
      known = parse_type(next_word(line), result.count_type) && result.count_type < Type::Float32;
      word = next_word(line);
    }
    if (!known || !parse_type(word, result.type))
      malformed("a property must have a known type, got \"" + whole + "\"");
    result.use = use_of(elements_.back().name, next_word(line), result.list);
    if (result.use == Use::Corners && result.type >= Type::Float32) {
      malformed("vertex indices must be integers, got \"" + whole + "\"");
    }
    elements_.back().properties.push_back(result);
  }

  void check_header() {
    bool vertices = false, faces = false;
    for (const Element& element : elements_) {
      if (element.name == "vertex") {
        vertices = element.has(Use::X) && element.has(Use::Y) && element.has(Use::Z);
        vertex_uv_ = with_uv_ && element.has(Use::U) && element.has(Use::V);
      }
      if (element.name == "face") {
        faces = element.has(Use::Corners);
        corner_uv_ = with_uv_ && element.has(Use::CornerUv);
      }
    }
    if (!vertices) malformed("the header must declare element vertex with x, y and z, got none");
    if (!faces) malformed("the header must declare element face with vertex_indices, got none");
    if (corner_uv_) vertex_uv_ = false;
  }

  [[noreturn]] void cut_short() const {
    throw CacheError(name_ + ": the file ends in " + element_->name + " " + std::to_string(row_) +
                     " of " + std::to_string(element_->count) +
                     " (cut short); copy or write it again");
  }

  double text_value() {
    while (!body_.empty() && (body_.front() == ' ' || body_.front() == '\t' ||
                              body_.front() == '\n' || body_.front() == '\r')) {
      body_.remove_prefix(1);
    }
    if (body_.empty()) cut_short();
    const std::string_view word = body_.substr(0, body_.find_first_of(" \t\r\n"));
    double value = 0.0;
    if (!parse_number(word, value)) {
      throw CacheError(name_ + ", " + element_->name + " " + std::to_string(row_) +
                       ": a value must be a number, got \"" + std::string(word.substr(0, 40)) +
                       "\"; correct the file or write it again");
    }
    body_.remove_prefix(word.size());
    return value;
  }

  template <class Value>
  double binary_value() {
    if (body_.size() < sizeof(Value)) cut_short();
    std::array<char, sizeof(Value)> bytes;
    std::memcpy(bytes.data(), body_.data(), sizeof(Value));
    if ((encoding_ == Encoding::Big) != (std::endian::native == std::endian::big))
      std::reverse(bytes.begin(), bytes.end());
    body_.remove_prefix(sizeof(Value));
    return static_cast<double>(std::bit_cast<Value>(bytes));
  }

  // Every type fits in a double.
  double value(Type type) {
    if (encoding_ == Encoding::Text) return text_value();
    switch (type) {
      case Type::Int8:
        return binary_value<std::int8_t>();
      case Type::UInt8:
        return binary_value<std::uint8_t>();
      case Type::Int16:
        return binary_value<std::int16_t>();
      case Type::UInt16:
        return binary_value<std::uint16_t>();
      case Type::Int32:
        return binary_value<std::int32_t>();
      case Type::UInt32:
        return binary_value<std::uint32_t>();
      case Type::Float32:
        return binary_value<float>();
      case Type::Float64:
        break;
    }
    return binary_value<double>();
  }

  void row(const Element& element) {
    Vec3 position = Vec3::Zero();
    Vec2 uv = Vec2::Zero();
    corners_.clear();
    corner_values_.clear();
    for (const Property& property : element.properties) {
      if (property.list) {
        list(property);
        continue;
      }
      const double number = value(property.type);
      if (property.use == Use::X) position.x() = number;
      if (property.use == Use::Y) position.y() = number;
      if (property.use == Use::Z) position.z() = number;
      if (property.use == Use::U) uv.x() = number;
      if (property.use == Use::V) uv.y() = number;
    }
    if (element.name == "vertex") {
      raw_.vertices.insert(raw_.vertices.end(), {position.x(), position.y(), position.z()});
      if (vertex_uv_) raw_.uv.insert(raw_.uv.end(), {uv.x(), uv.y()});
    } else if (element.name == "face") {
      face();
    }
  }

  void list(const Property& property) {
    const double count = value(property.count_type);
    if (!(count >= 0.0) || count != std::floor(count) ||
        count > static_cast<double>(body_.size())) {
      malformed_row("a list must have a whole number of items that the file can hold, got " +
                    std::to_string(count));
    }
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(count); ++i) {
      const double number = value(property.type);
      if (property.use == Use::Corners) corners_.push_back(number);
      if (property.use == Use::CornerUv) corner_values_.push_back(number);
    }
  }

  [[noreturn]] void malformed_row(const std::string& what) const {
    throw CacheError(name_ + ", " + element_->name + " " + std::to_string(row_) + ": " + what +
                     "; correct the file or write it again");
  }

  void face() {
    if (corners_.size() < 3)
      malformed_row("a face must have at least 3 corners, got " + std::to_string(corners_.size()));
    if (corner_uv_ && corner_values_.size() != 2 * corners_.size()) {
      malformed_row("texcoord must have 2 numbers per corner, got " +
                    std::to_string(corner_values_.size()));
    }
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      for (const std::size_t c : {std::size_t{0}, k - 1, k}) {
        if (!(corners_[c] >= 0.0 && corners_[c] <= std::numeric_limits<Index>::max()) ||
            corners_[c] != std::floor(corners_[c])) {
          malformed_row("a corner must be the index of a vertex, got " +
                        std::to_string(corners_[c]));
        }
        const Index vertex = static_cast<Index>(corners_[c]);
        raw_.triangles.push_back(vertex);
        if (corner_uv_)
          raw_.uv_triangles.push_back(
              uv_of(vertex, corner_values_[2 * c], corner_values_[2 * c + 1]));
      }
    }
  }

  // Corners of one vertex with the same uv share it, so that panels stay connected.
  Index uv_of(Index vertex, double u, double v) {
    if (!std::isfinite(u) || !std::isfinite(v))
      malformed_row("texcoord must be finite, got NaN or infinity");
    const auto [entry, fresh] =
        known_uv_.try_emplace({vertex, u, v}, static_cast<Index>(raw_.uv.size() / 2));
    if (fresh) raw_.uv.insert(raw_.uv.end(), {u, v});
    return entry->second;
  }

  void finish() const {
    const std::size_t n_vertices = raw_.vertices.size() / 3;
    for (std::size_t i = 0; i < raw_.triangles.size(); ++i) {
      if (static_cast<std::size_t>(raw_.triangles[i]) >= n_vertices) {
        throw CacheError(name_ + ": a face refers to vertex " + std::to_string(raw_.triangles[i]) +
                         ", but the file has only " + std::to_string(n_vertices) +
                         "; correct the file or write it again");
      }
    }
  }

  LineReader lines_;
  const std::string& name_;
  bool with_uv_, vertex_uv_ = false, corner_uv_ = false;
  Encoding encoding_ = Encoding::Text;
  std::vector<Element> elements_;
  std::string_view body_;
  const Element* element_ = nullptr;  // being read, for messages
  std::int64_t row_ = 0;
  std::vector<double> corners_, corner_values_;
  std::map<std::tuple<Index, double, double>, Index> known_uv_;
  RawMesh raw_;
};

}  // namespace

RawMesh parse_ply(std::string_view content, const std::string& name, bool with_uv) {
  return PlyParser(content, name, with_uv).parse();
}

}  // namespace loomstone
