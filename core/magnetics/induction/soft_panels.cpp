// Magnetically linear bodies, modelled by boundary elements on flat panels. Cuboids and cylinders
// use Richardson extrapolation over several grids. Meshes use a single grid.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "core/base/message.h"
#include "core/magnetics/induction/applied_field.h"
#include "core/magnetics/induction/boundary_element.h"
#include "core/magnetics/induction/soft_shape.h"
#include "core/magnetics/sources/axisymmetric.h"
#include "core/magnetics/sources/charged_panels.h"
#include "core/magnetics/sources/constants.h"
#include "core/magnetics/sources/polyhedron.h"
#include "core/mesh/triangle_mesh.h"

namespace loomstone {

namespace {

// Number of points in each direction of a panel at which the field is sampled and forces act.
constexpr int points_a_direction = 3;
constexpr Index most_panels = 8000;  // limits the matrix to 0.5 GB
// Limits the matrices of a grid to 0.6 GB: one for each of the eight symmetries of the charge (see
// cuboid_boundary_elements()).
constexpr Index most_cuboid_panels = 24000;

// One grid on the surface, its matrix, and its weights in the extrapolated response and in the
// estimate of the error.
struct Grid {
  std::vector<FlatPanel> panels;
  std::shared_ptr<const BoundaryElements> flux;
  double share = 1.0, error_share = 0.0;
};

struct PanelForm {
  std::vector<Grid> grids;
  std::shared_ptr<const PanelSet> set;  // the panels of all grids
  SourcePtr solid;
  double volume = 0.0, area = 0.0;  // [m^3], [m^2]
  SourceRecipe recipe;              // without the susceptibility
};

class SoftPanels final : public SoftShape {
 public:
  SoftPanels(std::shared_ptr<const PanelForm> form, double susceptibility)
      : form_(std::move(form)), susceptibility_(susceptibility) {
    for (const Grid& grid : form_->grids) factors_.push_back(grid.flux->factor(susceptibility));
  }

  const Points& samples() const override { return form_->set->samples; }
  Vector received(const Points& field) const override {
    const PanelSet& set = *form_->set;
    Vector fluxes = Vector::Zero(set.panels.size());
    for (Eigen::Index i = 0; i < field.rows(); ++i) {
      const Eigen::Index panel = i / set.per_panel;
      fluxes[panel] += set.shares[i] * set.panels[panel].area *
                       set.panels[panel].normal.dot(field.row(i).transpose());
    }
    return fluxes;
  }
  Vector response(const Vector& received) const override {
    Vector charges(received.size());
    Eigen::Index at = 0;
    for (std::size_t g = 0; g < factors_.size(); ++g) {
      const auto n = static_cast<Eigen::Index>(form_->grids[g].panels.size());
      charges.segment(at, n) = form_->grids[g].share * factors_[g]->solve(received.segment(at, n));
      at += n;
    }
    return charges;
  }
  SourcePtr source(const Vector& charges) const override {
    return std::make_shared<ChargedPanels>(form_->set, charges, form_->solid);
  }
  // On a flat face, the applied field H directly induces the charge sigma = n.H / (1/chi + 1/2),
  // which varies as rapidly as H. Only the finest grid carries this charge. A panel carries
  // the mean of this charge over the panel, and its samples carry the deviations from that mean. In
  // place of a bisected panel, its parts carry the charge. The rest of the charge is due to the
  // charge on other faces. This rest is smooth and stays on the panels of all grids.
  SourcePtr source(const Vector& charges, const AppliedField& applied) const override {
    const double slope = 1.0 / (1.0 / susceptibility_ + 0.5);
    const PanelSet& set = *form_->set;
    Vector rest = charges;
    Eigen::Index at = 0, finest = 0;
    double mean = 0.0;  // mean normal field [T]; 0 by Gauss' law, except for quadrature errors
    for (const Grid& grid : form_->grids) {
      finest = at;
      const auto n = static_cast<Eigen::Index>(grid.panels.size());
      mean = applied.fluxes.segment(at, n).sum() / form_->area;
      for (; at < finest + n; ++at)
        rest[at] -= grid.share * slope * (applied.fluxes[at] / set.panels[at].area - mean);
    }
    ChargedPanels::Fine fine;
    fine.panel_means = source(charges);
    fine.errors = errors_of(rest);
    fine.at_samples = Vector::Zero(set.samples.rows());
    for (at = finest; at < rest.size(); ++at) {
      if (applied.halved[at]) continue;
      const double whole = applied.fluxes[at] / set.panels[at].area;
      rest[at] += slope * (whole - mean);
      for (Eigen::Index i = at * set.per_panel; i < (at + 1) * set.per_panel; ++i)
        fine.at_samples[i] =
            slope * set.shares[i] * set.panels[at].area * (applied.normal[i] - whole);
    }
    std::vector<double> means;
    for (const AppliedField::Leaf& leaf : applied.leaves) {
      if (leaf.parent < finest) continue;
      fine.parts.push_back(leaf.panel);
      means.push_back(0.0);
      for (int k = 0; k < AppliedField::points; ++k) {
        PanelSample sample;
        sample.position = leaf.positions[k];
        sample.area = leaf.areas[k] * leaf.panel.normal;
        sample.charge = leaf.areas[k] / mu0 * slope * (leaf.normal[k] - mean);
        means.back() += mu0 * sample.charge / leaf.panel.area;
        fine.samples.push_back(sample);
      }
    }
    fine.charges = Eigen::Map<const Vector>(means.data(), static_cast<Eigen::Index>(means.size()));
    return std::make_shared<ChargedPanels>(form_->set, rest, form_->solid, std::move(fine));
  }
  // Because div H = 0, the volume integral of H equals the surface integral of x (H.n).
  Vec3 mean_field(const Vector& received) const override {
    Vec3 sum = Vec3::Zero();
    Eigen::Index at = 0;
    for (const Grid& grid : form_->grids)
      for (const FlatPanel& panel : grid.panels) sum += grid.share * received[at++] * panel.centre;
    return sum / form_->volume;
  }
  std::shared_ptr<const PanelSet> panels() const override { return form_->set; }
  double volume() const override { return form_->volume; }
  double radius() const override { return form_->set->radius; }
  SourcePtr solid() const override { return form_->solid; }
  SourceRecipe recipe() const override {
    SourceRecipe recipe = form_->recipe;
    recipe.values.emplace_back("susceptibility", susceptibility_);
    return recipe;
  }
  double susceptibility() const override { return susceptibility_; }
  SoftShapePtr with_susceptibility(double susceptibility) const override {
    if (susceptibility == susceptibility_) return std::make_shared<SoftPanels>(*this);
    return std::make_shared<SoftPanels>(form_, susceptibility);
  }

