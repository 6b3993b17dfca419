#include "core/rigid/bullet_shapes.h"

#include "core/base/message.h"
#include "core/rigid/shape_geometry.h"

namespace loomstone {

namespace {

void attach_polyhedron(btCollisionShape& shape, ConvexPolyhedron polyhedron, Shapes& shapes) {
  shapes.polyhedra.push_back(std::make_unique<ConvexPolyhedron>(std::move(polyhedron)));
  shape.setUserPointer(shapes.polyhedra.back().get());
}

// Adds the convex hull of `points` to `shapes`. Bullet surrounds the points of a hull shape with a
// margin, so this shape gets the points of a core: the hull, shrunk by the margin.
void add_hull(const std::vector<Vec3>& points, const std::string& where, Shapes& shapes) {
  btConvexHullComputer hull;
  hull.compute(points.front().data(), sizeof(Vec3), static_cast<int>(points.size()), 0.0, 0.0);
  // The vertices are taken from `points`, because Bullet rounds its copies to 1e-4 of the hull's
  // size.
  std::vector<Vec3> vertices;
  for (int i = 0; i < hull.vertices.size(); ++i)
    vertices.push_back(points[hull.original_vertex_index[i]]);
  std::vector<std::vector<int>> faces(hull.faces.size());
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* const start = &hull.edges[hull.faces[f]];
    const btConvexHullComputer::Edge* edge = start;
    do {
      faces[f].push_back(edge->getSourceVertex());
      edge = edge->getNextEdgeOfFace();
    } while (edge != start);
  }
  const bool polyhedron = hull.vertices.size() <= most_polyhedron_vertices;
  // A hull with more than most_polyhedron_vertices vertices, but at most this many, is replaced by
  // the hull of its true corners if these are few enough. Even larger hulls always count as round,
  // because the time to find the corners is proportional to the square of the number of faces.
  constexpr int most_reduced = 2000;
  if (!polyhedron && hull.vertices.size() <= most_reduced) {
    const std::vector<Vec3> corners = ConvexPolyhedron(vertices, faces).corners();
    if (corners.size() >= 4 && corners.size() <= most_polyhedron_vertices)
      return add_hull(corners, where, shapes);
  }
  const ConvexCore core =
      convex_core(vertices, faces, polyhedron ? polyhedron_margin : round_margin, where);
  auto shape = std::make_unique<btConvexHullShape>();
  shape->setMargin(core.margin);
  for (const Vec3& point : core.points) shape->addPoint(to_bullet(point), false);
  shape->recalcLocalAabb();
  if (polyhedron) shape->initializePolyhedralFeatures();
  if (hull.vertices.size() <= most_vertices_on_triangles)
    attach_polyhedron(*shape, ConvexPolyhedron(vertices, faces), shapes);
  shapes.all.push_back(std::move(shape));
}

// Returns the corners of a box in the body frame, whose axes are the columns of `principal`.
// `offset` is the position of the middle of the box relative to the centre of mass, in mesh axes.
std::vector<Vec3> box_corners(const Vec3& half, const Vec3& offset, const Mat3& principal) {
  std::vector<Vec3> corners = box_polyhedron(half).points;
  for (Vec3& corner : corners) corner = principal.transpose() * (offset + corner);
  return corners;
}

void add_box(const Vec3& half, Shapes& shapes) {
  auto box = std::make_unique<btBoxShape>(to_bullet(half));
  box->setMargin(0.05 * half.minCoeff());  // the margin lies inside the box
  box->initializePolyhedralFeatures();
  attach_polyhedron(*box, box_polyhedron(half), shapes);
  shapes.all.push_back(std::move(box));
}

}  // namespace

Shapes make_shapes(const RigidBody& body, const MassProperties& mass, const Mat3& principal,
                   const std::string& where) {
  check_shape(body, where);
  const TriangleMesh& mesh = *body.mesh;
  Shapes shapes;
  if (body.shape == BodyShape::Sphere) {
    shapes.all.push_back(std::make_unique<btSphereShape>(sphere_radius(mesh, mass, where)));
  } else if (body.shape == BodyShape::Box) {
    check_box(mesh, where);
    const Vec3 low = mesh.vertices().colwise().minCoeff().transpose(),
               high = mesh.vertices().colwise().maxCoeff().transpose();
    const Vec3 half = 0.5 * (high - low), offset = 0.5 * (low + high) - mass.centre;
    // Bullet's boxes are centred in the body frame and aligned with it. That frame is turned for a
    // body in a bearing, and the centre of mass of an open box is not its middle.
    if (principal.isIdentity(0.0) && offset.norm() < 1e-9 * half.norm())
      add_box(half, shapes);
    else
      add_hull(box_corners(half, offset, principal), where + ".mesh", shapes);
  } else if (body.shape == BodyShape::Convex) {
    add_hull(body_points(mesh, mass.centre, principal), where + ".mesh", shapes);
  } else {  // parts
    auto compound = std::make_unique<btCompoundShape>();
    for (std::size_t k = 0; k < body.parts.size(); ++k) {
      add_hull(body_points(*body.parts[k], mass.centre, principal),
               formatted("{}.parts[{}]", where, k), shapes);
      compound->addChildShape(btTransform::getIdentity(), &shapes.whole());
    }
    shapes.all.push_back(std::move(compound));
  }
  return shapes;
}

}  // namespace loomstone
