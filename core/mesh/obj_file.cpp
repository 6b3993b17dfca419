// Wavefront OBJ files. The reader uses the statements v, vt and f, and skips all others (normals,
// groups, materials, lines, curves).
#include <algorithm>
#include <limits>

#include "core/mesh/file_formats.h"

namespace loomstone {
namespace {

// Indices of a corner, counted from 0; -1 if an index is not given.
struct Corner {
  std::int64_t vertex = -1, uv = -1;
};

class ObjParser {
 public:
  ObjParser(std::string_view content, const std::string& name, bool with_uv)
      : lines_(content), name_(name), with_uv_(with_uv) {}

  RawMesh parse() {
    std::string_view line;
    while (lines_.next(line)) {
      line_ = lines_.number();
      while (!line.empty() && line.back() == '\\') append_continuation(line);
      std::string_view rest = line;
      const std::string_view keyword = next_word(rest);
      if (keyword == "v") {
        numbers(rest, 3, raw_.vertices);
      } else if (keyword == "vt" && with_uv_) {
        numbers(rest, 2, raw_.uv);
      } else if (keyword == "f") {
        face(rest);
      }
    }
    finish();
    return std::move(raw_);
  }

 private:
  // A backslash at the end of a line joins this line with the next line.
  void append_continuation(std::string_view& line) {
    std::string joined(line.substr(0, line.size() - 1));
    std::string_view next;
    if (lines_.next(next)) joined.append(" ").append(next);
    joined_ = std::move(joined);
    line = joined_;
  }

  void numbers(std::string_view rest, int count, std::vector<double>& values) {
    for (int i = 0; i < count; ++i) {
      const std::string_view word = next_word(rest);
      double value = 0.0;
      if (!parse_number(word, value)) {
        throw_malformed(name_, line_,
                        formatted("a {} must have {} numbers, got \"{}\" as number {}",
                                  count == 3 ? "vertex" : "vt", count, word, i + 1));
      }
      values.push_back(value);
    }
  }

  // Returns an index counted from 0. In the file, positive indices count from 1, and negative
  // indices count back from the most recently read item, which is -1.
  std::int64_t index(std::string_view word, std::string_view part, std::size_t n_so_far) const {
    std::int64_t value = 0;
    if (!parse_number(part, value) || value == 0 || value > std::numeric_limits<Index>::max() ||
        (value < 0 && -value > static_cast<std::int64_t>(n_so_far))) {
      throw_malformed(
          name_, line_,
          formatted("a corner must be v, v/vt, v//vn or v/vt/vn with indices from 1 (or "
                    "back from -1), got \"{}\"",
                    word));
    }
    return value > 0 ? value - 1 : static_cast<std::int64_t>(n_so_far) + value;
  }

  Corner corner(std::string_view word) const {
    const std::size_t slash = word.find('/');
    Corner result;
    result.vertex = index(word, word.substr(0, slash), raw_.vertices.size() / 3);
    if (slash == std::string_view::npos || !with_uv_) return result;
    const std::string_view after = word.substr(slash + 1);
    const std::string_view part = after.substr(0, after.find('/'));
    if (!part.empty()) result.uv = index(word, part, raw_.uv.size() / 2);
    return result;
  }

  void face(std::string_view rest) {
    corners_.clear();
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      if (word.front() == '#') break;
      corners_.push_back(corner(word));
    }
    if (corners_.size() < 3) {
      throw_malformed(name_, line_,
                      formatted("a face must have at least 3 corners, got {}", corners_.size()));
    }
    const bool has_uv = corners_[0].uv >= 0;
    for (const Corner& each : corners_) {
      if ((each.uv >= 0) != has_uv ||
          (!lines_of_triangles_.empty() && has_uv != !raw_.uv_triangles.empty())) {
        throw_malformed(name_, line_,
                        "either all corners must have a vt or none, got both kinds (with_uv=False "
                        "ignores them)");
      }
    }
    if (corners_.size() > 3)
      raw_.polygons.push_back({lines_of_triangles_.size(), corners_.size(), "line", line_});
    for (std::size_t k = 2; k < corners_.size(); ++k) {
      for (const std::size_t c : {std::size_t{0}, k - 1, k}) {
        raw_.triangles.push_back(static_cast<Index>(corners_[c].vertex));
        if (has_uv) raw_.uv_triangles.push_back(static_cast<Index>(corners_[c].uv));
      }
      lines_of_triangles_.push_back(line_);
    }
  }

  // Faces may precede the vertices that they use, so index ranges are checked at the end.
  void finish() {
    check_range(raw_.triangles, raw_.vertices.size() / 3, "v");
    check_range(raw_.uv_triangles, raw_.uv.size() / 2, "vt");
    if (raw_.uv_triangles.empty()) raw_.uv.clear();
  }

  void check_range(const std::vector<Index>& indices, std::size_t count, const char* what) const {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (static_cast<std::size_t>(indices[i]) >= count) {
        throw_malformed(
            name_, lines_of_triangles_[i / 3],
            formatted("a face refers to {} {}, but the file has only {} (is it cut short?)", what,
                      indices[i] + std::int64_t{1}, count));
      }
    }
  }

  LineReader lines_;
  const std::string& name_;
  bool with_uv_;
  std::int64_t line_ = 0;
  std::string joined_;
  RawMesh raw_;
  std::vector<Corner> corners_;
  std::vector<std::int64_t> lines_of_triangles_;
};

}  // namespace

RawMesh parse_obj(std::string_view content, const std::string& name, bool with_uv) {
  if (content.starts_with("\xEF\xBB\xBF")) content.remove_prefix(3);  // byte-order mark
  return ObjParser(content, name, with_uv).parse();
}

std::string obj_text(const TriangleMesh& mesh, const MeshColors& colors) {
  std::string text = "# written by loomstone; metres\n";
  if (!colors.library.empty()) text += "mtllib " + colors.library + "\n";
  const auto rows = [&text](const char* keyword, const auto& values) {
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      text += keyword;
      for (Eigen::Index c = 0; c < values.cols(); ++c) {
        text += ' ';
        append_number(text, values(i, c));
      }
      text += '\n';
    }
  };
  rows("v", mesh.vertices());
  rows("vt", mesh.uv());
  auto material = colors.materials.begin();
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    if (material != colors.materials.end() && material->first == t)
      text += "usemtl " + (material++)->second + "\n";
    text += 'f';
    for (int c = 0; c < 3; ++c) {
      text += ' ';
      append_number(text, mesh.triangles()(t, c) + 1);
      if (!mesh.has_uv()) continue;
      text += '/';
      append_number(text, mesh.uv_triangles()(t, c) + 1);
    }
    text += '\n';
  }
  return text;
}

}  // namespace loomstone
