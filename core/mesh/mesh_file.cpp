#include "core/mesh/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/base/message.h"
#include "core/mesh/file_formats.h"
#include "core/mesh/polygons.h"

namespace loomstone {
namespace {

enum class Format { Obj, Ply };

Format format_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (ending == ".obj") return Format::Obj;
  if (ending == ".ply") return Format::Ply;
  fail<Unsupported>(
      "a mesh file must end in .obj or .ply, got {}; convert it, or read it in Python", path);
}

[[noreturn]] void throw_system(const std::string& path, const char* what) {
  fail<CacheError>("{} cannot be {}: {}; check the name and its permissions", path, what,
                   std::strerror(errno));
}

std::string whole_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw_system(path, "opened");
  if (std::filesystem::is_directory(path)) {
    errno = EISDIR;
    throw_system(path, "read");
  }
  const std::streamoff size = file.tellg();
  std::string content(static_cast<std::size_t>(std::max<std::streamoff>(size, 0)), '\0');
  file.seekg(0);
  if (!file.read(content.data(), size)) throw_system(path, "read");
  return content;
}

void check_colors(const std::string& path, Format format, const TriangleMesh& mesh,
                  const MeshColors& colors) {
  require(colors.vertices.empty() || format == Format::Ply,
          "{}: colours of vertices need a .ply file; give materials instead", path);
  require((colors.library.empty() && colors.materials.empty()) || format == Format::Obj,
          "{}: materials need an .obj file; give colours of vertices instead", path);
  require(
      colors.vertices.empty() || static_cast<Index>(colors.vertices.size()) == mesh.n_vertices(),
      "{}: colours must be given for each of the {} vertices, got {}", path, mesh.n_vertices(),
      colors.vertices.size());
  Index least = 0;
  for (const auto& [first, name] : colors.materials) {
    require(first >= least && first < mesh.n_triangles(),
            "{}: the first triangles of materials must ascend and be less than {}, got {} for {}",
            path, mesh.n_triangles(), first, name);
    least = first + 1;
  }
}

template <class Array, class Value>
Array as_rows(const std::vector<Value>& values) {
  return Eigen::Map<const Array>(
      values.data(), static_cast<Eigen::Index>(values.size()) / Array::ColsAtCompileTime,
      Array::ColsAtCompileTime);
}

// On entry, the triangles of each polygon are a fan about its first corner. Replaces them by those
// of split_polygon(), which differ only if triangles of the fan overlap or have no area. Throws
// CacheError if split_polygon() returns no triangles.
void split_concave(RawMesh& raw, const std::string& path) {
  for (const RawMesh::Polygon& polygon : raw.polygons) {
    // Returns the entries of `triangles` for the corners of the polygon, each corner once.
    const auto corners_in = [&](const std::vector<Index>& triangles) {
      const Index* const first = triangles.data() + 3 * polygon.first_triangle;
      std::vector<Index> corners{first[0], first[1]};
      for (std::size_t k = 2; k < polygon.n_corners; ++k) corners.push_back(first[3 * k - 4]);
      return corners;
    };
    const std::vector<Index> vertices = corners_in(raw.triangles);
    std::vector<Vec3> positions;
    for (const Index vertex : vertices)
      positions.push_back(Eigen::Map<const Vec3>(raw.vertices.data() + 3 * vertex));
    const std::vector<std::array<int, 3>> split = split_polygon(positions);
    if (split.empty())
      fail<CacheError>("{}, {} {}: the outline of a face must not cross itself; correct the file",
                       path, polygon.unit, polygon.number);
    const auto replace = [&](std::vector<Index>& triangles, const std::vector<Index>& corners) {
      for (std::size_t t = 0; t < split.size(); ++t)
        for (int k = 0; k < 3; ++k)
          triangles[3 * (polygon.first_triangle + t) + k] = corners[split[t][k]];
    };
    if (!raw.uv_triangles.empty()) replace(raw.uv_triangles, corners_in(raw.uv_triangles));
    replace(raw.triangles, vertices);
  }
}

}  // namespace

TriangleMesh read_mesh(const std::string& path, bool with_uv) {
  const Format format = format_of(path);
  const std::string content = whole_file(path);
  RawMesh raw =
      format == Format::Obj ? parse_obj(content, path, with_uv) : parse_ply(content, path, with_uv);
  split_concave(raw, path);
  try {
    return TriangleMesh(as_rows<Points>(raw.vertices), as_rows<Triangles>(raw.triangles),
                        as_rows<Points2>(raw.uv), as_rows<Triangles>(raw.uv_triangles));
  } catch (const InvalidInput& error) {
    fail<InvalidInput>("{}: {}", path, error.what());
  }
}

void write_mesh(const std::string& path, const TriangleMesh& mesh, bool text,
                const MeshColors& colors) {
  const Format format = format_of(path);
  check_colors(path, format, mesh, colors);
  const std::string content =
      format == Format::Obj ? obj_text(mesh, colors) : ply_content(mesh, text, colors);
  const std::string partial = path + ".partial";
  {
    std::ofstream file(partial, std::ios::binary | std::ios::trunc);
    if (!file) throw_system(partial, "opened");
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    file.flush();
    if (!file) {
      const int reason = errno;
      std::error_code ignored;
      std::filesystem::remove(partial, ignored);
      errno = reason;
      throw_system(partial, "written");
    }
  }
  if (std::rename(partial.c_str(), path.c_str()) != 0) {
    const int reason = errno;
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    errno = reason;
    throw_system(path, "replaced");
  }
}

}  // namespace loomstone
