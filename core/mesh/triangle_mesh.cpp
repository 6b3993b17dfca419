#include "core/mesh/triangle_mesh.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/message.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/mesh_check.h"

namespace loomstone {
namespace {

// A plane through a point, with a unit normal.
struct Plane {
  Vec3 point, normal;
  double size;  // largest distance between the point and a vertex [m]
};

// Returns the plane through vertex 0, the vertex farthest from vertex 0, and the vertex farthest
// from the line through these two. For flat meshes, the plane is exact up to rounding.
Plane widest_plane(const Points& vertices) {
  const Vec3 origin = vertices.row(0).transpose();
  Vec3 along = Vec3::Zero(), across = Vec3::Zero();
  for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
    const Vec3 offset = vertices.row(i).transpose() - origin;
    if (offset.squaredNorm() > along.squaredNorm()) along = offset;
  }
  for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
    const Vec3 normal = along.cross(vertices.row(i).transpose() - origin);
    if (normal.squaredNorm() > across.squaredNorm()) across = normal;
  }
  return {origin, across.normalized(), along.norm()};
}

void check_permutation(const std::vector<Index>& order, Index count, const char* what) {
  std::vector<char> seen(static_cast<std::size_t>(count), 0);
  if (order.size() != seen.size())
    fail<InvalidInput>("{} must be a permutation of {} indices, got {} entries", what, count,
                       order.size());
  for (const Index entry : order) {
    if (entry < 0 || entry >= count || seen[static_cast<std::size_t>(entry)])
      fail<InvalidInput>(
          "{} must be a permutation that holds each index in [0, {}) once, got {}, which is {}",
          what, count, entry, entry < 0 || entry >= count ? "out of range" : "repeated");
    seen[static_cast<std::size_t>(entry)] = 1;
  }
}

Vec3 corner(const TriangleMesh& mesh, Index t, int c) {
  return mesh.vertices().row(mesh.triangles()(t, c)).transpose();
}

Vec3 unit_normal(const TriangleMesh& mesh, Index t) {
  return (corner(mesh, t, 1) - corner(mesh, t, 0))
      .cross(corner(mesh, t, 2) - corner(mesh, t, 0))
      .normalized();
}

// Returns the coordinates of the corners along the weft and warp directions, relative to `origin`.
// Warp is weft rotated by 90 degrees about the triangle's normal, so the area is positive.
Corners2 flattened(const TriangleMesh& mesh, Index t, const Vec3& weft, const Vec3& origin) {
  const Vec3 warp = unit_normal(mesh, t).cross(weft);
  Corners2 result;
  for (int c = 0; c < 3; ++c) {
    const Vec3 offset = corner(mesh, t, c) - origin;
    result.row(c) << offset.dot(weft), offset.dot(warp);
  }
  return result;
}

// Returns the uv of the corners. In a mirrored triangle, u changes sign, so that the area is
// positive.
Corners2 corners_of_uv(const TriangleMesh& mesh, Index t) {
  Corners2 result;
  for (int c = 0; c < 3; ++c) result.row(c) = mesh.uv().row(mesh.uv_triangles()(t, c));
  const Vec2 a = result.row(1) - result.row(0), b = result.row(2) - result.row(0);
  if (a.x() * b.y() - a.y() * b.x() < 0.0) result.col(0) *= -1.0;
  return result;
}

// Returns the direction of the weft threads in space, along which the u coordinate of `rest`
// increases at constant v.
Vec3 weft_direction(const TriangleMesh& mesh, Index t, const Corners2& rest) {
  const Vec2 a = rest.row(1) - rest.row(0), b = rest.row(2) - rest.row(0);
  const Vec3 x1 = corner(mesh, t, 1) - corner(mesh, t, 0),
             x2 = corner(mesh, t, 2) - corner(mesh, t, 0);
  // The vector in parentheses is dx/du times the determinant of (a, b). This determinant is
  // positive, because rest coordinates have positive areas.
  return (x1 * b.y() - x2 * a.y()).normalized();
}

}  // namespace

TriangleMesh::TriangleMesh(Points vertices, Triangles triangles, Points2 uv, Triangles uv_triangles)
    : vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      uv_(std::move(uv)),
      uv_triangles_(std::move(uv_triangles)) {
  check_surface(vertices_, triangles_);
  if (!has_uv()) {
    if (uv_triangles_.rows() > 0) {
      fail<InvalidInput>(
          "uv_triangles must come with uv, got {} rows and no uv; give both or neither",
          uv_triangles_.rows());
    }
    return;
  }
  if (uv_triangles_.rows() == 0) {
    if (uv_.rows() != vertices_.rows()) {
      fail<InvalidInput>(
          "uv must have one row per vertex unless uv_triangles are given, got {} rows for {} "
          "vertices; add uv_triangles",
          uv_.rows(), vertices_.rows());
    }
    uv_triangles_ = triangles_;
  }
  check_rest_coordinates(triangles_, uv_, uv_triangles_);
}

double TriangleMesh::mean_edge() const {
  const EdgeTable table = edge_table(n_vertices(), triangles_);
  double sum = 0.0;
  for (Eigen::Index e = 0; e < table.edges.rows(); ++e) {
    sum += (vertices_.row(table.edges(e, 0)) - vertices_.row(table.edges(e, 1))).norm();
  }
  return sum / static_cast<double>(table.edges.rows());
}

