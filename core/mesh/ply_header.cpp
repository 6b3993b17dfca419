#include "core/mesh/ply_header.h"

#include <array>
#include <limits>
#include <utility>

namespace loomstone::ply {

namespace {

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

class HeaderParser {
 public:
  HeaderParser(LineReader& lines, const std::string& name) : lines_(lines), name_(name) {}

  Header parse() {
    std::string_view line;
    if (!lines_.next(line) || line != "ply") malformed("a PLY file must begin with \"ply\"");
    while (lines_.next(line)) {
      const std::string whole(line);
      const std::string_view keyword = next_word(line);
      if (keyword == "end_header") {
        check();
        return std::move(header_);
      }
      if (keyword == "format")
        format(next_word(line), whole);
      else if (keyword == "element")
        element(line, whole);
      else if (keyword == "property")
        property(line, whole);
      else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info")
        malformed("the header must consist of format, comment, element and property lines, got \"" +
                  whole + "\"");
    }
    malformed("the header must end with end_header, got the end of the file");
  }

 private:
  [[noreturn]] void malformed(const std::string& what) const {
    throw_malformed(name_, lines_.number(), what);
  }

  void format(std::string_view word, const std::string& line) {
    has_format_ = true;
    if (word == "ascii")
      header_.encoding = Encoding::Text;
    else if (word == "binary_little_endian")
      header_.encoding = Encoding::Little;
    else if (word == "binary_big_endian")
      header_.encoding = Encoding::Big;
    else
      malformed("the format must be ascii, binary_little_endian or binary_big_endian, got \"" +
                line + "\"");
  }

  void element(std::string_view words, const std::string& line) {
    Element element;
    element.name = next_word(words);
    if (!parse_number(next_word(words), element.count) || element.count < 0 ||
        element.count > std::numeric_limits<Index>::max())
      malformed("an element must have a name and a count below 2^31, got \"" + line + "\"");
    header_.elements.push_back(element);
  }

  void property(std::string_view words, const std::string& line) {
    if (header_.elements.empty())
      malformed("a property must follow an element, got \"" + line + "\"");
    Property result{Use::None, false, Type::UInt8, Type::UInt8};
    std::string_view word = next_word(words);
    bool known = true;
    if (word == "list") {
      result.list = true;
      known = parse_type(next_word(words), result.count_type) && result.count_type < Type::Float32;
      word = next_word(words);
    }
    if (!known || !parse_type(word, result.type))
      malformed("a property must have a known type, got \"" + line + "\"");
    result.use = use_of(header_.elements.back().name, next_word(words), result.list);
    if (result.use == Use::Corners && result.type >= Type::Float32)
      malformed("vertex indices must be integers, got \"" + line + "\"");
    header_.elements.back().properties.push_back(result);
  }

  void check() const {
    if (!has_format_) malformed("the header must state a format, got none");
    bool vertices = false, faces = false;
    for (const Element& element : header_.elements) {
      if (element.name == "vertex")
        vertices = element.has(Use::X) && element.has(Use::Y) && element.has(Use::Z);
      if (element.name == "face") faces = element.has(Use::Corners);
    }
    if (!vertices) malformed("the header must declare element vertex with x, y and z, got none");
    if (!faces) malformed("the header must declare element face with vertex_indices, got none");
  }

  LineReader& lines_;
  const std::string& name_;
  bool has_format_ = false;
  Header header_;
};

}  // namespace

// If several elements have the same name, the last one determines the results of has_vertex_uv()
// and has_corner_uv().
bool Header::has_vertex_uv() const {
  bool has = false;
  for (const Element& element : elements)
    if (element.name == "vertex") has = element.has(Use::U) && element.has(Use::V);
  return has;
}

bool Header::has_corner_uv() const {
  bool has = false;
  for (const Element& element : elements)
    if (element.name == "face") has = element.has(Use::CornerUv);
  return has;
}

Header read_header(LineReader& lines, const std::string& name) {
  return HeaderParser(lines, name).parse();
}

}  // namespace loomstone::ply
