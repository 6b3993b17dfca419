// Closest-point queries and inside tests. Embree finds candidates by bounding boxes, which are
// rounded outwards to float. Distances are computed here in double precision, so the result equals
// that of an exhaustive search. Pseudo-normals are those of [BaerentzenAanaes2005].
#include "core/mesh/spatial_query.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/message.h"
#include "core/mesh/adjacency.h"
#include "core/mesh/closest_on_triangle.h"

namespace loomstone {

namespace {

Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = v.norm();
  return length > 0.0 ? Vec3(v / length) : otherwise;
}

// Data for Embree's callbacks.
struct Surface {
  Points vertices;
  Triangles triangles;

  Vec3 corner(Index triangle, int k) const {
    return vertices.row(triangles(triangle, k)).transpose();
  }
};

// Bounding box of a triangle, rounded outwards to float.
void triangle_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& surface = *static_cast<const Surface*>(arguments->geometryUserPtr);
  const auto triangle = static_cast<Index>(arguments->primID);
  const Vec3 a = surface.corner(triangle, 0), b = surface.corner(triangle, 1),
             c = surface.corner(triangle, 2);
  const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const float infinity = std::numeric_limits<float>::infinity();
  const auto down = [&](double x) { return std::nextafterf(static_cast<float>(x), -infinity); };
  const auto up = [&](double x) { return std::nextafterf(static_cast<float>(x), infinity); };
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = down(low.x()), bounds.lower_y = down(low.y()), bounds.lower_z = down(low.z());
  bounds.upper_x = up(high.x()), bounds.upper_y = up(high.y()), bounds.upper_z = up(high.z());
}

struct Search {
  const Surface* surface;
  Vec3 point;
  double rounding;  // distance between `point` and its copy in float [m]
  // Squared distance to the closest triangle found so far; initially the squared search radius
  // [m^2].
  double best = 0.0;
  Index triangle = -1;
  TrianglePoint candidate{};
};

// Returns distance + rounding, enlarged by a fraction of 1e-6. Embree's distances to boxes have
// rounding errors, but triangles at exactly `distance` must be found, too.
float search_radius(double distance, double rounding) {
  return static_cast<float>((distance + rounding) * (1.0 + 1e-6));
}

bool test_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  const auto triangle = static_cast<Index>(arguments->primID);
  const Surface& surface = *search.surface;
  const TrianglePoint candidate =
      closest_on_triangle(search.point, surface.corner(triangle, 0), surface.corner(triangle, 1),
                          surface.corner(triangle, 2));
  const double squared = (candidate.point - search.point).squaredNorm();
  const bool better =
      squared < search.best ||
      (squared == search.best && (search.triangle < 0 || triangle < search.triangle));
  if (!better) return false;
  const bool closer = squared < search.best;
  search.best = squared;
  search.triangle = triangle;
  search.candidate = candidate;
  if (closer)
    arguments->query->radius =
        std::min(arguments->query->radius, search_radius(std::sqrt(squared), search.rounding));
  return closer;
}

}  // namespace

struct SpatialQuery::Data : Surface {
  EdgeTable edges;
  std::vector<Vec3> face_normals, edge_normals, vertex_normals;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  RTCGeometry geometry = nullptr;

  Data() = default;
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;
  ~Data() {
    if (geometry) rtcReleaseGeometry(geometry);
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  void check() const;
  void build_tree();
  void update_normals();
  Vec3 normal(Index triangle, const TrianglePoint& candidate) const;
};

void SpatialQuery::Data::check() const {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    fail<Error>("spatial query: Embree failed with error {}; the usual cause is a lack of memory",
                static_cast<int>(error));
  }
}

void SpatialQuery::Data::build_tree() {
  device = rtcNewDevice("threads=1");
  if (!device) {
    fail<Error>(
        "spatial query: Embree could not create a device (error {}): there is not enough "
        "memory, or it does not support this processor",
        static_cast<int>(rtcGetDeviceError(nullptr)));
  }
  scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC);
  geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles.rows()));
  rtcSetGeometryUserData(geometry, static_cast<Surface*>(this));
  rtcSetGeometryBoundsFunction(geometry, triangle_bounds, nullptr);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);  // all later commits refit
  check();
}

