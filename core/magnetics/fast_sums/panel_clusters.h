// Clusters of charged panels, for the field of one body at the panels of another. Between clusters
// that are far apart, charge and field are interpolated at Chebyshev nodes in their bounding boxes,
// as in the black-box fast multipole method [FongDarve2009]. A flat box has nodes in one plane.
// Panels of near clusters interact directly, and so do panels of far clusters with few panels.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/magnetics/sources/charged_panels.h"

namespace loomstone {

struct PanelCluster {
  Vec3 centre;                   // centre of the bounding box [m]
  double radius = 0.0;           // half the diagonal of the bounding box [m]
  double reach = 0.0;            // largest FlatPanel::reach of its panels [m]
  Index begin = 0, end = 0;      // range of its panels in the order of the clusters
  Index children[2] = {-1, -1};  // -1 for a leaf
  Points nodes;                  // positions of the Chebyshev nodes (n x 3) [m]
  // There is one column for the Lagrange polynomial of each node. In a leaf, the column contains
  // the integral of the polynomial over each panel (rows) [m^2]. In any other cluster, it contains
  // the values of the polynomial at the nodes of both children (rows) [1].
  Eigen::MatrixXd weights;

  bool leaf() const { return children[0] < 0; }
};

class PanelClusters {
 public:
  // Divides the panels [grid.begin, grid.end) of a set into clusters.
  PanelClusters(const PanelSet& set, const PanelGrid& grid);

  // Returns the panels in the order of the clusters.
  const PanelSet& panels() const { return panels_; }
  const std::vector<PanelCluster>& clusters() const { return clusters_; }  // parents first
  // Returns the indices of the clusters without parents. Each of these contains the panels whose
  // normals are closest to one of the six directions +-x, +-y and +-z.
  const std::vector<Index>& roots() const { return roots_; }

  // gathered() returns the values of the grid's panels in the order of the clusters, given the
  // values `all` of the whole set. scatter() adds `factor` times `own`, values of the grid's panels
  // in the order of the clusters, to the values `all` of the whole set.
  Vector gathered(const Vector& all) const;
  void scatter(const Vector& own, double factor, Vector& all) const;

  // Returns for each cluster the charges at its nodes, times mu0 [T m^2], that represent the charge
  // of its panels. `densities` contains mu0 sigma of each panel [T], in the order of the clusters.
  std::vector<Vector> node_charges(const Vector& densities) const;
  // Returns the flux that the charges of far clusters cause through each panel [T m^2], in the
  // order of the clusters. `fields` contains, for each cluster, the field of its far clusters at
  // its nodes (nodes x 3) [T]; see far_fields().
  Vector fluxes(std::vector<Points> fields) const;

 private:
  void add_nodes(PanelCluster& cluster) const;

  std::vector<Index> order_;  // row of each panel in the whole set
  PanelSet panels_;
  std::vector<PanelCluster> clusters_;
  std::vector<Index> roots_;
};

// Two interacting grids, one of each body. The charges of both grids contain the factor `share`,
// the weight of the grids in Richardson extrapolation, so fluxes and forces between the grids must
// be divided by it. If the grids of each body are combined, `share` is 1.
struct GridPair {
  PanelGrid one, other;
  double share = 1.0;
};
// Returns the pairs of grids through which two bodies interact. If the grids of both bodies have
// equal weights in Richardson extrapolation, each grid interacts only with the corresponding grid
// of the other body, and the solutions of the coupled problem are extrapolated. Otherwise, the
// grids of each body are combined into one, and every grid receives the field of the extrapolated
// charge. GMRES then needs more iterations, because charge that only some grids resolve is
// multiplied by weights of up to 3.6.
std::vector<GridPair> interacting_grids(const PanelSet& one, const PanelSet& other);

// For each cluster of `on`, `far` lists the clusters of `by` with which it interacts through
// Chebyshev nodes. For each leaf of `on`, `near` lists the leaves of `by` with which it interacts
// panel by panel. `pose` is the pose of `on` in the axes of `by`.
struct ClusterPairs {
  std::vector<std::vector<Index>> far, near;
  ClusterPairs(const PanelClusters& on, const RigidPose& pose, const PanelClusters& by);
};

// Returns, for each cluster of `on`, the field that the node charges of its far clusters cause at
// its nodes, in the axes of `on` (nodes x 3) [T]. `charges` are the node charges of each cluster of
// `by`; see node_charges().
std::vector<Points> far_fields(const Team& team, const ClusterPairs& pairs, const PanelClusters& on,
                               const RigidPose& pose, const PanelClusters& by,
                               const std::vector<Vector>& charges);

}  // namespace loomstone
