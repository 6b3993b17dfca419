// Tests of contact terms that are made for a part of the rows, as on each of several ranks, and of
// contact data that is kept between calls.
#include <catch2/catch.hpp>

#include <array>

#include "core/collision/collision_stage.h"
#include "tests/collision/collision_scenes.h"

using namespace loomstone;

namespace {

ContactState anchored(const std::vector<Contact>& contacts, double slip) {
  ContactState state;
  for (const Contact& c : contacts)
    state.anchors.push_back(
        {c.kind, c.a, c.b, slip * c.normal.unitOrthogonal() * double(c.a % 3), 1.0});
  return state;
}

TestScene two_sheets() {
  using Kind = CollisionSurface::Kind;
  return make_scene(
      {{grid_cells(0.1, 0.1, 6, 6), Kind::Cloth, 4e-3},
       {grid_cells(0.1, 0.1, 5, 5).moved(Vec3(3e-3, 2e-3, 2e-3)), Kind::Cloth, 4e-3}});
}

bool same(const ExtraTerm& a, const ExtraTerm& b) {
  bool equal = a.n_entries == b.n_entries && a.gradient == b.gradient && a.hessian == b.hessian &&
               a.drift == b.drift;
  for (int e = 0; equal && e < a.n_entries; ++e)
    equal = a.entries[e].row == b.entries[e].row && a.entries[e].weight == b.entries[e].weight;
  return equal;
}

bool acts_on(const ExtraTerm& term, IndexRange rows) {
  for (int e = 0; e < term.n_entries; ++e)
    if (rows.contains(term.entries[e].row)) return true;
  return false;
}

}  // namespace

TEST_CASE("terms made for parts of the rows are those of all rows, and each counts once") {
  const TestScene scene = two_sheets();
  const Points x = shaken(scene.x, 4e-4, 10);
  const Index n = static_cast<Index>(x.rows());
  const Points v = shaken(Points::Zero(n, 3), 0.05, 12), moved = 1e-3 * v;
  const Points none = Points::Zero(n, 3), no_bodies(0, 3), no_forces(0, 3);
  CollisionStage stage(scene.model);
  const std::vector<Contact> contacts = stage.proximity(Team{1}, x, {});
  const ContactState state = anchored(contacts, 1e-4);
  ContactInputs inputs{x, v, none, no_bodies, 1e-3, n, scene.inverse_mass, no_forces};
  ExtraTerms all;
  const ContactTerms whole = stage.terms(Team{2}, inputs, contacts, state, all);
  REQUIRE(all.size() > 64);  // more than one range of the parallel loop
  REQUIRE(whole.n_counted() == static_cast<std::int64_t>(all.size()));
  ExtraTerms all_after = all;
  const ContactError error =
      whole.forces_after(Team{1}, moved, 1e-3, scene.inverse_mass, false, all_after);
  ContactError sum;
  BinnedSum energy;
  std::size_t counted = 0, made = 0;
  for (const IndexRange rows : {IndexRange{0, 30}, IndexRange{30, 40}, IndexRange{40, n}}) {
    inputs.rows = rows;
    ExtraTerms own;
    const ContactTerms part = stage.terms({}, inputs, contacts, state, own);
    energy.add(part.energy());
    REQUIRE(part.size() == own.size());
    ExtraTerms own_after = own;
    const ContactError own_error =
        part.forces_after(Team{1}, moved, 1e-3, scene.inverse_mass, false, own_after);
    for (int s = 0; s < ContactError::n_sums; ++s) sum.sums[s].add(own_error.sums[s]);
    std::size_t next = 0;
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (!acts_on(all[t], rows)) continue;
      REQUIRE(next < own.size());
      CHECK(part.contact(next) == whole.contact(t));
      CHECK(same(own[next], all[t]));
      CHECK(same(own_after[next], all_after[t]));
      counted += part.counts(next++);
    }
    CHECK(next == own.size());
    made += own.size();
  }
  CHECK(energy.value() == whole.energy().value());
  CHECK(counted == all.size());
  CHECK(made > all.size());  // some terms act on the rows of several parts
  for (int s = 0; s < ContactError::n_sums; ++s)
    CHECK(sum.sums[s].value() == error.sums[s].value());
  CHECK(error.relative(false) > 0.0);
}

TEST_CASE("contacts of the same positions follow new anchors and forces") {
  const TestScene scene = two_sheets();
  const Points x = shaken(scene.x, 4e-4, 10);
  const Index n = static_cast<Index>(x.rows());
  const Points none = Points::Zero(n, 3), no_forces(0, 3);
  Points pressing = none;
  for (Index i = 0; i < n; ++i) pressing(i, 2) = i < 49 ? 50.0 : -50.0;
  CollisionStage stage(scene.model);
  const std::vector<Contact> contacts = stage.proximity(Team{1}, x, {});
  const auto energy_in = [&](CollisionStage& of, const Points& forces, double slip) {
    const ContactState state = anchored(contacts, slip);
    const StrengthInputs inputs{x, scene.inverse_mass, forces, state};
    return of.energies({x, x}, inputs, of.proximity(Team{1}, x, {}), all_indices).back().value();
  };
  std::vector<double> seen;
  const std::array<const Points*, 3> given = {&no_forces, &pressing, &none};
  for (const Points* forces : given)
    for (const double slip : {1e-4, 2e-4, 1e-4}) {
      CollisionStage fresh(scene.model);
      const double energy = energy_in(stage, *forces, slip);
      CHECK(energy == energy_in(fresh, *forces, slip));
      CHECK(energy == energy_in(stage, *forces, slip));
      seen.push_back(energy);
    }
  CHECK(seen[0] != seen[1]);  // anchors change the energy
  CHECK(seen[0] != seen[3]);  // forces change the energy
  CHECK(seen[0] == seen[6]);  // zero forces act like no forces
}
