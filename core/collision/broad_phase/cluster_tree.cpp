#include "core/collision/broad_phase/cluster_tree.h"

#include <algorithm>
#include <utility>

#include "core/base/simd.h"

namespace loomstone {

namespace {

// If the total surface area of the cluster boxes has grown by more than this factor since the
// clusters were formed, a refit with `may_rebuild` forms new clusters. The factor does not affect
// which pairs are found.
constexpr double decay_limit = 1.5;
constexpr Index refit_grain = 128;  // number of groups in a range of a parallel loop

// Transposes an 8 x 8 block in place.
template <class Floats>
LOOMSTONE_INLINE void transpose(Floats* row) {
  Floats a[slab_lanes], b[slab_lanes];
  for (int i = 0; i < 8; i += 2) {
    a[i] = __builtin_shufflevector(row[i], row[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    a[i + 1] = __builtin_shufflevector(row[i], row[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (int i = 0; i < 8; i += 4)
    for (int j = 0; j < 2; ++j) {
      b[i + 2 * j] = __builtin_shufflevector(a[i + j], a[i + j + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      b[i + 2 * j + 1] =
          __builtin_shufflevector(a[i + j], a[i + j + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (int i = 0; i < 4; ++i) {
    row[i] = __builtin_shufflevector(b[i], b[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    row[i + 4] = __builtin_shufflevector(b[i], b[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// Stores eight packed boxes as one group in structure-of-arrays layout.
template <class Floats>
LOOMSTONE_INLINE void write_group(const PackedSlabs* item, SlabGroup& group) {
  const auto slab = [&](int i) LOOMSTONE_INLINE_LAMBDA {
    return i < n_slabs ? group.low[i] : group.high[i - n_slabs];
  };
  if constexpr (in_halves<Floats>) {
    for (int i = 0; i < 2 * n_slabs; ++i)
      for (int lane = 0; lane < slab_lanes; ++lane)
        slab(i)[lane] = i < n_slabs ? item[lane].value[i] : -item[lane].value[i];
  } else {
    for (int first = 0; first < 2 * n_slabs; first += slab_lanes) {
      Floats row[slab_lanes];
      for (int lane = 0; lane < slab_lanes; ++lane)
        row[lane] = lanes_load<Floats>(item[lane].value + first);
      transpose(row);
      for (int i = first; i < std::min(first + slab_lanes, 2 * n_slabs); ++i)
        lanes_store(slab(i), i < n_slabs ? row[i - first] : -row[i - first]);
    }
  }
}

template <class Floats>
LOOMSTONE_INLINE void include(PackedSlabs& a, const PackedSlabs& b) {
  for (int i = 0; i < n_slab_packs * slab_lanes; i += slab_lanes)
    lanes_store(a.value + i,
                lanes_min(lanes_load<Floats>(a.value + i), lanes_load<Floats>(b.value + i)));
}

template <class Floats>
LOOMSTONE_INLINE PackedSlabs all_of(const PackedSlabs* item) {
  PackedSlabs all = item[0];
  for (int lane = 1; lane < slab_lanes; ++lane) include<Floats>(all, item[lane]);
  return all;
}

// Range [begin, end) of feature groups; see ClusterTree::Features.
struct FeatureGroups {
  const Index* corners;
  int n_corners;
  Index begin, end;
};

// Computes the boxes of features (`slabs`) and of whole groups (`of_group`) from vertex boxes. The
// first entry of each output belongs to group groups.begin. Either output may be null.
template <class Lanes>
LOOMSTONE_INLINE void refit_features(VertexBoxes::View vertices, const FeatureGroups& groups,
                                     SlabGroup* slabs, PackedSlabs* of_group) {
  using Floats = FloatLanes<Lanes>;
  const PackedSlabs none = empty_packed();
  const int n_corners = groups.n_corners;
  for (Index g = groups.begin; g < groups.end; ++g) {
    const Index* const corner =
        groups.corners + static_cast<std::size_t>(g) * n_corners * slab_lanes;
    PackedSlabs item[slab_lanes];
    for (int lane = 0; lane < slab_lanes; ++lane) {
      item[lane] = corner[lane] >= 0 ? vertices[corner[lane]] : none;
      if (corner[lane] >= 0)
        for (int k = 1; k < n_corners; ++k)
          include<Floats>(item[lane], vertices[corner[k * slab_lanes + lane]]);
    }
    if (slabs) write_group<Floats>(item, slabs[g - groups.begin]);
    if (of_group) of_group[g - groups.begin] = all_of<Floats>(item);
  }
}

// For nodes [begin, end) of a level, stores the boxes of their children (`below`) as groups in
// `slabs`, and computes the boxes of the nodes (`of_group`). `below` must be padded to full groups
// with empty boxes.
template <class Lanes>
LOOMSTONE_INLINE void refit_groups(const PackedSlabs* below, Index begin, Index end,
                                   SlabGroup* slabs, PackedSlabs* of_group) {
  for (Index g = begin; g < end; ++g) {
    write_group<FloatLanes<Lanes>>(below + slab_lanes * g, slabs[g]);
    of_group[g] = all_of<FloatLanes<Lanes>>(below + slab_lanes * g);
  }
}

// Makes room for at least n elements. Discards all existing elements if there is not enough room.
template <class Boxes>
void make_room(Boxes& boxes, std::size_t n) {
  if (boxes.size() >= n) return;
  boxes = Boxes();
  boxes.resize(n);
}

double area(const PackedSlabs& s, double inflation) {
  double side[3];
  for (int k = 0; k < 3; ++k)
    side[k] = -static_cast<double>(s.value[n_slabs + k]) - s.value[k] - 2.0 * inflation;
  return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

// Orders items so that consecutive items form compact nodes: bisects the items recursively along
// the longest axis of the box around their centres. The first half of each bisection fills whole
// nodes.
void order_by_halves(const Points& centres, Index* items, Index n) {
  if (n <= slab_lanes) return;
  Eigen::RowVector3d low = centres.row(items[0]), high = low;
  for (Index i = 1; i < n; ++i) {
    low = low.cwiseMin(centres.row(items[i]));
    high = high.cwiseMax(centres.row(items[i]));
  }
  int axis;
  (high - low).maxCoeff(&axis);
  Index node = slab_lanes;  // largest size of a full node that is less than n [items]
  while (node * slab_lanes < n) node *= slab_lanes;
  const Index half = std::max<Index>(1, (n / 2 + node / 2) / node) * node;
  std::nth_element(items, items + half, items + n, [&](Index i, Index j) {
    return centres(i, axis) != centres(j, axis) ? centres(i, axis) < centres(j, axis) : i < j;
  });
  order_by_halves(centres, items, half);
  order_by_halves(centres, items + half, n - half);
}

}  // namespace

ClusterTree::ClusterTree(const CollisionModel& model, std::vector<Index> triangles,
                         std::vector<Index> edges, std::vector<Index> foreign)
    : model_(&model),
      n_triangles_(static_cast<Index>(triangles.size())),
      n_edges_(static_cast<Index>(edges.size())),
      triangles_(std::move(triangles)),
      edges_(std::move(edges)),
      foreign_(std::move(foreign)) {
  for (std::vector<Index>* const ids : {&triangles_, &edges_}) ids->shrink_to_fit();
  std::sort(foreign_.begin(), foreign_.end());
  foreign_.erase(std::unique(foreign_.begin(), foreign_.end()), foreign_.end());
  foreign_.shrink_to_fit();
  n_clusters_ = (n_triangles_ + slab_lanes - 1) / slab_lanes;
}

// The edges of the model are sorted by vertices, so the edges of a surface are consecutive.
ClusterTree::ClusterTree(const CollisionModel& model, Index surface)
    : model_(&model),
      first_triangle_(model.surfaces[surface].first_triangle),
      n_triangles_(model.surfaces[surface].n_triangles) {
  const Index first = model.surfaces[surface].first_vertex,
              last = first + model.surfaces[surface].n_vertices;
  const auto firsts = model.edges.col(0);
  const auto edge_of = [&](Index vertex) {
    return static_cast<Index>(std::lower_bound(firsts.begin(), firsts.end(), vertex) -
                              firsts.begin());
  };
  first_edge_ = edge_of(first);
  n_edges_ = edge_of(last) - first_edge_;
  n_clusters_ = (n_triangles_ + slab_lanes - 1) / slab_lanes;
}

void ClusterTree::add_levels() {
  Index n = n_clusters_;
  do {
    n = std::max<Index>(1, (n + slab_lanes - 1) / slab_lanes);
    levels_.emplace_back(n);
  } while (n > 1);
}

Slabs ClusterTree::root() const {
  Slabs box;
  for (int k = 0; k < n_slabs; ++k) {
    box.low[k] = root_.low[k][0];
    box.high[k] = root_.high[k][0];
  }
  return box;
}

// Arranges features in groups by their clusters. Sets the id of each feature to its index in
// `cluster_of_feature`.
void ClusterTree::assign(Features& features, const std::vector<Index>& cluster_of_feature,
                         int n_corners) const {
  std::vector<Index> next(n_clusters_, 0);
  for (const Index c : cluster_of_feature) ++next[c];
  features.group.assign(n_clusters_ + 1, 0);
  for (Index c = 0; c < n_clusters_; ++c) {
    features.group[c + 1] = features.group[c] + (next[c] + slab_lanes - 1) / slab_lanes;
    next[c] = slab_lanes * features.group[c];
  }
  const std::size_t n_groups = features.group[n_clusters_];
  features.slabs.clear();
  if (n_corners > 1) features.first_slab.assign(n_clusters_, 0);
  features.id.assign(slab_lanes * n_groups, -1);
  features.n_corners = n_corners;
  for (std::size_t i = 0; i < cluster_of_feature.size(); ++i)
    features.id[next[cluster_of_feature[i]]++] = static_cast<Index>(i);
}

// Sets the corners of groups of faces or edges; see Features::corners.
void ClusterTree::find_corners(const Features& features, IndexRange groups, Index* corners) const {
  const int n_corners = features.n_corners;
  const Index* const of_feature =
      &features == &faces_ ? model_->triangles.data() : model_->edges.data();
  for (Index g = groups.begin; g < groups.end; ++g, corners += n_corners * slab_lanes)
    for (int lane = 0; lane < slab_lanes; ++lane) {
      const Index id = features.id[slab_lanes * g + lane];
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(n_corners) * id;
      for (int k = 0; k < n_corners; ++k)
        corners[k * slab_lanes + lane] = id >= 0 ? of_feature[first + k] : -1;
    }
}

// Forms clusters of faces that are compact at x. Returns the cluster of each face.
std::vector<Index> ClusterTree::clusters_of_faces(const Points& x) const {
  const Index n = n_triangles_;
  const auto corner = [&](Index t, int k) { return model_->triangles(triangle_id(t), k); };
  Points centres(n, 3);
  for (Index t = 0; t < n; ++t)
    centres.row(t) = (x.row(corner(t, 0)) + x.row(corner(t, 1)) + x.row(corner(t, 2))) / 3.0;
  std::vector<Index> order(n), cluster_of_face(n);
  for (Index t = 0; t < n; ++t) order[t] = t;
  order_by_halves(centres, order.data(), n);
  for (Index i = 0; i < n; ++i) cluster_of_face[order[i]] = i / slab_lanes;
  return cluster_of_face;
}

void ClusterTree::form(const Points& x) {
  ++version_;
  if (levels_.empty()) add_levels();
  const std::vector<Index> cluster_of_face = clusters_of_faces(x);
  const Index n = n_triangles_;
  const auto corner = [&](Index t, int k) { return model_->triangles(triangle_id(t), k); };
  // Assigns each edge, and each vertex that is not foreign, to one of the clusters that contain its
  // faces: the one with the fewest edges (or vertices) so far, which leaves few lanes empty.
  Index first = n > 0 ? corner(0, 0) : 0, last = first - 1;
  for (Index i = 0; i < 3 * n; ++i) {
    first = std::min(first, corner(i / 3, i % 3));
    last = std::max(last, corner(i / 3, i % 3));
  }
  const Index n_vertices = last - first + 1;
  std::vector<Index> start(n_vertices + 2, 0),
      faces_of(3 * static_cast<std::size_t>(n));  // faces of all vertices, sorted by vertex
  for (Index i = 0; i < 3 * n; ++i) ++start[corner(i / 3, i % 3) - first + 2];
  for (Index i = 0; i < n_vertices; ++i) start[i + 2] += start[i + 1];
  for (Index i = 0; i < 3 * n; ++i) faces_of[start[corner(i / 3, i % 3) - first + 1]++] = i / 3;
  std::vector<Index> owned;
  const auto give = [&](Index vertex, Index other_vertex) {
    Index cluster = -1;
    for (Index i = start[vertex - first]; i < start[vertex - first + 1]; ++i) {
      const Index t = faces_of[i];
      if (other_vertex >= 0 &&
          (model_->triangles.row(triangle_id(t)).array() != other_vertex).all())
        continue;
      const Index c = cluster_of_face[t];
      if (cluster < 0 || owned[c] < owned[cluster]) cluster = c;
    }
    ++owned[cluster];
    return cluster;
  };
  std::vector<Index> vertices, cluster_of_vertex, cluster_of_edge;
  owned.assign(n_clusters_, 0);
  for (Index i = 0; i < n_vertices; ++i) {
    if (start[i] == start[i + 1]) continue;
    if (std::binary_search(foreign_.begin(), foreign_.end(), first + i)) continue;
    vertices.push_back(first + i);
    cluster_of_vertex.push_back(give(first + i, -1));
  }
  owned.assign(n_clusters_, 0);
  for (Index e = 0; e < n_edges_; ++e)
    cluster_of_edge.push_back(give(model_->edges(edge_id(e), 0), model_->edges(edge_id(e), 1)));

  assign(faces_, cluster_of_face, 3);
  assign(edge_features_, cluster_of_edge, 2);
  assign(vertices_, cluster_of_vertex, 1);
  for (Index& id : faces_.id)
    if (id >= 0) id = triangle_id(id);
  for (Index& id : edge_features_.id)
    if (id >= 0) id = edge_id(id);
  vertices_.corners = std::move(vertices_.id);
  for (Index& vertex : vertices_.corners)
    if (vertex >= 0) vertex = vertices[vertex];
  has_all_corners_ = false;
}

std::size_t ClusterTree::n_slots() const {
  return static_cast<std::size_t>((n_clusters_ + slab_lanes - 1) / slab_lanes) * slab_lanes;
}

void ClusterTree::find_boxes(const Team& team, const VertexBoxes& vertices, Index begin, Index end,
                             std::vector<PackedSlabs>& boxes) const {
  // A cluster has exactly one group of faces, so cluster indices are also group indices.
  constexpr Index at_once = 16;  // number of groups whose corners are found at once
  parallel_ranges(team, end - begin, refit_grain, [&](Index first, Index last) {
    Index corners[at_once * 3 * slab_lanes];
    for (Index group = begin + first; group < begin + last; group += at_once) {
      const Index n = std::min(at_once, begin + last - group);
      find_corners(faces_, {group, group + n}, corners);
      LOOMSTONE_WIDEST(refit_features)
      (vertices.view(), FeatureGroups{corners, faces_.n_corners, 0, n}, nullptr,
       boxes.data() + group);
    }
  });
}

void ClusterTree::set_area(const std::vector<PackedSlabs>& boxes, double inflation) {
  double sum = 0.0;
  for (Index c = 0; c < n_clusters_; ++c) sum += area(boxes[c], inflation);
  built_area_ = std::max(0.0, sum);
}

bool ClusterTree::has_grown(const std::vector<PackedSlabs>& boxes, double inflation) const {
  double sum = 0.0;
  for (Index c = 0; c < n_clusters_; ++c) sum += area(boxes[c], inflation);
  return !(sum <= decay_limit * built_area_);
}

void ClusterTree::set_nodes(const Team& team, const std::vector<PackedSlabs>& boxes) {
  std::vector<PackedSlabs> below, above;
  const PackedSlabs* children = boxes.data();
  for (std::vector<SlabGroup>& level : levels_) {
    const Index n = static_cast<Index>(level.size());
    above.assign(static_cast<std::size_t>((n + slab_lanes - 1) / slab_lanes) * slab_lanes,
                 empty_packed());
    parallel_ranges(team, n, refit_grain, [&](Index begin, Index end) {
      LOOMSTONE_WIDEST(refit_groups)(children, begin, end, level.data(), above.data());
    });
    below.swap(above);
    children = below.data();
  }
  write_group<FloatLanes<Lanes128>>(children, root_);
}

std::vector<PackedSlabs> ClusterTree::refit_all(const Team& team, const VertexBoxes& vertices) {
  std::vector<PackedSlabs> boxes(n_slots(), empty_packed());
  const auto refit = [&](Features& of, PackedSlabs* of_group) {
    const Index n = of.group[n_clusters_];
    make_room(of.slabs, n);
    const std::size_t lanes_of_group = static_cast<std::size_t>(of.n_corners) * slab_lanes;
    make_room(of.corners, n * lanes_of_group);
    std::copy_n(of.group.begin(), n_clusters_, of.first_slab.begin());
    parallel_ranges(team, n, refit_grain, [&](Index begin, Index end) {
      if (!has_all_corners_)
        find_corners(of, {begin, end}, of.corners.data() + begin * lanes_of_group);
      const FeatureGroups groups = {of.corners.data(), of.n_corners, begin, end};
      LOOMSTONE_WIDEST(refit_features)
      (vertices.view(), groups, of.slabs.data() + begin, of_group ? of_group + begin : nullptr);
    });
  };
  refit(edge_features_, nullptr);
  refit(faces_, boxes.data());  // each cluster has exactly one group of faces
  has_all_corners_ = true;
  vertex_boxes_ = &vertices;
  cluster_boxes_.assign(boxes.begin(), boxes.begin() + n_clusters_);
  set_nodes(team, boxes);
  return boxes;
}

void ClusterTree::refit(const Team& team, const Points& x, const VertexBoxes& vertices,
                        double inflation, bool may_rebuild) {
  if (empty()) return;
  if (formed()) {
    const std::vector<PackedSlabs> boxes = refit_all(team, vertices);
    if (!may_rebuild || !has_grown(boxes, inflation)) return;
  }
  form(x);
  set_area(refit_all(team, vertices), inflation);
}

void ClusterTree::refit_nodes(const Team& team, const Points& x, const VertexBoxes& vertices,
                              double inflation, bool may_rebuild) {
  if (empty()) return;
  std::vector<PackedSlabs> boxes(n_slots(), empty_packed());
  const auto find = [&] { find_boxes(team, vertices, 0, n_clusters_, boxes); };
  if (formed()) find();
  if (!formed() || (may_rebuild && has_grown(boxes, inflation))) {
    form(x);
    find();
    set_area(boxes, inflation);
  }
  set_nodes(team, boxes);
}

void ClusterTree::refit_features_of(const Team& team, const std::vector<std::uint8_t>& marked,
                                    const VertexBoxes& vertices) {
  vertex_boxes_ = &vertices;
  Index n_faces = 0, n_edges = 0;  // numbers of groups in the marked clusters so far
  for (Index c = 0; c < n_clusters_; ++c) {
    if (!marked[c]) continue;
    faces_.first_slab[c] = n_faces++;  // each cluster has exactly one group of faces
    edge_features_.first_slab[c] = n_edges;
    n_edges += edge_features_.group[c + 1] - edge_features_.group[c];
  }
  make_room(faces_.slabs, n_faces);
  make_room(edge_features_.slabs, n_edges);
  make_room(cluster_boxes_, n_faces);
  for (Features* const f : {&faces_, &edge_features_})
    make_room(f->corners, f->slabs.size() * f->n_corners * slab_lanes);
  has_all_corners_ = false;
  const auto refit = [&](Features& features, Index cluster, PackedSlabs* of_group) {
    const IndexRange groups{features.group[cluster], features.group[cluster + 1]};
    const std::size_t first = features.first_slab[cluster];
    Index* const corners = features.corners.data() + first * features.n_corners * slab_lanes;
    find_corners(features, groups, corners);
    LOOMSTONE_WIDEST(refit_features)
    (vertices.view(), FeatureGroups{corners, features.n_corners, 0, groups.end - groups.begin},
     features.slabs.data() + first, of_group);
  };
  parallel_for(
      team, n_clusters_,
      [&](Index c) {
        if (!marked[c]) return;
        refit(edge_features_, c, nullptr);
        refit(faces_, c, cluster_boxes_.data() + faces_.first_slab[c]);
      },
      64);
}

std::size_t ClusterTree::bytes() const {
  std::size_t n = 0;
  for (const Features* const f : {&faces_, &edge_features_, &vertices_})
    n += bytes_of(f->slabs, f->first_slab, f->id, f->group, f->corners);
  for (const auto& level : levels_) n += level.capacity() * sizeof(SlabGroup);
  n += cluster_boxes_.capacity() * sizeof(PackedSlabs);
  return n + bytes_of(triangles_, edges_, foreign_);
}

}  // namespace loomstone
