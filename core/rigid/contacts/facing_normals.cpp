#include "core/rigid/contacts/facing_normals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/mesh/closest_on_triangle.h"

namespace loomstone {

namespace {

constexpr double parallel = 0.98;  // cosine of 11.5 degrees: normals at smaller angles agree

using Corners = std::array<Vec3, 3>;

class FacingNormals {
 public:
  explicit FacingNormals(const FacingQuery& query)
      : query_(query),
        links_(query.triangles.size()),
        orientation_(query.triangles.size(), 0),
        first_(query.triangles.size(), none),
        own_(query.triangles.size()) {
    for (const Corners& x : query.triangles)
      normals_.push_back((x[1] - x[0]).cross(x[2] - x[0]).normalized());
    for (std::size_t t = 0; t < own_.size(); ++t) own_[t] = own_side(t);
  }

  std::vector<Vec3> find() {
    if (is_flat()) {
      for (std::size_t t = 0; t < own_.size(); ++t) face(t, own_[t]);
      return std::move(normals_);
    }
    link();
    std::vector<std::size_t> surface;
    for (std::size_t t = 0; t < normals_.size(); ++t) {
      if (orientation_[t] != 0) continue;
      const bool orientable = spread(t, surface);
      bool in_front = false, behind = false;
      for (const std::size_t k : surface) {
        in_front |= own_[k] * orientation_[k] > 0.0;
        behind |= own_[k] * orientation_[k] < 0.0;
      }
      // If all triangles of the surface agree on the side of the hull, side_of() is not needed.
      const double side = orientable && in_front && behind ? side_of(surface) : 0.0;
      for (const std::size_t k : surface) face(k, side == 0.0 ? own_[k] : side * orientation_[k]);
    }
    return std::move(normals_);
  }

 private:
  struct Link {
    std::size_t triangle = none;
    int turned = 1;  // -1 if the normals of the two triangles point to different sides
  };
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  void face(std::size_t t, double side) {
    if (side < 0.0) normals_[t] = -normals_[t];
  }

  // Returns whether all triangles are parallel and, each judged by itself, face the same direction.
  bool is_flat() const {
    for (std::size_t t = 0; t < own_.size(); ++t) {
      const double along = normals_[t].dot(normals_[0]);
      if (!(along * own_[t] * own_[0] > 0.0) || std::abs(along) < 1.0 - 1e-12) return false;
    }
    return true;
  }

  // Fills links_: side k of triangle t runs from its corner k to the next. It has a link if exactly
  // one other triangle has this side.
  void link() {
    struct Side {
      std::array<std::size_t, 2> ends;
      std::size_t triangle;
      int side;
      bool forward;
    };
    std::vector<Side> sides;
    for (std::size_t t = 0; t < links_.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const std::size_t from = query_.shared.of(t)[k], to = query_.shared.of(t)[(k + 1) % 3];
        if (from != to)
          sides.push_back({{std::min(from, to), std::max(from, to)}, t, k, from < to});
      }
    std::ranges::stable_sort(sides, {}, &Side::ends);
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
      end = begin;
      while (end < sides.size() && sides[end].ends == sides[begin].ends) ++end;
      if (end - begin != 2) continue;
      const Side &a = sides[begin], &b = sides[begin + 1];
      const int turned = a.forward == b.forward ? -1 : 1;
      links_[a.triangle][a.side] = {b.triangle, turned};
      links_[b.triangle][b.side] = {a.triangle, turned};
    }
  }

  // Collects in `surface` the triangles that are connected with `first` by links, and orients them
  // alike. Returns false if they cannot be oriented alike.
  bool spread(std::size_t first, std::vector<std::size_t>& surface) {
    bool orientable = true;
    surface.assign(1, first);
    orientation_[first] = 1, first_[first] = first;
    for (std::size_t k = 0; k < surface.size(); ++k)
      for (const Link& link : links_[surface[k]]) {
        if (link.triangle == none) continue;
        const int turned = orientation_[surface[k]] * link.turned;
        int& other = orientation_[link.triangle];
        if (other == 0) {
          other = turned, first_[link.triangle] = first;
          surface.push_back(link.triangle);
        }
        orientable &= other == turned;
      }
    return orientable;
  }

