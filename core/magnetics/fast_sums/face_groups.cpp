#include "core/magnetics/fast_sums/source_groups.h"
#include "core/magnetics/sources/flat_face.h"
#include "core/magnetics/sources/gauss.h"

namespace loomstone {

namespace {

// Let q be J.n / (4 pi) [T], with the polarization J and the unit normal n of a face. A table of
// eight faces has rows for the three corners, the unit normal, twice the area, and q. Rows for each
// of the three edges follow: both ends, the length, q times the in-plane normal of the edge, and q
// times the normal of the face.
constexpr int face_rows = 14, edge_rows = 13,
              face_group_size = (face_rows + 3 * edge_rows) * n_lanes;

template <class Lanes>
LOOMSTONE_INLINE void group_kernel(const double* tables, GroupList groups, double radius,
                                   const double* point, double* field, double* gradient) {
  const Lanes3<Lanes> p{lanes_all<Lanes>(point[0]), lanes_all<Lanes>(point[1]),
                        lanes_all<Lanes>(point[2])};
  Lanes h[3], g[6];
  for (Lanes& s : h) s = Lanes{};
  for (Lanes& s : g) s = Lanes{};
  for (Index k = 0; k < groups.n; ++k) {
    const double* row = tables + static_cast<std::size_t>(groups.places[k]) * face_group_size;
    Lanes f[face_rows];
    for (Lanes& value : f) value = lanes_load<Lanes>(row), row += n_lanes;
    const Lanes angle = f[13] * solid_angle(p, f, on_face * radius);
    for (int c = 0; c < 3; ++c) h[c] += f[9 + c] * angle;
    for (int edge = 0; edge < 3; ++edge) {
      Lanes e[edge_rows];
      for (Lanes& value : e) value = lanes_load<Lanes>(row), row += n_lanes;
      const EdgeTerms<Lanes> t = edge_terms(p, e, on_edge * radius);
      const Lanes log = lanes_log(t.sum / t.defect);
      for (int c = 0; c < 3; ++c) h[c] += e[7 + c] * log;
      add_edge_gradients(edge_gradients(t, e), e + 7, e + 10, g);
    }
  }
  for (int c = 0; c < 3; ++c) field[c] = lanes_sum(h[c]);
  for (int c = 0; c < 6; ++c) gradient[c] = lanes_sum(g[c]);
}

}  // namespace

FaceGroups::FaceGroups(std::shared_ptr<const Polyhedron> mesh) : mesh_(std::move(mesh)) {
  const Points& x = mesh_->vertices();
  for (Index t = 0; t < mesh_->triangles().rows(); ++t) {
    Vec3 c[3];
    for (int k = 0; k < 3; ++k) c[k] = x.row(mesh_->triangles()(t, k)).transpose();
    if ((c[1] - c[0]).cross(c[2] - c[0]).dot(mesh_->polarization()) != 0.0)
      corners_.insert(corners_.end(), c, c + 3);
  }
}

Vec3 FaceGroups::middle(Index part) const {
  const Vec3* c = corners_.data() + 3 * static_cast<std::size_t>(part);
  return (c[0] + c[1] + c[2]) / 3.0;
}

double FaceGroups::reach(Index part, const Vec3& from) const {
  double reach = 0.0;
  for (int k = 0; k < 3; ++k)
    reach = std::max(reach, (corners_[3 * static_cast<std::size_t>(part) + k] - from).norm());
  return reach;
}

// Adds a group of faces. Unused lanes have the shape of the group's first face and no charge.
void FaceGroups::add(const Index* parts, Index n, const TaylorExpansion& expansion,
                     const Vec3& centre, double* moments) {
  const GaussRule& rule = gauss_rule(expansion.order() / 2 + 1);
  std::vector<double> positions, charges;
  tables_.resize(tables_.size() + face_group_size);
  double* table = tables_.data() + tables_.size() - face_group_size;
  for (int lane = 0; lane < n_lanes; ++lane) {
    const Vec3* c = corners_.data() + 3 * static_cast<std::size_t>(parts[lane < n ? lane : 0]);
    const Vec3 area = (c[1] - c[0]).cross(c[2] - c[0]), normal = area.normalized();
    const double charge = lane < n ? mesh_->polarization().dot(normal) / (4.0 * pi) : 0.0;
    double* out = table + lane;
    const auto put = [&](double value) { *out = value, out += n_lanes; };
    const auto put3 = [&](const Vec3& v) { put(v[0]), put(v[1]), put(v[2]); };
    for (int k = 0; k < 3; ++k) put3(c[k]);
    put3(normal), put(area.norm()), put(charge);
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = c[k], b = c[(k + 1) % 3];
      put3(a), put3(b), put((b - a).norm());
      put3(charge * (b - a).normalized().cross(normal)), put3(charge * normal);
    }
    for (int i = 0; i < rule.n && lane < n; ++i) {
      const double u = 0.5 * (1.0 + rule.nodes[i]);
      for (int k = 0; k < rule.n; ++k) {
        const Vec3 x = c[0] + u * (c[1] - c[0]) + 0.5 * (1.0 + rule.nodes[k]) * u * (c[2] - c[1]);
        positions.insert(positions.end(), x.data(), x.data() + 3);
        charges.push_back(0.25 * rule.weights[i] * rule.weights[k] * u * charge * area.norm());
      }
    }
  }
  expansion.add_charges(positions.data(), charges.data(), static_cast<Index>(charges.size()),
                        centre, moments);
}

// The errors in the settings are 1.5 times those measured near a ring magnet with 3,200 faces.
std::vector<ExpansionSetting> FaceGroups::settings() const {
  return {{7, 0.55, 4e-3}, {9, 0.5, 3e-4}, {11, 0.4, 3e-5}, {14, 0.35, 3e-7}};
}

void FaceGroups::sum(GroupList groups, const double* point, double* field, double* gradient) const {
  LOOMSTONE_WIDEST(group_kernel)(tables_.data(), groups, mesh_->radius(), point, field, gradient);
}

}  // namespace loomstone
