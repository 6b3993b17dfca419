#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>

#include "core/base/message.h"
#include "core/parallel/vertex_order.h"
#include "core/sim/model/build.h"

namespace loomstone {

namespace {

// All cloths concatenated, in the user's numbering.
struct Joined {
  Points x, v;
  Triangles triangles;
  std::vector<Index> cloth_of_triangle, first_vertex;
};

Joined join(const Scene& scene) {
  Joined all;
  Index n = 0, m = 0;
  for (const Cloth& cloth : scene.cloths) {
    all.first_vertex.push_back(n);
    n += cloth.mesh->n_vertices(), m += cloth.mesh->n_triangles();
  }
  all.x.resize(n, 3);
  all.v = Points::Zero(n, 3);
  all.triangles.resize(m, 3);
  Index triangle = 0;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const Cloth& cloth = scene.cloths[c];
    const Index first = all.first_vertex[c], k = cloth.mesh->n_vertices();
    all.x.middleRows(first, k) = cloth.mesh->vertices();
    if (cloth.velocities.rows() > 0) all.v.middleRows(first, k) = cloth.velocities;
    all.triangles.middleRows(triangle, cloth.mesh->n_triangles()) =
        cloth.mesh->triangles().array() + first;
    all.cloth_of_triangle.insert(all.cloth_of_triangle.end(), cloth.mesh->n_triangles(),
                                 static_cast<Index>(c));
    triangle += cloth.mesh->n_triangles();
  }
  return all;
}

// Returns the bending rigidity D [N m] for the curvatures (kxx, kyy, 2 kxy). If bending_twist is
// negative, the twist entry D33 is that of [Huber1923], (sqrt(D11 D22) - D12) / 2, which is exact
// for isotropic plates.
Mat3 rigidity_of(const ClothMaterial& m, const std::string& where) {
  const double mean = std::sqrt(m.bending_weft * m.bending_warp);
  const double twist = m.bending_twist < 0.0 ? 0.5 * (mean - m.bending_coupling) : m.bending_twist;
  if (std::abs(m.bending_coupling) > mean || twist < 0.0)
    fail<InvalidInput>(
        "{}.bending_coupling must keep the rigidity positive, |bending_coupling| <= "
        "sqrt(bending_weft bending_warp) = {:.6g} [N m], got {}; reduce it",
        where, mean, m.bending_coupling);
  Mat3 d = Mat3::Zero();
  d(0, 0) = m.bending_weft, d(1, 1) = m.bending_warp, d(2, 2) = twist;
  d(0, 1) = d(1, 0) = m.bending_coupling;
  return d;
}

// Orders the vertices of all cloths. Each cloth has a contiguous range of rows. Within it, rows
// follow the recursive bisection of the mesh graph.
void order_vertices(const Scene& scene, const Joined& all, Model& model) {
  model.row_of_vertex.resize(all.x.rows());
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const TriangleMesh& mesh = *scene.cloths[c].mesh;
    const Incidence neighbours = vertex_graph(mesh.n_vertices(), mesh.triangles());
    const std::vector<Index> order = bisection_order({neighbours.start, neighbours.items});
    const Index first = all.first_vertex[c];
    for (Index row = 0; row < mesh.n_vertices(); ++row)
      model.row_of_vertex[first + order[row]] = first + row;
  }
}

void order_triangles(const Joined& all, Model& model) {
  const Index m = static_cast<Index>(all.triangles.rows());
  Triangles renamed(m, 3);
  for (Index t = 0; t < m; ++t)
    for (int k = 0; k < 3; ++k) renamed(t, k) = model.row_of_vertex[all.triangles(t, k)];
  model.triangle_of.resize(m);
  std::iota(model.triangle_of.begin(), model.triangle_of.end(), 0);
  std::stable_sort(model.triangle_of.begin(), model.triangle_of.end(), [&](Index a, Index b) {
    return renamed.row(a).minCoeff() < renamed.row(b).minCoeff();
  });
  model.cloth.triangles.resize(m, 3);
  for (Index t = 0; t < m; ++t) model.cloth.triangles.row(t) = renamed.row(model.triangle_of[t]);
}

RestCorners rest_corners_of(const Scene& scene, std::size_t c) {
  const Cloth& cloth = scene.cloths[c];
  return {*cloth.mesh, cloth.rest == RestLengths::Uv, item("cloths", c, cloth.name) + ".mesh"};
}

// Returns the rest shapes of all triangles, in the order of the model. They are computed from the
// meshes on demand.
RestShapes rest_shapes(const Scene& scene, const Model& model) {
  std::vector<RestCorners> corners;
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;  // keeps the meshes of `corners` alive
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    corners.push_back(rest_corners_of(scene, c));
    meshes.push_back(scene.cloths[c].mesh);
  }
  const std::vector<Index>& first = model.cloth.first_triangle;
  const auto of = [corners, meshes, first, triangle_of = model.triangle_of](Index t) {
    const auto next = std::upper_bound(first.begin(), first.end(), t);
    const std::size_t cloth = static_cast<std::size_t>(next - first.begin()) - 1;
    return corners[cloth][triangle_of[t] - first[cloth]];
  };
  return {static_cast<Index>(model.triangle_of.size()), of, bytes_of(model.triangle_of)};
}