  // Returns a positive number if the hull is on the side to which the oriented normals point, a
  // negative one if it is on the other side, and 0 if the side cannot be determined.
  double side_of(const std::vector<std::size_t>& surface) const {
    bool in_front = false, behind = false;
    for (const std::size_t t : surface)
      for (const HullContact& contact : query_.before) {
        const double along = oriented(t).dot(contact.normal);
        if (std::abs(along) <= parallel || off_plane(t, contact) >= query_.reach) continue;
        (along > 0.0 ? in_front : behind) = true;
      }
    if (in_front != behind) return in_front ? 1.0 : -1.0;
    return side_of_centre(surface);
  }

  double side_of_centre(const std::vector<std::size_t>& surface) const {
    double least = std::numeric_limits<double>::infinity();
    std::size_t nearest = none;
    TrianglePoint closest{};
    for (const std::size_t t : surface) {
      const Corners& x = query_.triangles[t];
      const TrianglePoint here = closest_on_triangle(query_.centre, x[0], x[1], x[2]);
      const double distance = (query_.centre - here.point).squaredNorm();
      if (distance < least) least = distance, nearest = t, closest = here;
    }
    if (nearest == none) return 0.0;
    const std::optional<Vec3> normal = normal_at(nearest, closest);
    return normal ? normal->dot(query_.centre - closest.point) : 0.0;
  }

  // Returns the oriented normal at a point of triangle t, not normalised. Returns nothing on the
  // surface's boundary.
  std::optional<Vec3> normal_at(std::size_t t, const TrianglePoint& point) const {
    if (point.feature == TriangleFeature::Face) return oriented(t);
    if (point.feature == TriangleFeature::Edge) {
      const std::size_t other = links_[t][(point.corner + 1) % 3].triangle;
      if (other == none) return std::nullopt;
      return oriented(t) + oriented(other);
    }
    Vec3 sum = Vec3::Zero();
    const std::size_t corner = query_.shared.of(t)[point.corner];
    for (const std::size_t k : query_.shared.triangles_at(corner)) {
      if (first_[k] != first_[t]) continue;
      const auto& corners = query_.shared.of(k);
      const int at = static_cast<int>(std::ranges::find(corners, corner) - corners.begin());
      if (links_[k][at].triangle == none || links_[k][(at + 2) % 3].triangle == none)
        return std::nullopt;
      const Corners& x = query_.triangles[k];
      const Vec3 a = x[(at + 1) % 3] - x[at], b = x[(at + 2) % 3] - x[at];
      sum += std::atan2(a.cross(b).norm(), a.dot(b)) * oriented(k);
    }
    return sum;
  }

  // Returns a positive number if the normal of triangle t points to the hull, judged from this
  // triangle alone, and a negative one if it points away.
  double own_side(std::size_t t) const {
    double side = normals_[t].dot(query_.centre - query_.triangles[t][0]), least = query_.reach;
    for (const HullContact& contact : query_.before) {
      const double along = normals_[t].dot(contact.normal), off = off_plane(t, contact);
      if (std::abs(along) > parallel && off < least) side = along, least = off;
    }
    return side;
  }

  Vec3 oriented(std::size_t t) const { return orientation_[t] * normals_[t]; }
  double off_plane(std::size_t t, const HullContact& contact) const {
    return std::abs(normals_[t].dot(contact.point - query_.triangles[t][0]));
  }

  const FacingQuery& query_;
  std::vector<std::array<Link, 3>> links_;
  std::vector<int> orientation_;    // 1: as the surface's first triangle; -1: opposite; 0: unknown
  std::vector<std::size_t> first_;  // first triangle of the surface of each triangle
  std::vector<double> own_;         // own_side() of each triangle
  std::vector<Vec3> normals_;
};

}  // namespace

std::vector<Vec3> facing_normals(const FacingQuery& query) { return FacingNormals(query).find(); }

}  // namespace loomstone
