// A source as groups of eight parts, charged faces or dipoles. Groups provide the multipole moments
// of an expanded field (expanded_field.h) and are summed exactly near a point, with eight parts in
// lanes.
#pragma once

#include <memory>
#include <vector>

#include "core/magnetics/fast_sums/taylor_expansion.h"
#include "core/magnetics/sources/dipoles.h"
#include "core/magnetics/sources/polyhedron.h"

namespace loomstone {

// Order of expansions and opening criterion: two cells are far apart if the sum of their radii is
// less than `opening` times the distance of their centres. error: of the gradient, relative to its
// largest value at the same distance from the source [1].
struct ExpansionSetting {
  int order;
  double opening, error;
};

// Indices of the groups to sum, in the order in which they were added.
struct GroupList {
  const Index* places;
  Index n;
};

class SourceGroups {
 public:
  virtual ~SourceGroups() = default;
  virtual Index n_parts() const = 0;
  virtual double radius() const = 0;          // of the bounding ball about the origin [m]
  virtual Vec3 middle(Index part) const = 0;  // [m]
  virtual double reach(Index part, const Vec3& from) const = 0;  // to the part's farthest point [m]
  // Adds a group of up to eight parts, and its multipole moments about `centre`.
  virtual void add(const Index* parts, Index n, const TaylorExpansion& expansion,
                   const Vec3& centre, double* moments) = 0;
  // mu0 H [T] and its gradient (xx, xy, xz, yy, yz, zz) [T/m] of groups at one point.
  virtual void sum(GroupList groups, const double* point, double* field,
                   double* gradient) const = 0;
  // Expansion of all parts, for points beyond 2 radii.
  virtual const MultipoleExpansion& multipoles() const = 0;
  // Number of groups whose sum takes about as long as evaluating an expansion.
  virtual Index few() const = 0;
  // Fastest first; the last has the smallest error, 3e-7.
  virtual std::vector<ExpansionSetting> settings() const = 0;
};

// The charged faces of a magnet.
class FaceGroups final : public SourceGroups {
 public:
  explicit FaceGroups(std::shared_ptr<const Polyhedron> mesh);
  Index n_parts() const override { return static_cast<Index>(corners_.size() / 3); }
  double radius() const override { return mesh_->radius(); }
  Vec3 middle(Index part) const override;
  double reach(Index part, const Vec3& from) const override;
  void add(const Index* parts, Index n, const TaylorExpansion& expansion, const Vec3& centre,
           double* moments) override;
  void sum(GroupList groups, const double* point, double* field, double* gradient) const override;
  const MultipoleExpansion& multipoles() const override { return mesh_->multipoles(); }
  Index few() const override { return 8; }
  std::vector<ExpansionSetting> settings() const override;

 private:
  std::shared_ptr<const Polyhedron> mesh_;
  std::vector<Vec3> corners_;   // three of each face
  std::vector<double> tables_;  // by groups
};

class DipoleGroups final : public SourceGroups {
 public:
  DipoleGroups(const DipoleSet& dipoles, double radius);
  Index n_parts() const override { return static_cast<Index>(positions_.rows()); }
  double radius() const override { return radius_; }
  Vec3 middle(Index part) const override { return positions_.row(part).transpose(); }
  double reach(Index part, const Vec3& from) const override { return (middle(part) - from).norm(); }
  void add(const Index* parts, Index n, const TaylorExpansion& expansion, const Vec3& centre,
           double* moments) override;
  void sum(GroupList groups, const double* point, double* field, double* gradient) const override;
  const MultipoleExpansion& multipoles() const override { return multipoles_; }
  Index few() const override { return 32; }
  std::vector<ExpansionSetting> settings() const override;

 private:
  double radius_;
  Points positions_, moments_;  // moments times mu0 / 4 pi [m], [T m^3]
  std::vector<double> tables_;  // by groups
  MultipoleExpansion multipoles_;
};

}  // namespace loomstone