// Returns the start positions of all cloth rows. They are computed from the meshes on demand.
RestPositions rest_positions(const Scene& scene, const Model& model) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const Cloth& cloth : scene.cloths) meshes.push_back(cloth.mesh);
  const auto positions = [meshes, row_of_vertex = model.row_of_vertex] {
    Points x(row_of_vertex.size(), 3);
    auto row = row_of_vertex.begin();
    for (const auto& mesh : meshes)
      for (Index vertex = 0; vertex < mesh->n_vertices(); ++vertex, ++row)
        x.row(*row) = mesh->vertices().row(vertex);
    return x;
  };
  return {positions, bytes_of(model.row_of_vertex)};
}

void set_materials(const Scene& scene, const Joined& all, Model& model) {
  const Index m = static_cast<Index>(model.triangle_of.size());
  ClothModel& cloth = model.cloth;
  std::vector<double> density(m);
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    cloth.constants.push_back(membrane_constants(
        scene.cloths[c].material, item("cloths", c, scene.cloths[c].name) + ".material"));
  std::vector<Index> limit_of_cloth(scene.cloths.size(), -1);
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    if (scene.cloths[c].strain_limit) {
      limit_of_cloth[c] = static_cast<Index>(cloth.strain_limits.size());
      cloth.strain_limits.push_back(*scene.cloths[c].strain_limit);
    }
  cloth.limited_by_edges = scene.limits.method == LimitMethod::Edges;
  if (!cloth.strain_limits.empty()) cloth.strain_limit_of.resize(m);
  for (Index t = 0; t < m; ++t) {
    const Index c = all.cloth_of_triangle[model.triangle_of[t]];
    density[t] = scene.cloths[c].material.density;
    if (!cloth.strain_limits.empty()) cloth.strain_limit_of[t] = limit_of_cloth[c];
  }
  cloth.mass = lumped_mass(cloth.n_vertices, cloth.triangles, cloth.corners.all(), density);
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const Cloth& description = scene.cloths[c];
    const Mat3 d =
        rigidity_of(description.material, item("cloths", c, description.name) + ".material");
    if (d.isZero(0.0)) continue;
    ClothModel::BendingPart part;
    part.element = description.bending;
    part.cloth = static_cast<Index>(c);
    part.rigidity = d;
    part.damping = description.material.bending_damping;
    part.flat_rest = description.rest_angles == RestAngles::Flat;
    cloth.bending.push_back(part);
  }
  if (!cloth.bending.empty()) cloth.rest_positions = rest_positions(scene, model);
}

}  // namespace

void build_cloth(const Scene& scene, Model& model, State& state) {
  const Joined all = join(scene);
  ClothModel& cloth = model.cloth;
  const Index n = cloth.n_vertices = static_cast<Index>(all.x.rows());
  if (n > 0) model.cloth_size = (all.x.colwise().maxCoeff() - all.x.colwise().minCoeff()).norm();
  cloth.first_vertex = cloth.first_triangle = {0};
  for (const Cloth& each : scene.cloths) {
    cloth.first_vertex.push_back(cloth.first_vertex.back() + each.mesh->n_vertices());
    cloth.first_triangle.push_back(cloth.first_triangle.back() + each.mesh->n_triangles());
  }
  order_vertices(scene, all, model);
  order_triangles(all, model);
  cloth.corners = rest_shapes(scene, model);
  state.cloth.x.resize(n, 3);
  state.cloth.v.resize(n, 3);
  for (Index vertex = 0; vertex < n; ++vertex) {
    state.cloth.x.row(model.row_of_vertex[vertex]) = all.x.row(vertex);
    state.cloth.v.row(model.row_of_vertex[vertex]) = all.v.row(vertex);
  }
  cloth.prescribed.assign(n, 0);
  for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
    const Cloth& description = scene.cloths[c];
    Model::PinScript script;
    for (const Index pin : description.pins) {
      const Index row = model.row_of_vertex[all.first_vertex[c] + pin];
      cloth.prescribed[row] = 1;
      script.rows.push_back(row);
      if (description.script_times.empty()) state.cloth.v.row(row).setZero();
    }
    if (description.script_times.empty()) continue;
    script.times = description.script_times;
    script.positions = description.script_positions;
    model.scripts.push_back(std::move(script));
  }
  if (scene.air.drags()) cloth.triangles_of_vertex = triangles_of_vertices(n, cloth.triangles);
  set_materials(scene, all, model);
  state.pin_override.assign(n, 0);

  FrameTopology& topology = model.topology;
  for (std::size_t c = 0; c < scene.cloths.size(); ++c)
    topology.cloth_names.push_back(
        name_of(scene, "cloth", c, scene.cloths.size(), scene.cloths[c].name));
  if (std::any_of(scene.cloths.begin(), scene.cloths.end(),
                  [](const Cloth& cloth) { return cloth.look.has_value(); }))
    for (const Cloth& cloth : scene.cloths)
      topology.cloth_looks.push_back(cloth.look.value_or(Look{}));
}

FrameTopology frame_topology(const Model& model) {
  Joined all = join(model.scene);
  FrameTopology topology = model.topology;
  topology.triangles = std::move(all.triangles);
  topology.corner_uv.resize(3 * topology.triangles.rows(), 2);
  topology.cloth_of_triangle = std::move(all.cloth_of_triangle);
  Index row = 0;
  for (std::size_t c = 0; c < model.scene.cloths.size(); ++c) {
    const RestCorners corners = rest_corners_of(model.scene, c);
    for (Index t = 0; t < model.scene.cloths[c].mesh->n_triangles(); ++t, row += 3)
      topology.corner_uv.middleRows(row, 3) = corners[t];
    topology.cloth_of_vertex.insert(topology.cloth_of_vertex.end(),
                                    model.scene.cloths[c].mesh->n_vertices(),
                                    static_cast<Index>(c));
  }
  return topology;
}

}  // namespace loomstone
