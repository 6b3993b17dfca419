// Writes Stanford PLY files.
#include <algorithm>
#include <array>
#include <bit>

#include "core/mesh/file_formats.h"

namespace loomstone {
namespace {

// True if every vertex has exactly one uv, and the uv are in the order of the vertices.
bool uv_per_vertex(const TriangleMesh& mesh) {
  return mesh.has_uv() && mesh.uv().rows() == mesh.vertices().rows() &&
         mesh.uv_triangles() == mesh.triangles();
}

template <class Value>
void append_binary(std::string& content, Value value) {
  std::array<char, sizeof(Value)> bytes = std::bit_cast<std::array<char, sizeof(Value)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  content.append(bytes.data(), bytes.size());
}

// Appends values as text or as bytes.
class PlyWriter {
 public:
  PlyWriter(std::string& content, bool text) : content_(content), text_(text) {}

  template <class Value>
  void add(Value value) {
    if (!text_) return append_binary(content_, value);
    if (!first_) content_ += ' ';
    first_ = false;
    append_number(content_, value);
  }
  void end_row() {
    if (text_) content_ += '\n';
    first_ = true;
  }

 private:
  std::string& content_;
  bool text_, first_ = true;
};

}  // namespace

std::string ply_content(const TriangleMesh& mesh, bool text, const MeshColors& colors) {
  const bool vertex_uv = uv_per_vertex(mesh), corner_uv = mesh.has_uv() && !vertex_uv;
  std::string content = "ply\nformat " + std::string(text ? "ascii" : "binary_little_endian") +
                        " 1.0\ncomment written by loomstone; metres\nelement vertex " +
                        std::to_string(mesh.n_vertices()) +
                        "\nproperty double x\nproperty double y\nproperty double z\n";
  if (vertex_uv) content += "property double s\nproperty double t\n";
  if (!colors.vertices.empty())
    content += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  content += "element face " + std::to_string(mesh.n_triangles()) +
             "\nproperty list uchar int vertex_indices\n";
  if (corner_uv) content += "property list uchar double texcoord\n";
  content += "end_header\n";
  PlyWriter writer(content, text);
  for (Index i = 0; i < mesh.n_vertices(); ++i) {
    for (int c = 0; c < 3; ++c) writer.add(mesh.vertices()(i, c));
    if (vertex_uv) {
      for (int c = 0; c < 2; ++c) writer.add(mesh.uv()(i, c));
    }
    if (!colors.vertices.empty())
      for (const std::uint8_t channel : colors.vertices[static_cast<std::size_t>(i)])
        writer.add(channel);
    writer.end_row();
  }
  for (Index t = 0; t < mesh.n_triangles(); ++t) {
    writer.add(std::uint8_t{3});
    for (int c = 0; c < 3; ++c) writer.add(mesh.triangles()(t, c));
    if (corner_uv) {
      writer.add(std::uint8_t{6});
      for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < 2; ++k) writer.add(mesh.uv()(mesh.uv_triangles()(t, c), k));
      }
    }
    writer.end_row();
  }
  return content;
}

}  // namespace loomstone
