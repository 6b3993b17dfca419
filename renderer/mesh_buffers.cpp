// Splits vertices, computes shading normals, and uploads the buffers.
#include "renderer/mesh_buffers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <tuple>

#include "core/base/sort_unique.h"

namespace loomstone {
namespace {

constexpr int floats_per_vertex = 10;  // position 3, normal 3, uv 2, values 2

// Returns the rows of the triangles, ordered by part. `first_of_part` receives n_parts + 1 values:
// the place in this list where each part starts, then the length of the list. Parts that `keep`
// rejects have no rows.
template <class Keep>
std::vector<Index> rows_by_part(const std::vector<Index>& part_of_triangle, Index n_parts,
                                Keep keep, std::vector<Index>& first_of_part) {
  first_of_part.assign(n_parts + 1, 0);
  for (Index part : part_of_triangle)
    if (keep(part)) ++first_of_part[part + 1];
  std::partial_sum(first_of_part.begin(), first_of_part.end(), first_of_part.begin());
  std::vector<Index> rows(first_of_part.back());
  std::vector<Index> next(first_of_part.begin(), first_of_part.end() - 1);
  for (Index row = 0; row < static_cast<Index>(part_of_triangle.size()); ++row)
    if (keep(part_of_triangle[row])) rows[next[part_of_triangle[row]]++] = row;
  return rows;
}

Vec3 unit_or(const Vec3& a, const Vec3& otherwise) {
  const double length = a.norm();
  return length > 0.0 ? Vec3(a / length) : otherwise;
}

// Disjoint sets (union-find) of triangle corners. Corners at the same vertex are joined across
// edges that are not sharp.
class CornerGroups {
 public:
  explicit CornerGroups(Index n_corners) : parent_(n_corners) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  Index root(Index corner) {
    while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
    return corner;
  }
  void join(Index a, Index b) { parent_[std::max(root(a), root(b))] = std::min(root(a), root(b)); }

 private:
  std::vector<Index> parent_;
};

}  // namespace

DrawnMesh drawn_cloth(const FrameTopology& topology) {
  DrawnMesh mesh;
  const Index n_cloths = static_cast<Index>(topology.cloth_names.size());
  const std::vector<Index> rows = rows_by_part(
      topology.cloth_of_triangle, n_cloths, [](Index) { return true; }, mesh.first_of_part);
  std::map<std::tuple<Index, double, double>, Index> drawn;
  mesh.triangles.resize(static_cast<Index>(rows.size()), 3);
  for (Index i = 0; i < mesh.triangles.rows(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      const Index vertex = topology.triangles(rows[i], corner);
      const Vec2 uv = topology.corner_uv.row(3 * rows[i] + corner);
      const auto [place, fresh] =
          drawn.try_emplace({vertex, uv.x(), uv.y()}, static_cast<Index>(mesh.vertex.size()));
      if (fresh) {
        mesh.vertex.push_back(vertex);
        mesh.uv.push_back(uv.cast<float>());
      }
      mesh.triangles(i, corner) = place->second;
    }
  }
  mesh.normal_group = mesh.vertex;
  mesh.n_groups = static_cast<Index>(topology.cloth_of_vertex.size());
  return mesh;
}

DrawnMesh drawn_bodies(const FrameTopology& topology, const Points& x, double crease_degrees) {
  DrawnMesh mesh;
  const Index n_bodies = static_cast<Index>(topology.body_names.size());
  const std::vector<Index> rows = rows_by_part(
      topology.body_of_triangle, n_bodies,
      [&](Index body) { return !topology.body_is_floor[body]; }, mesh.first_of_part);
  const Index n = static_cast<Index>(rows.size());

  const double cosine = std::cos(crease_degrees * 3.14159265358979323846 / 180.0);
  Points normal(n, 3);
  // For each edge, the place in `rows` of the first triangle that contains it, and the corner of
  // this triangle at which the edge starts.
  std::map<std::pair<Index, Index>, std::pair<Index, int>> edge_seen;
  CornerGroups groups(3 * n);
  for (Index i = 0; i < n; ++i) {
    const auto triangle = topology.body_triangles.row(rows[i]);
    const Vec3 a = x.row(triangle[0]), b = x.row(triangle[1]), c = x.row(triangle[2]);
    normal.row(i) = unit_or((b - a).cross(c - a), Vec3::UnitZ());
    for (int corner = 0; corner < 3; ++corner) {
      const Index from = triangle[corner], to = triangle[(corner + 1) % 3];
      const auto [place, fresh] = edge_seen.try_emplace(std::minmax(from, to), i, corner);
      if (fresh) continue;
      const auto [other, other_corner] = place->second;
      if (normal.row(i).dot(normal.row(other)) < cosine) continue;
      const Index other_from = 3 * other + other_corner,
                  other_to = 3 * other + (other_corner + 1) % 3;
      const bool same_way = topology.body_triangles(rows[other], other_corner) == from;
      groups.join(3 * i + corner, same_way ? other_from : other_to);
      groups.join(3 * i + (corner + 1) % 3, same_way ? other_to : other_from);
    }
  }

  std::map<Index, Index> group_of_root;  // root of a group of corners -> normal group
  std::map<std::tuple<Index, double, double>, Index> drawn;  // normal group and uv -> drawn vertex
  mesh.triangles.resize(n, 3);
  for (Index i = 0; i < n; ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      const Index group =
          group_of_root.try_emplace(groups.root(3 * i + corner), mesh.n_groups).first->second;
      mesh.n_groups = std::max(mesh.n_groups, group + 1);
      Vec2 uv = Vec2::Zero();
      if (topology.body_corner_uv.rows() > 0)
        uv = topology.body_corner_uv.row(3 * rows[i] + corner);
      const auto [place, fresh] =
          drawn.try_emplace({group, uv.x(), uv.y()}, static_cast<Index>(mesh.vertex.size()));
      if (fresh) {
        mesh.vertex.push_back(topology.body_triangles(rows[i], corner));
        mesh.normal_group.push_back(group);
        mesh.uv.push_back(uv.cast<float>());
      }
      mesh.triangles(i, corner) = place->second;
    }
  }
  return mesh;
}

