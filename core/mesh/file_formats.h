// Internal header of the readers and writers of mesh files: mesh_file.cpp, obj_file.cpp,
// ply_header.cpp, ply_reader.cpp and ply_writer.cpp.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/message.h"
#include "core/mesh/mesh_file.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// A mesh as read from a file, not validated.
struct RawMesh {
  // A face with more than three corners. The parsers split it into the triangles {0, k - 1, k} of
  // its corners, for k from 2 to n_corners - 1.
  struct Polygon {
    std::size_t first_triangle, n_corners;
    const char* unit;  // "line" or "face": what `number` counts in the file
    std::int64_t number;
  };
  std::vector<double> vertices;     // (n x 3)
  std::vector<double> uv;           // (k x 2)
  std::vector<Index> triangles;     // (m x 3) vertex indices from 0
  std::vector<Index> uv_triangles;  // (m x 3) rows of uv, or empty
  std::vector<Polygon> polygons;
};

// The readers parse the content of a file; `name` is the name of the file in messages. The writers
// return the content of a file.
RawMesh parse_obj(std::string_view content, const std::string& name, bool with_uv);
RawMesh parse_ply(std::string_view content, const std::string& name, bool with_uv);
std::string obj_text(const TriangleMesh& mesh, const MeshColors& colors);
std::string ply_content(const TriangleMesh& mesh, bool text, const MeshColors& colors);

[[noreturn]] inline void throw_malformed(const std::string& name, std::int64_t line,
                                         const std::string& what) {
  fail<CacheError>("{}, line {}: {}; correct the file or write it again", name, line, what);
}

// Splits a text into lines, numbered from 1.
class LineReader {
 public:
  explicit LineReader(std::string_view content) : rest_(content) {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  std::int64_t number() const { return number_; }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  std::int64_t number_ = 0;
};

// Removes the first word from `line` and returns it. Returns an empty word if `line` contains none.
// Words are separated by spaces or tabs.
inline std::string_view next_word(std::string_view& line) {
  const std::size_t start = line.find_first_not_of(" \t");
  if (start == std::string_view::npos) {
    line = {};
    return {};
  }
  line.remove_prefix(start);
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

// Parses the whole word as a number, independently of the locale. Returns false if it is not a
// number of this type.
template <class Number>
bool parse_number(std::string_view word, Number& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const std::from_chars_result result =
      std::from_chars(word.data(), word.data() + word.size(), value);
  return result.ec == std::errc() && result.ptr == word.data() + word.size();
}

// Appends the shortest decimal representation from which the number can be restored exactly.
template <class Number>
void append_number(std::string& text, Number value) {
  char buffer[40];
  const char* end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(std::string_view(buffer, end));
}

}  // namespace loomstone
