// Tests of contacts that are divided among ranks. Each rank keeps the contacts that act on its
// rows, and all ranks together find the same terms, anchors and energies as a single rank.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "core/collision/collision_stage.h"
#include "tests/collision/collision_scenes.h"
#include "tests/support/thread_ranks.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

// Two sheets on a table. If `smooth` is true, contact normals on the table are interpolated from
// vertex normals, and the table's edges have no contacts.
TestScene sheets_on_table(bool smooth) {
  TestScene scene = make_scene(
      {{grid_cells(0.2, 0.2, 12, 12), Kind::Cloth, 4e-3},
       {jittered_grid(0.2, 0.2, 11, 11, 0.2, 3).moved(Vec3(4e-3, 1e-3, 2e-3)), Kind::Cloth, 4e-3},
       {grid_cells(0.3, 0.3, 9, 9).moved(Vec3(0, 0, -1.5e-3)), Kind::Script, 4e-3}});
  scene.model.surfaces.back().smooth = smooth;
  return scene;
}

struct Results {
  std::vector<double> numbers;               // the same on all ranks
  std::vector<std::array<double, 9>> terms;  // of this rank's rows; each begins with the row number
  // Numbers of contacts, summed over the steps: `kept` on this rank, `found` on all ranks.
  std::size_t kept = 0, found = 0;

  void add(const ContactTotals& totals) {
    numbers.insert(numbers.end(), {1.0 * static_cast<double>(totals.n), 1.0 * totals.pressed,
                                   1.0 * totals.vertex_on_face});
    for (const auto& [a, b] : totals.surfaces) numbers.insert(numbers.end(), {1.0 * a, 1.0 * b});
  }
  void add(const std::vector<ContactState::Anchor>& anchors) {
    for (const ContactState::Anchor& anchor : anchors)
      numbers.insert(numbers.end(),
                     {static_cast<double>(anchor.kind), 1.0 * anchor.a, 1.0 * anchor.b,
                      anchor.slip[0], anchor.slip[1], anchor.slip[2], anchor.normal_force});
  }
  void add(const std::vector<Contact>& contacts) {
    for (const Contact& contact : contacts)
      numbers.insert(numbers.end(), {1.0 * contact.a, 1.0 * contact.b, contact.distance});
  }
  // Adds each term once for every row in `rows` on which it acts.
  void add(const ExtraTerms& made, IndexRange rows) {
    for (const ExtraTerm& term : made)
      for (int e = 0; e < term.n_entries; ++e)
        if (rows.contains(term.entries[e].row))
          terms.push_back({1.0 * term.entries[e].row, term.entries[e].weight, term.gradient[0],
                           term.gradient[1], term.gradient[2], term.hessian(0, 0),
                           term.hessian(1, 2), term.drift[0], term.drift[2]});
  }
};

Results results(const TestScene& scene, const std::shared_ptr<const Communicator>& ranks) {
  CollisionStage stage(scene.model, Decomposition::Predicted, ranks);
  const Index n = scene.model.surfaces[2].first_vertex;
  IndexRange own = even_share(n, ranks->rank(), ranks->size());
  // If there are eight ranks, ranks 1, 3, 5 and 7 have no rows.
  if (ranks->size() == 8) own = even_share(n, ranks->rank() / 2, 4);
  if (ranks->size() == 8 && ranks->rank() % 2 == 1) own.begin = own.end;
  if (ranks->size() > 1) stage.divide(own);
  Points x = scene.x, pressing = Points::Zero(n, 3);
  for (Index i = 0; i < n; ++i) pressing(i, 2) = i < 169 ? 5.0 : -5.0;
  const Points still = Points::Zero(x.rows(), 3), no_bodies(0, 3);
  ContactState state;
  Results all;
  for (int step = 0; step < 4; ++step) {
    const Points x1 = shaken(x, 3e-4, 20 + step), v = 1e3 * (x1 - x);
    const std::vector<Contact> contacts = stage.proximity(Team{}, x, {});
    all.add(stage.totals());
    all.kept += contacts.size(), all.found += static_cast<std::size_t>(stage.totals().n);
    ContactInputs inputs{x, v, still, no_bodies, 1e-3, n, scene.inverse_mass, pressing};
    inputs.rows = own;
    ExtraTerms terms;
    const ContactTerms made = stage.terms({}, inputs, contacts, state, terms);
    all.add(terms, own);
    all.numbers.push_back(stage.update_anchors(contacts, made, x, x1, state));
    all.add(state.anchors);
    std::vector<BinnedSum> energies =
        stage.energies({x, x, 2}, {x, scene.inverse_mass, pressing, state}, contacts, own);
    ranks->add(energies.data(), 2);
    for (const BinnedSum& energy : energies) all.numbers.push_back(energy.value());
    all.add(stage.all_contacts(Team{}, x, {}));
    all.add(stage.totals());
    all.add(stage.all_contacts(Team{}, x1, {}));  // contacts at x1 instead of x
    x = x1;
  }
  return all;
}

}  // namespace

TEST_CASE("ranks that keep the contacts of their rows find the bits of one rank") {
  for (const bool smooth : {false, true}) {
    const TestScene scene = sheets_on_table(smooth);
    const Results alone = results(scene, single_communicator());
    REQUIRE(alone.found > 1000);
    for (const int n : {2, 3, 4, 8}) {
      std::vector<Results> found(n);
      test::on_ranks(n, [&](const auto& ranks) { found[ranks->rank()] = results(scene, ranks); });
      std::vector<std::array<double, 9>> terms;
      std::size_t most = 0;
      for (const Results& each : found) {
        CHECK((each.numbers == alone.numbers));  // parentheses keep Catch from printing the vectors
        terms.insert(terms.end(), each.terms.begin(), each.terms.end());
        most = std::max(most, each.kept);
      }
      CHECK(most < alone.kept);
      std::vector<std::array<double, 9>> expected = alone.terms;
      std::sort(expected.begin(), expected.end());
      std::sort(terms.begin(), terms.end());
      CHECK((terms == expected));
    }
  }
}