Points shading_normals(const DrawnMesh& mesh, const Points& positions) {
  Points sum = Points::Zero(mesh.n_groups, 3);
  for (Index i = 0; i < mesh.triangles.rows(); ++i) {
    Vec3 side[3];
    for (int corner = 0; corner < 3; ++corner) {
      const Index from = mesh.vertex[mesh.triangles(i, corner)],
                  to = mesh.vertex[mesh.triangles(i, (corner + 1) % 3)];
      side[corner] = positions.row(to) - positions.row(from);
    }
    const Vec3 normal = unit_or(side[0].cross(side[1]), Vec3::Zero());
    for (int corner = 0; corner < 3; ++corner) {
      const Vec3& ahead = side[corner];
      const Vec3& behind = side[(corner + 2) % 3];
      const double angle = std::atan2(ahead.cross(behind).norm(), -ahead.dot(behind));
      sum.row(mesh.normal_group[mesh.triangles(i, corner)]) += angle * normal;
    }
  }
  Points normals(static_cast<Index>(mesh.vertex.size()), 3);
  for (Index k = 0; k < normals.rows(); ++k)
    normals.row(k) = unit_or(sum.row(mesh.normal_group[k]), Vec3::UnitZ());
  return normals;
}

namespace {

void describe_vertices(const GL& gl) {
  const GLsizei stride = floats_per_vertex * sizeof(float);
  const int sizes[] = {3, 3, 2, 1, 1};
  std::size_t offset = 0;
  for (GLuint attribute = 0; attribute < 5; ++attribute) {
    gl.EnableVertexAttribArray(attribute);
    gl.VertexAttribPointer(attribute, sizes[attribute], GL_FLOAT, GL_FALSE, stride,
                           reinterpret_cast<const void*>(offset));
    offset += sizes[attribute] * sizeof(float);
  }
}

}  // namespace