void SpatialQuery::Data::update_normals() {
  const Index n_triangles = static_cast<Index>(triangles.rows());
  face_normals.resize(n_triangles);
  vertex_normals.assign(vertices.rows(), Vec3::Zero());
  for (Index t = 0; t < n_triangles; ++t) {
    const Vec3 x[3] = {corner(t, 0), corner(t, 1), corner(t, 2)};
    face_normals[t] = unit_or((x[1] - x[0]).cross(x[2] - x[0]), Vec3::Zero());
    for (int k = 0; k < 3; ++k) {
      const Vec3 u = x[(k + 1) % 3] - x[k], v = x[(k + 2) % 3] - x[k];
      const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
      vertex_normals[triangles(t, k)] += angle * face_normals[t];
    }
  }
  for (Vec3& normal : vertex_normals) normal = unit_or(normal, Vec3::Zero());
  edge_normals.resize(edges.triangles.size());
  for (std::size_t e = 0; e < edge_normals.size(); ++e) {
    const auto [first, second] = edges.triangles[e];
    Vec3 sum = face_normals[first];
    if (second >= 0) sum += face_normals[second];
    edge_normals[e] = unit_or(sum, face_normals[first]);
  }
}

Vec3 SpatialQuery::Data::normal(Index triangle, const TrianglePoint& candidate) const {
  switch (candidate.feature) {
    case TriangleFeature::Corner:
      return vertex_normals[triangles(triangle, candidate.corner)];
    case TriangleFeature::Edge:
      return edge_normals[edges.of_triangle[triangle][candidate.corner]];
    case TriangleFeature::Face:
      break;
  }
  return face_normals[triangle];
}

SpatialQuery::SpatialQuery(const Points& vertices, const Triangles& triangles)
    : data_(std::make_unique<Data>()) {
  data_->vertices = vertices;
  data_->triangles = triangles;
  data_->edges = edge_table(static_cast<Index>(vertices.rows()), triangles);
  data_->update_normals();
  data_->build_tree();
}

SpatialQuery::~SpatialQuery() = default;
SpatialQuery::SpatialQuery(SpatialQuery&&) noexcept = default;
SpatialQuery& SpatialQuery::operator=(SpatialQuery&&) noexcept = default;

void SpatialQuery::refit(const Points& vertices) {
  if (vertices.rows() != data_->vertices.rows()) {
    fail<InvalidInput>(
        "spatial query: refit must be given as many vertices as the query was built with ({}), got "
        "{}; make a new query for another mesh",
        data_->vertices.rows(), vertices.rows());
  }
  data_->vertices = vertices;
  data_->update_normals();
  rtcCommitGeometry(data_->geometry);
  rtcCommitScene(data_->scene);
  data_->check();
}

ClosestPoint SpatialQuery::closest(const Vec3& point, double radius) const {
  RTCPointQuery query;
  query.x = static_cast<float>(point.x());
  query.y = static_cast<float>(point.y());
  query.z = static_cast<float>(point.z());
  query.time = 0.0f;
  Search search;
  search.surface = data_.get();
  search.point = point;
  search.rounding = (Vec3(query.x, query.y, query.z) - point).norm();
  search.best = radius * radius;
  query.radius = search_radius(radius, search.rounding);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(data_->scene, &query, &context, test_triangle, &search);

  ClosestPoint result;
  if (search.triangle < 0) return result;
  result.triangle = search.triangle;
  result.point = search.candidate.point;
  result.barycentric = search.candidate.barycentric;
  result.normal = data_->normal(search.triangle, search.candidate);
  result.distance = std::sqrt(search.best);
  return result;
}

bool SpatialQuery::inside(const Vec3& point) const {
  const ClosestPoint closest_point = closest(point, std::numeric_limits<double>::infinity());
  return closest_point.triangle >= 0 &&
         (point - closest_point.point).dot(closest_point.normal) < 0.0;
}

}  // namespace loomstone
