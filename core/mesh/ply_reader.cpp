// Reads the values of a Stanford PLY file, text or binary, as its header declares them.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>

#include "core/mesh/file_formats.h"
#include "core/mesh/ply_header.h"

namespace loomstone {
namespace {

using ply::Element, ply::Encoding, ply::Property, ply::Type, ply::Use;

class PlyParser {
 public:
  PlyParser(std::string_view content, const std::string& name, bool with_uv)
      : content_(content), name_(name), with_uv_(with_uv) {}

  RawMesh parse() {
    LineReader lines(content_);
    const ply::Header header = ply::read_header(lines, name_);
    encoding_ = header.encoding;
    corner_uv_ = with_uv_ && header.has_corner_uv();
    vertex_uv_ = with_uv_ && header.has_vertex_uv() && !corner_uv_;
    body_ = lines.rest();
    for (const Element& element : header.elements) {
      element_ = &element;
      for (row_ = 0; row_ < element.count; ++row_) row(element);
    }
    finish();
    return std::move(raw_);
  }

 private:
  [[noreturn]] void cut_short() const {
    fail<CacheError>("{}: the file ends in {} {} of {} (cut short); copy or write it again", name_,
                     element_->name, row_, element_->count);
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
      malformed_row(formatted("a value must be a number, got \"{}\"", word.substr(0, 40)));
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

  // Reads a value of any type. A double can represent all values of all types of PLY exactly.
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
      malformed_row(formatted(
          "a list must have a whole number of items that the file can hold, got {}", count));
    }
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(count); ++i) {
      const double number = value(property.type);
      if (property.use == Use::Corners) corners_.push_back(number);
      if (property.use == Use::CornerUv) corner_values_.push_back(number);
    }
  }

  [[noreturn]] void malformed_row(const std::string& what) const {
    fail<CacheError>("{}, {} {}: {}; correct the file or write it again", name_, element_->name,
                     row_, what);
  }

  void face() {
    if (corners_.size() < 3)
      malformed_row(formatted("a face must have at least 3 corners, got {}", corners_.size()));
    if (corner_uv_ && corner_values_.size() != 2 * corners_.size()) {
      malformed_row(
          formatted("texcoord must have 2 numbers per corner, got {}", corner_values_.size()));
    }
    if (corners_.size() > 3)
      raw_.polygons.push_back({raw_.triangles.size() / 3, corners_.size(), "face", row_});
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      for (const std::size_t c : {std::size_t{0}, k - 1, k}) {
        if (!(corners_[c] >= 0.0 && corners_[c] <= std::numeric_limits<Index>::max()) ||
            corners_[c] != std::floor(corners_[c])) {
          malformed_row(formatted("a corner must be the index of a vertex, got {}", corners_[c]));
        }
        const Index vertex = static_cast<Index>(corners_[c]);
        raw_.triangles.push_back(vertex);
        if (corner_uv_)
          raw_.uv_triangles.push_back(
              uv_of(vertex, corner_values_[2 * c], corner_values_[2 * c + 1]));
      }
    }
  }

  // Returns the row of uv for a corner. Corners with the same vertex and the same uv share a row.
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
        fail<CacheError>(
            "{}: a face refers to vertex {}, but the file has only {}; correct the file or write "
            "it again",
            name_, raw_.triangles[i], n_vertices);
      }
    }
  }

  std::string_view content_;
  const std::string& name_;
  bool with_uv_, vertex_uv_ = false, corner_uv_ = false;
  Encoding encoding_ = Encoding::Text;
  std::string_view body_;             // remaining input
  const Element* element_ = nullptr;  // current element, for messages
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