bool TriangleMesh::closed() const {
  for (const std::array<Index, 2>& pair : edge_table(n_vertices(), triangles_).triangles) {
    if (pair[1] < 0) return false;
  }
  return true;
}

bool TriangleMesh::flat() const {
  const Plane plane = widest_plane(vertices_);
  for (Eigen::Index i = 0; i < vertices_.rows(); ++i) {
    if (std::abs(plane.normal.dot(vertices_.row(i).transpose() - plane.point)) > 1e-9 * plane.size)
      return false;
  }
  return true;
}

TriangleMesh TriangleMesh::moved(const Vec3& translation, const Mat3& rotation,
                                 double scale) const {
  if (!translation.allFinite()) {
    fail<InvalidInput>("translation must be finite, got ({}, {}, {}); correct it", translation.x(),
                       translation.y(), translation.z());
  }
  if (!(scale > 0.0) || !std::isfinite(scale)) {
    fail<InvalidInput>(
        "scale must be > 0 and finite, got {}; to mirror a mesh, change its vertices", scale);
  }
  if (!((rotation * rotation.transpose()).isApprox(Mat3::Identity(), 1e-9) &&
        rotation.determinant() > 0.0)) {
    fail<InvalidInput>(
        "rotation must be a rotation matrix, got one that stretches or mirrors; use scale to "
        "change the size");
  }
  TriangleMesh result(*this);
  for (Eigen::Index i = 0; i < vertices_.rows(); ++i) {
    const Vec3 turned = rotation * vertices_.row(i).transpose();
    result.vertices_.row(i) = (scale * turned + translation).transpose();
  }
  return result;
}

TriangleMesh TriangleMesh::reordered(const std::vector<Index>& vertex_order,
                                     const std::vector<Index>& triangle_order) const {
  check_permutation(vertex_order, n_vertices(), "vertex_order");
  check_permutation(triangle_order, n_triangles(), "triangle_order");
  std::vector<Index> place(vertex_order.size());  // new index of each old vertex
  TriangleMesh result(*this);
  for (std::size_t i = 0; i < vertex_order.size(); ++i) {
    place[static_cast<std::size_t>(vertex_order[i])] = static_cast<Index>(i);
    result.vertices_.row(static_cast<Eigen::Index>(i)) = vertices_.row(vertex_order[i]);
  }
  for (Index t = 0; t < n_triangles(); ++t) {
    const Index old = triangle_order[static_cast<std::size_t>(t)];
    for (int c = 0; c < 3; ++c)
      result.triangles_(t, c) = place[static_cast<std::size_t>(triangles_(old, c))];
    if (has_uv()) result.uv_triangles_.row(t) = uv_triangles_.row(old);
  }
  return result;
}

TriangleMesh welded(const TriangleMesh& mesh) {
  std::map<std::array<double, 3>, Index> known;
  std::vector<Index> place;  // new index of each old vertex
  Points vertices(mesh.n_vertices(), 3);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const std::array<double, 3> at = {mesh.vertices()(v, 0), mesh.vertices()(v, 1),
                                      mesh.vertices()(v, 2)};
    const auto [entry, fresh] = known.try_emplace(at, static_cast<Index>(known.size()));
    if (fresh) vertices.row(entry->second) = mesh.vertices().row(v);
    place.push_back(entry->second);
  }
  Triangles triangles = mesh.triangles();
  for (Index& vertex : triangles.reshaped()) vertex = place[static_cast<std::size_t>(vertex)];
  return TriangleMesh(vertices.topRows(static_cast<Eigen::Index>(known.size())), triangles,
                      mesh.uv(), mesh.uv_triangles());
}

RestCorners::RestCorners(const TriangleMesh& mesh, bool rest_from_uv, const std::string& where)
    : mesh_(&mesh), rest_from_uv_(rest_from_uv) {
  if (mesh.has_uv()) return;
  if (!mesh.flat()) {
    fail<InvalidInput>(
        "{} must have uv or be flat, got a curved mesh without uv, whose weft and warp directions "
        "are unknown; give uv [m] for every triangle",
        where);
  }
  const Plane plane = widest_plane(mesh.vertices());
  weft_ = Vec3::UnitX() - plane.normal.x() * plane.normal;
  if (weft_.norm() < 1e-6) weft_ = Vec3::UnitY() - plane.normal.y() * plane.normal;
  weft_.normalize();
}

Corners2 RestCorners::operator[](Index triangle) const {
  if (!mesh_->has_uv()) return flattened(*mesh_, triangle, weft_, Vec3::Zero());
  Corners2 from_uv = corners_of_uv(*mesh_, triangle);
  if (rest_from_uv_) return from_uv;
  return flattened(*mesh_, triangle, weft_direction(*mesh_, triangle, from_uv),
                   corner(*mesh_, triangle, 0));
}

std::vector<Corners2> rest_corners(const TriangleMesh& mesh, bool rest_from_uv,
                                   const std::string& where) {
  const RestCorners corners(mesh, rest_from_uv, where);
  std::vector<Corners2> result(static_cast<std::size_t>(mesh.n_triangles()));
  for (Index t = 0; t < mesh.n_triangles(); ++t) result[static_cast<std::size_t>(t)] = corners[t];
  return result;
}

}  // namespace loomstone
