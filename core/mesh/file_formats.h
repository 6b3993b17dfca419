// Shared by the readers and writers of mesh files; not for use outside mesh_file.cpp, obj_file.cpp,
// ply_file.cpp and ply_writer.cpp.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// A mesh as a file states it, not checked yet.
struct RawMesh {
  std::vector<double> vertices;     // x y z of each
  std::vector<double> uv;           // u v of each
  std::vector<Index> triangles;     // three vertices of each, counted from 0
  std::vector<Index> uv_triangles;  // three uv of each, or empty
};

// `name` is that of the file, for messages.
RawMesh parse_obj(std::string_view content, const std::string& name, bool with_uv);
RawMesh parse_ply(std::string_view content, const std::string& name, bool with_uv);
std::string obj_text(const TriangleMesh& mesh);
std::string ply_content(const TriangleMesh& mesh, bool text);

[[noreturn]] inline void throw_malformed(const std::string& name, std::int64_t line,
                                         const std::string& what) {
  throw CacheError(name + ", line " + std::to_string(line) + ": " + what +
                   "; correct the file or write it again");
}

// Takes lines off the front of a text and counts them from 1.
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

// Takes the next word off the front of a line; empty at its end.
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

// The whole word as a number, in any locale; false if it is none.
template <class Number>
bool parse_number(std::string_view word, Number& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const std::from_chars_result result =
      std::from_chars(word.data(), word.data() + word.size(), value);
  return result.ec == std::errc() && result.ptr == word.data() + word.size();
}

// Shortest text that reads back as the same number.
template <class Number>
void append_number(std::string& text, Number value) {
  char buffer[40];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

}  // namespace loomstone
