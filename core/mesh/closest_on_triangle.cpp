#include "core/mesh/closest_on_triangle.h"

namespace loomstone {

namespace {

TrianglePoint at_corner(const Vec3& position, int corner) {
  return {position, Vec3::Unit(corner), TriangleFeature::Corner, corner};
}

// Returns the point with parameter t in [0, 1] on the edge from corner `from` (a) to corner `to`
// (b).
TrianglePoint on_edge(const Vec3& a, const Vec3& b, double t, int from, int to) {
  Vec3 barycentric = Vec3::Zero();
  barycentric[from] = 1.0 - t;
  barycentric[to] = t;
  return {a + t * (b - a), barycentric, TriangleFeature::Edge, 3 - from - to};
}

TrianglePoint closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b, int from, int to) {
  const Vec3 ab = b - a;
  const double along = ab.dot(p - a), squared = ab.squaredNorm();
  if (along <= 0.0 || squared == 0.0) return at_corner(a, from);
  if (along >= squared) return at_corner(b, to);
  return on_edge(a, b, along / squared, from, to);
}

}  // namespace

TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return at_corner(a, 0);
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return at_corner(b, 1);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) return on_edge(a, b, d1 / (d1 - d3), 0, 1);
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return at_corner(c, 2);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) return on_edge(a, c, d2 / (d2 - d6), 0, 2);
  const double va = d3 * d6 - d5 * d4;
  const double along = d4 - d3, back = d5 - d6;
  if (va <= 0.0 && along >= 0.0 && back >= 0.0 && along + back > 0.0)
    return on_edge(b, c, along / (along + back), 1, 2);
  const double sum = va + vb + vc;
  if (sum > 0.0) {
    const double v = vb / sum, w = vc / sum;
    return {a + v * ab + w * ac, Vec3(1.0 - v - w, v, w), TriangleFeature::Face, 0};
  }
  // If the triangle has zero area, the result is the closest point on its edges.
  TrianglePoint best = closest_on_segment(p, a, b, 0, 1);
  for (const TrianglePoint& other :
       {closest_on_segment(p, b, c, 1, 2), closest_on_segment(p, a, c, 0, 2)}) {
    if ((other.point - p).squaredNorm() < (best.point - p).squaredNorm()) best = other;
  }
  return best;
}

}  // namespace loomstone