 private:
  // Returns the estimated errors of the extrapolated charges, or an empty vector if there is only
  // one grid.
  Vector errors_of(const Vector& charges) const {
    if (form_->grids.size() == 1) return {};
    Vector errors = charges;
    Eigen::Index at = 0;
    for (const Grid& grid : form_->grids) {
      const auto n = static_cast<Eigen::Index>(grid.panels.size());
      errors.segment(at, n) *= grid.error_share / grid.share;
      at += n;
    }
    return errors;
  }

  std::shared_ptr<const PanelForm> form_;
  double susceptibility_;
  std::vector<std::shared_ptr<const BoundaryElements::Factors>> factors_;
};

SoftShapePtr panels_of(PanelForm form, double susceptibility) {
  std::vector<FlatPanel> all;
  std::vector<PanelGrid> grids;
  for (const Grid& grid : form.grids) {
    const auto begin = static_cast<Index>(all.size());
    all.insert(all.end(), grid.panels.begin(), grid.panels.end());
    grids.push_back({begin, static_cast<Index>(all.size()), grid.share});
  }
  for (const FlatPanel& panel : form.grids.back().panels) form.area += panel.area;
  form.set = std::make_shared<const PanelSet>(std::move(all), points_a_direction, std::move(grids));
  return std::make_shared<SoftPanels>(std::make_shared<const PanelForm>(std::move(form)),
                                      susceptibility);
}

// Returns the numbers of cells of the three grids for extrapolation: half of `cells`, about 0.7 of
// `cells`, and `cells`. The solution on a grid has errors of second and third order in 1 / cells.
std::vector<int> three_grids(int cells) {
  return {cells / 2, 2 * static_cast<int>(std::lround(0.35 * cells)), cells};
}

// Returns the weights of Richardson extrapolation from n grids, whose numbers of cells are
// `counts`. The extrapolation cancels errors of the n - 1 given `orders` in 1 / cells.
Vector extrapolation(const std::vector<int>& counts, const std::vector<int>& orders) {
  const auto n = static_cast<Index>(counts.size());
  DenseMatrix powers = DenseMatrix::Ones(n, n);
  for (Index g = 0; g < n; ++g)
    for (Index k = 1; k < n; ++k) powers(k, g) = std::pow(counts[g], -1.0 * orders[k - 1]);
  return powers.inverse() * Vector::Unit(n, 0);
}

// grids_of() returns the grids of a body, coarsest first. Extrapolation cancels errors of orders 2
// and 3 in 1 / cells if there are three grids, and of order 2 if there are two. The estimated error
// is the difference from an extrapolation that cancels orders 2 and 4 (three grids) or order 3
// (two grids).
using MakePanels = std::function<std::vector<FlatPanel>(int cells)>;
using MakeElements = std::unique_ptr<BoundaryElements> (*)(const Team&,
                                                           const std::vector<FlatPanel>&);
std::vector<Grid> grids_of(const Team& team, const std::vector<int>& counts,
                           const MakePanels& panels, MakeElements elements) {
  const bool three = counts.size() == 3;
  const Vector shares = extrapolation(counts, three ? std::vector{2, 3} : std::vector{2});
  const Vector others = extrapolation(counts, three ? std::vector{2, 4} : std::vector{3});
  std::vector<Grid> grids(counts.size());
  for (std::size_t g = 0; g < counts.size(); ++g) {
    const auto row = static_cast<Eigen::Index>(g);
    grids[g].panels = panels(counts[g]);
    grids[g].flux = elements(team, grids[g].panels);
    grids[g].share = shares[row];
    grids[g].error_share = shares[row] - others[row];
  }
  return grids;
}

void check_panels(Index panels, Index most, int cells, const char* shape) {
  if (panels > most)
    fail<InvalidInput>("a {} must have at most {} panels, got {} with {} cells; take fewer cells",
                       shape, most, panels, cells);
}

}  // namespace

void check_cells(int cells, const std::string& shape, const std::string& name) {
  const int most = shape == "cylinder" ? 24 : 48;
  if (cells < 8 || cells > most || cells % 4 != 0)
    fail<InvalidInput>("{} of a {} must be a multiple of 4 from 8 to {}, got {}", name, shape, most,
                       cells);
}

SoftShapePtr soft_cuboid(const Team& team, const Vec3& size, double susceptibility, int cells,
                         double focus) {
  check_susceptibility(susceptibility);
  PanelForm form;
  form.solid = std::make_shared<Cuboid>(size, Vec3(0, 0, 1));  // checks the size
  form.volume = size.prod();
  form.recipe = {"soft_cuboid",
                 {{"size", size}, {"cells", static_cast<double>(cells)}, {"focus", focus}},
                 {},
                 {}};
  check_cells(cells, "cuboid");
  if (!(focus >= 0.0) || !std::isfinite(focus))
    fail<InvalidInput>("focus must be >= 0 [m], got {}", focus);
  // A focus concentrates the panels opposite the magnet. Errors of coarse grids are then not of
  // second order. Only two grids are therefore used, and the coarser one has at least three
  // quarters of `cells` panels along each edge.
  std::vector<int> counts = three_grids(cells);
  if (focus > 0.0) counts = {2 * static_cast<int>(std::lround(0.375 * cells)), cells};
  const auto panels = [&](int count) { return cuboid_panels(size, count, focus); };
  check_panels(static_cast<Index>(panels(cells).size()), most_cuboid_panels, cells, "cuboid");
  form.grids = grids_of(team, counts, panels, cuboid_boundary_elements);
  return panels_of(std::move(form), susceptibility);
}

SoftShapePtr soft_cylinder(const Team& team, double radius, double height, double inner_radius,
                           double susceptibility, int cells) {
  check_susceptibility(susceptibility);
  PanelForm form;
  form.solid =
      std::make_shared<Cylinder>(radius, height, Vec3(0, 0, 1), inner_radius);  // checks the sizes
  form.volume = form.solid->moment().norm() * mu0;
  form.recipe = {"soft_cylinder",
                 {{"radius", radius},
                  {"height", height},
                  {"inner_radius", inner_radius},
                  {"cells", static_cast<double>(cells)}},
                 {},
                 {}};
  check_cells(cells, "cylinder");
  // Smallest allowed height and wall thickness [radii]. Panels would be far wider than a thinner
  // wall.
  constexpr double thinnest = 0.02;
  if (const double thin = std::min(height, radius - inner_radius); thin < thinnest * radius)
    fail<Unsupported>(
        "height and wall must be at least {} m, a fiftieth of the radius of a cylinder that "
        "magnetises, got {}; give a mesh with smaller panels",
        thinnest * radius, thin);
  const auto panels = [&](int count) {
    return cylinder_panels(radius, inner_radius, height, count);
  };
  check_panels(static_cast<Index>(panels(cells).size()), most_panels, cells, "cylinder");
  form.grids = grids_of(team, three_grids(cells), panels, mesh_boundary_elements);
  return panels_of(std::move(form), susceptibility);
}

SoftMesh soft_mesh(const Team& team, const TriangleMesh& mesh, double susceptibility,
                   Index panels) {
  const RigidPose pose = make_mesh_magnet(mesh, Vec3(0, 0, 1)).pose;  // checks the mesh
  return {soft_mesh_shape(team, mesh.moved(-pose.position), susceptibility, panels), pose};
}

SoftShapePtr soft_mesh_shape(const Team& team, const TriangleMesh& mesh, double susceptibility,
                             Index panels) {
  check_susceptibility(susceptibility);
  if (panels < 0 || panels > most_panels)
    fail<InvalidInput>("panels must be in [0, {}], got {}", most_panels, panels);
  if (mesh.n_triangles() > most_panels)
    fail<InvalidInput>("a mesh that magnetises must have at most {} triangles, got {}; simplify it",
                       most_panels, mesh.n_triangles());
  PanelForm form;
  form.solid = std::make_shared<MeshMagnet>(mesh, Vec3(0, 0, 1));
  form.volume = form.solid->moment().norm() * mu0;
  form.recipe = {"soft_mesh",
                 {{"panels", static_cast<double>(panels)}},
                 std::make_shared<const TriangleMesh>(mesh.vertices(), mesh.triangles()),
                 {}};
  Grid grid;
  grid.panels = mesh_panels(mesh, panels);
  grid.flux = mesh_boundary_elements(team, grid.panels);
  form.grids.push_back(std::move(grid));
  return panels_of(std::move(form), susceptibility);
}

}  // namespace loomstone
