// A source as groups of up to eight parts, which are charged faces or dipoles. Groups provide the
// multipole moments for expanded_field.h. Groups near a point are summed exactly, with one part per
// SIMD lane.
#pragma once

#include <memory>
#include <vector>

#include "core/magnetics/fast_sums/taylor_expansion.h"
#include "core/magnetics/sources/dipoles.h"
#include "core/magnetics/sources/polyhedron.h"

namespace loomstone {

// Order of expansions and opening criterion. A cube of the octree and a cluster of parts are far
// apart if the sum of their radii is less than `opening` times the distance between their centres.
// `error` is the error of the gradient, relative to its largest value at the same distance from the
// source [1].
struct ExpansionSetting {
  int order;
  double opening, error;
};

// Indices of the groups to sum. Groups are numbered in the order in which they were added.
struct GroupList {
  const Index* places;
  Index n;
};

class SourceGroups {
 public:
  virtual ~SourceGroups() = default;
  virtual Index n_parts() const = 0;
  virtual double radius() const = 0;          // radius of the bounding sphere about the origin [m]
  virtual Vec3 middle(Index part) const = 0;  // centre of a part [m]
  // Returns the distance from `from` to the farthest point of a part [m].
  virtual double reach(Index part, const Vec3& from) const = 0;
  // Adds a group of up to eight parts, and adds its multipole moments about `centre` to `moments`.
  virtual void add(const Index* parts, Index n, const TaylorExpansion& expansion,
                   const Vec3& centre, double* moments) = 0;
  // Computes mu0 H [T] and its gradient (xx, xy, xz, yy, yz, zz) [T/m] of the given groups at one
  // point.
  virtual void sum(GroupList groups, const double* point, double* field,
                   double* gradient) const = 0;
  // Returns the multipole expansion of all parts, for points at least 2 radii from the origin.
  virtual const MultipoleExpansion& multipoles() const = 0;
  // Returns the number of groups whose exact sum costs about as much as evaluating an expansion.
  virtual Index few() const = 0;
  // Returns the available settings, fastest first. The last one has the smallest error, 3e-7.
  virtual std::vector<ExpansionSetting> settings() const = 0;
};

// The charged faces of a magnet: those on which J.n, the normal component of the polarization, is
// not 0.
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
  std::vector<Vec3> corners_;   // three corners of each face [m]
  std::vector<double> tables_;  // kernel data of each group
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
  Points positions_, moments_;  // positions [m]; moments times mu0 / 4 pi [T m^3]
  std::vector<double> tables_;  // kernel data of each group
  MultipoleExpansion multipoles_;
};

}  // namespace loomstone