MeshBuffers::MeshBuffers(const GL& gl, const DrawnMesh& mesh, bool with_edges)
    : gl_(&gl),
      mesh_(mesh),
      vertex_array_(make_vertex_array(gl)),
      vertices_(make_buffer(gl)),
      indices_(make_buffer(gl)),
      edges_(make_buffer(gl)) {
  gl.BindVertexArray(vertex_array_.name());
  gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  describe_vertices(gl);
  if (with_edges) {
    std::vector<std::pair<Index, Index>> edges;
    for (Index i = 0; i < mesh.triangles.rows(); ++i)
      for (int corner = 0; corner < 3; ++corner)
        edges.push_back(
            std::minmax({mesh.triangles(i, corner), mesh.triangles(i, (corner + 1) % 3)}));
    sort_unique(edges);
    n_edge_indices_ = static_cast<GLsizei>(2 * edges.size());
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, edges_.name());
    gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(edges.size() * sizeof(edges[0])),
                  edges.data(), GL_STATIC_DRAW);
  }
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(Index)),
                mesh.triangles.data(), GL_STATIC_DRAW);
}

void MeshBuffers::update(const Points& positions, const Vector& values, const Vector& others) {
  const Points normals = shading_normals(mesh_, positions);
  floats_.resize(mesh_.vertex.size() * floats_per_vertex);
  float* out = floats_.data();
  for (std::size_t k = 0; k < mesh_.vertex.size(); ++k, out += floats_per_vertex) {
    const Index vertex = mesh_.vertex[k];
    for (int i = 0; i < 3; ++i) {
      out[i] = static_cast<float>(positions(vertex, i));
      out[3 + i] = static_cast<float>(normals(static_cast<Index>(k), i));
    }
    out[6] = mesh_.uv[k].x();
    out[7] = mesh_.uv[k].y();
    out[8] = values.size() > 0 ? static_cast<float>(values[vertex]) : 0.0f;
    out[9] = others.size() > 0 ? static_cast<float>(others[vertex]) : 0.0f;
  }
  gl_->BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(floats_.size() * sizeof(float)),
                  floats_.data(), GL_STREAM_DRAW);
}

void MeshBuffers::draw() const {
  if (mesh_.triangles.rows() == 0) return;
  gl_->BindVertexArray(vertex_array_.name());
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  gl_->DrawElements(GL_TRIANGLES, static_cast<GLsizei>(mesh_.triangles.size()), GL_UNSIGNED_INT,
                    nullptr);
}

void MeshBuffers::draw_part(Index part) const {
  const Index first = mesh_.first_of_part[part], count = mesh_.first_of_part[part + 1] - first;
  if (count == 0) return;
  gl_->BindVertexArray(vertex_array_.name());
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  gl_->DrawElements(
      GL_TRIANGLES, 3 * count, GL_UNSIGNED_INT,
      reinterpret_cast<const void*>(static_cast<std::size_t>(first) * 3 * sizeof(Index)));
}

void MeshBuffers::draw_edges() const {
  if (n_edge_indices_ == 0) return;
  gl_->BindVertexArray(vertex_array_.name());
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, edges_.name());
  gl_->DrawElements(GL_LINES, n_edge_indices_, GL_UNSIGNED_INT, nullptr);
}

SquareBuffers::SquareBuffers(const GL& gl)
    : gl_(&gl), vertex_array_(make_vertex_array(gl)), vertices_(make_buffer(gl)) {
  gl.BindVertexArray(vertex_array_.name());
  gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  describe_vertices(gl);
}

void SquareBuffers::update(const Vec3& centre, const Vec3& side_a, const Vec3& side_b,
                           const Vec3& normal) {
  std::vector<float> floats;
  for (const auto& [a, b] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {-1.0, 1.0}, {1.0, 1.0}}) {
    const Vec3 corner = centre + a * side_a + b * side_b;
    for (double value :
         {corner.x(), corner.y(), corner.z(), normal.x(), normal.y(), normal.z(), a, b, 0.0, 0.0})
      floats.push_back(static_cast<float>(value));
  }
  gl_->BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(floats.size() * sizeof(float)),
                  floats.data(), GL_STREAM_DRAW);
}

void SquareBuffers::draw() const {
  gl_->BindVertexArray(vertex_array_.name());
  gl_->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

}  // namespace loomstone
