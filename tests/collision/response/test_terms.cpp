#include <catch2/catch.hpp>

#include "core/collision/collision_stage.h"
#include "core/collision/narrow_phase/distance.h"
#include "core/collision/response/contacts.h"
#include "core/collision/response/friction.h"
#include "tests/collision/collision_scenes.h"
#include "tests/support/decompositions.h"

using namespace loomstone;
using Kind = CollisionSurface::Kind;

namespace {

struct Assembled {
  std::vector<Contact> contacts;
  ExtraTerms terms;
  double energy = 0.0;
};

Assembled assemble(const TestScene& scene, const Points& x, const Points& v, const Points& centres,
                   Index n_cloth, const ContactState& state = {}) {
  Assembled result;
  CollisionStage stage(scene.model);
  result.contacts = stage.proximity(Team{1}, x, {});
  result.energy = stage
                      .terms({},
                             {x, v, Points(Points::Zero(x.rows(), 3)), centres, 1e-3, n_cloth,
                              scene.inverse_mass, Points(0, 3)},
                             result.contacts, state, result.terms)
                      .energy()
                      .value();
  return result;
}

// Returns the sum of the gradients of the terms in each row (n x 3) [N].
Points assembled(const ExtraTerms& terms, Index n) {
  Points sum = Points::Zero(n, 3);
  for (const ExtraTerm& t : terms)
    for (int e = 0; e < t.n_entries; ++e)
      sum.row(t.entries[e].row) += t.entries[e].apply_transposed(t.gradient).transpose();
  return sum;
}

// Product of the terms' stiffness and `direction` (n x 3).
Points assembled_product(const ExtraTerms& terms, const Points& direction) {
  Points sum = Points::Zero(direction.rows(), 3);
  for (const ExtraTerm& t : terms) {
    const Vec3 force = t.hessian * t.relative_displacement(direction, 0.0);
    for (int e = 0; e < t.n_entries; ++e)
      sum.row(t.entries[e].row) += t.entries[e].apply_transposed(force).transpose();
  }
  return sum;
}

// Returns an anchor for each contact. Some of the contacts will stick, and others will slip.
ContactState anchored(const std::vector<Contact>& contacts) {
  ContactState state;
  for (const Contact& c : contacts)
    state.anchors.push_back(
        {c.kind, c.a, c.b, 1e-4 * c.normal.unitOrthogonal() * double(c.a % 3), 1.0});
  return state;
}

TestScene sheet_over_sheet() {
  return make_scene(
      {{grid_cells(0.1, 0.1, 6, 6), Kind::Cloth, 4e-3},
       {grid_cells(0.1, 0.1, 5, 5).moved(Vec3(3e-3, 2e-3, 2e-3)), Kind::Cloth, 4e-3}});
}

}  // namespace

TEST_CASE(
    "the contact force is minus the gradient of the contact energy, to second order of the "
    "difference") {
  const double xi = 1e-3, k = 700.0;
  for (const double d : {0.05e-3, 0.2e-3, 0.45e-3, 0.6e-3, 0.8e-3, 0.9e-3}) {
    const ContactForce at = contact_force(d, xi, k);
    double last = 0.0;
    for (const double step : {4e-6, 2e-6, 1e-6}) {
      const double difference =
          (contact_force(d + step, xi, k).energy - contact_force(d - step, xi, k).energy) /
          (2 * step);
      const double slope =
          (contact_force(d + step, xi, k).force - contact_force(d - step, xi, k).force) /
          (2 * step);
      const double error = std::abs(difference + at.force) / at.force;
      CHECK(std::abs(slope + at.stiffness) <= 1e-2 * at.stiffness);
      // Halving the step quarters the error.
      if (last > 1e-8) CHECK(last / error == Approx(4.0).epsilon(0.1));
      CHECK(error < 1e-2);
      last = error;
    }
  }
  CHECK(contact_force(xi, xi, k).force == 0.0);
  // Force, stiffness and energy are continuous where two pieces of the contact law join.
  const double hair = 1e-12;
  for (const double d : {0.5 * xi, 0.75 * xi}) {
    const ContactForce above = contact_force(d + hair, xi, k),
                       below = contact_force(d - hair, xi, k);
    CHECK(above.force == Approx(below.force).epsilon(1e-6));
    CHECK(above.stiffness == Approx(below.stiffness).epsilon(1e-6));
    CHECK(above.energy == Approx(below.energy).epsilon(1e-6));
  }
  // When the gap falls below the thickness, force, stiffness and energy rise from 0.
  const ContactForce first = contact_force(xi - hair, xi, k);
  CHECK(first.stiffness < 1e-6 * k);
  CHECK(first.force < 1e-12 * k * xi);
  CHECK(first.energy < 1e-12 * k * xi * xi);
}

TEST_CASE("contacts of any depth have a stiffness that the solve can add to the mass") {
  TestScene scene =
      make_scene({{grid_cells(0.1, 0.1, 6, 6), Kind::Cloth, 4e-3},
                  {grid_cells(0.1, 0.1, 5, 5).moved(Vec3(3e-3, 2e-3, 1e-9)), Kind::Cloth, 4e-3}});
  const Points& x = scene.x;
  const Index n = static_cast<Index>(x.rows());
  const Assembled at = assemble(scene, x, Points::Zero(n, 3), Points(0, 3), n);
  REQUIRE(at.terms.size() > 50);
  double stiffest = 0.0, strongest = 0.0;
  for (const ExtraTerm& term : at.terms) {
    double inverse_mass = 0.0;
    for (int e = 0; e < term.n_entries; ++e)
      inverse_mass +=
          term.entries[e].weight * term.entries[e].weight * scene.inverse_mass[term.entries[e].row];
    const double h = 1e-3;  // step of assemble()
    stiffest = std::max(stiffest, h * h * inverse_mass * term.hessian.norm());
    strongest = std::max(strongest, h * h * inverse_mass * term.gradient.norm());
  }
  // The stiffness is at most 1e8 m / h^2, where m is the effective mass of the contact and h the
  // step. Without this bound, (M26) of docs/method.md gives more than 5e12 m / h^2.
  CHECK(stiffest < 1.0001e8);
  CHECK(stiffest > 1e7);
  // The force is at most the bound on the stiffness times the thickness of 4e-3 m. With a stiffness
  // at this bound, one solve therefore moves the surfaces apart by no more than their thickness.
  CHECK(strongest < 1e8 * 4e-3);
}

TEST_CASE("contact forces are minus the gradient of the contact energies for fixed shares") {
  TestScene scene = sheet_over_sheet();
  const Points x = shaken(scene.x, 4e-4, 10);
  const Assembled at = assemble(scene, x, Points::Zero(x.rows(), 3), Points(0, 3), x.rows());
  REQUIRE(at.contacts.size() > 50);
  const std::vector<double> shares = contact_shares(at.contacts, scene.model, x);
  const auto energy = [&](const Points& y) {
    double sum = 0.0;
    for (std::size_t c = 0; c < at.contacts.size(); ++c) {
      FourPoints p;
      for (int i = 0; i < 4; ++i) p[i] = y.row(at.contacts[c].vertices[i]).transpose();
      const double d = at.contacts[c].kind == ContactKind::VertexFace
                           ? closest_vertex_face(p).distance
                           : closest_edge_edge(p).distance;
      sum += shares[c] *
             contact_force(d, at.contacts[c].thickness, scene.model.contact_stiffness).energy;
    }
    return sum;
  };
  CHECK(energy(x) == Approx(at.energy).epsilon(1e-12));
  const Points direction = shaken(Points::Zero(x.rows(), 3), 1.0, 11);
  double slope = 0.0;
  for (const ExtraTerm& term : at.terms)
    for (int i = 0; i < term.n_entries; ++i)
      slope +=
          direction.row(term.entries[i].row).dot(term.entries[i].apply_transposed(term.gradient));
  // The energy is less smooth where a contact begins or ends. The step is so small that no contact
  // does so between the two displaced positions.
  const double step = 1e-9,
               difference =
                   (energy(x + step * direction) - energy(x - step * direction)) / (2 * step);
  CHECK(difference == Approx(slope).epsilon(1e-5));
}

TEST_CASE(
    "terms at displaced positions are the gradient of their energy, and their stiffness is its "
    "derivative") {
  TestScene scene = sheet_over_sheet();
  const Points x = shaken(scene.x, 4e-4, 10);
  const Index n = static_cast<Index>(x.rows());
  const Points v = shaken(Points::Zero(n, 3), 0.05, 12);
  CollisionStage stage(scene.model);
  const std::vector<Contact> contacts = stage.proximity(Team{1}, x, {});
  const ContactState state = anchored(contacts);
  ExtraTerms terms;
  std::vector<Contact> smooth = contacts;
  for (Contact& c : smooth) c.friction = 0.0;
  // At zero displacement, normal force and stiffness equal their values at the start.
  const Points unchanged = Points::Zero(n, 3), no_bodies(0, 3);
  const ContactInputs inputs{x, v, unchanged, no_bodies, 1e-3, n, scene.inverse_mass, Points(0, 3)};
  ContactTerms made = stage.terms({}, inputs, smooth, state, terms);
  ExtraTerms there = terms;
  made.at(Team{1}, Points::Zero(n, 3), 0.0, TermRequest::Derivative, there);
  REQUIRE(terms.size() > 20);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    CHECK((there[i].gradient - terms[i].gradient).norm() <= 1e-12 * terms[i].gradient.norm());
    CHECK((there[i].hessian - terms[i].hessian).norm() <= 1e-12 * terms[i].hessian.norm());
  }
  terms.clear();
  made = stage.terms({}, inputs, contacts, state, terms);
  const auto at = [&](const Points& moved, ExtraTerms& out) {
    out = terms;
    return made.at(Team{1}, moved, 1e-3, TermRequest::Derivative, out);
  };
  // The displacement moves parts of the sheets through each other, so gaps have both signs.
  const Points moved = shaken(Points::Zero(n, 3), 1.5e-3, 13),
               direction = shaken(Points::Zero(n, 3), 1.0, 14);
  at(moved, there);
  const double slope = (assembled(there, n).array() * direction.array()).sum();
  const Points force = assembled(there, n);
  const Points product = assembled_product(there, direction);
  // From one step of the difference quotients to the next, errors at least halve, down to a floor
  // for rounding errors.
  double last = 1.0, last_force = 1.0;
  for (const double step : {1e-6, 1e-7, 1e-8}) {
    ExtraTerms plus, minus;
    const double difference =
        (at(moved + step * direction, plus) - at(moved - step * direction, minus)) / (2 * step);
    const double error = std::abs(difference - slope) / std::abs(slope);
    const double force_error =
        ((assembled(plus, n) - assembled(minus, n)) / (2 * step) - product).norm() / product.norm();
    CHECK(error < std::max(0.5 * last, 1e-7));  // 1e-7: rounding errors of the energies
    CHECK(force_error < std::max(0.5 * last_force, 1e-6));
    last = error, last_force = force_error;
  }
  CHECK(last < 1e-6);
  CHECK(last_force < 1e-4);
  // NewLimits computes the friction limits from the normal forces at the displaced positions.
  // Derivative keeps the limits computed at the start.
  ExtraTerms limited = terms;
  made.at(Team{1}, moved, 1e-3, TermRequest::NewLimits, limited);
  CHECK((assembled(limited, n) - force).norm() > 1e-3 * force.norm());
}

TEST_CASE("stiffness of every term is symmetric and positive semidefinite") {
  TestScene scene = sheet_over_sheet();
  const Points x = shaken(scene.x, 8e-4, 12), v = shaken(Points::Zero(x.rows(), 3), 2.0, 13);
  for (const ExtraTerm& term : assemble(scene, x, v, Points(0, 3), x.rows()).terms) {
    CHECK(term.hessian == term.hessian.transpose());
    const Vec3 eigenvalues = test::eigenvalues(term.hessian);
    CHECK(eigenvalues[0] >= -1e-12 * eigenvalues[2]);
    CHECK(eigenvalues[2] > 0.0);
  }
}

TEST_CASE(
    "contacts of cloth with cloth change neither momentum nor, along normals, angular momentum") {
  TestScene scene = sheet_over_sheet();
  const Points x = shaken(scene.x, 8e-4, 14), v = shaken(Points::Zero(x.rows(), 3), 2.0, 15);
  const Assembled at = assemble(scene, x, v, Points(0, 3), x.rows());
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  CHECK(at.terms.size() <= at.contacts.size());
  for (const ExtraTerm& term : at.terms)
    for (int i = 0; i < term.n_entries; ++i) {
      const Vec3 f = term.entries[i].apply_transposed(term.gradient);
      force += f;
      size += f.norm();
    }
  CHECK(force.norm() <= 1e-13 * size);
  const Assembled still = assemble(scene, x, Points::Zero(x.rows(), 3), Points(0, 3), x.rows());
  for (const ExtraTerm& term : still.terms)
    for (int i = 0; i < term.n_entries; ++i)
      torque += Vec3(x.row(term.entries[i].row).transpose())
                    .cross(term.entries[i].apply_transposed(term.gradient));
  CHECK(torque.norm() <= 1e-11 * size);
}

TEST_CASE(
    "a body takes the opposite force, and the torque about its centre, as one translation and one "
    "rotation row") {
  TestScene scene =
      make_scene({{grid_cells(0.1, 0.1, 6, 6).moved(Vec3(0, 0, 0.0315)), Kind::Cloth, 3e-3},
                  {icosphere(0.03, 2).moved(Vec3(0.01, 0, 0)), Kind::Body, 3e-3}});
  const Index n_cloth = scene.model.surfaces[0].n_vertices;
  Points centres(1, 3);
  centres << 0.01, 0.0, 0.0;
  const Assembled at = assemble(scene, scene.x, Points::Zero(scene.x.rows(), 3), centres, n_cloth);
  REQUIRE(at.terms.size() > 3);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double size = 0.0;
  for (const ExtraTerm& term : at.terms) {
    int n_body = 0;
    for (int i = 0; i < term.n_entries; ++i) {
      const TermEntry& entry = term.entries[i];
      if (i > 0) CHECK(entry.row > term.entries[i - 1].row);
      const Vec3 f = entry.apply_transposed(term.gradient);
      size += f.norm();
      if (entry.row < n_cloth) {
        force += f;
        torque += Vec3(scene.x.row(entry.row) - centres.row(0)).cross(f);
      } else if (entry.row == n_cloth) {
        force += f;
        ++n_body;
      } else {
        torque += f;
        ++n_body;
      }
    }
    CHECK(n_body == 2);
  }
  CHECK(force.norm() <= 1e-13 * size);
  CHECK(torque.norm() <= 1e-13 * size);
}

TEST_CASE("scripted motion enters as drift, so common motion causes no relative motion") {
  TestScene scene =
      make_scene({{grid_cells(0.1, 0.1, 6, 6), Kind::Cloth, 4e-3},
                  {floor_square(0.4, 3).moved(Vec3(0, 0, -3e-3)), Kind::Script, 4e-3}});
  Points v(scene.x.rows(), 3);
  v.rowwise() = Eigen::RowVector3d(0.3, -0.2, 0.1);
  const Assembled at =
      assemble(scene, scene.x, v, Points(0, 3), scene.model.surfaces[0].n_vertices);
  REQUIRE(at.terms.size() > 20);
  for (const ExtraTerm& term : at.terms) {
    Vec3 relative = -term.drift;
    for (int i = 0; i < term.n_entries; ++i)
      relative += term.entries[i].apply(v.row(term.entries[i].row).transpose());
    CHECK(relative.norm() < 1e-15);
  }
}

TEST_CASE("a vertex over the common edge or corner of faces is pushed as by one face") {
  Part floor{grid_cells(0.1, 0.1, 4, 4), Kind::Script, 2e-3};
  Part sheet{grid_cells(0.2, 0.2, 1, 1).moved(Vec3(0, 0, 1.4e-3)), Kind::Cloth, 2e-3};
  TestScene scene = make_scene({sheet, floor});
  double least = INFINITY, most = 0.0, last = -1.0, largest_jump = 0.0;
  const int n = 2000;
  for (int i = 0; i <= n; ++i) {
    Points x = scene.x;
    // The vertex passes over faces, edges and a corner.
    x.row(0) = Eigen::RowVector3d(-0.03 + 0.06 * i / n, -0.012 + 0.024 * i / n, 1.4e-3);
    x.middleRows(1, 3).col(2).array() += 1.0;
    const Assembled at = assemble(scene, x, Points::Zero(x.rows(), 3), Points(0, 3), 4);
    double force = 0.0;
    for (const ExtraTerm& term : at.terms)
      if (term.entries[0].weight == 1.0)
        force -= term.gradient.z();  // vertex contacts only; edge contacts have smaller weights
    least = std::min(least, force);
    most = std::max(most, force);
    if (last >= 0.0) largest_jump = std::max(largest_jump, std::abs(force - last));
    last = force;
  }
  const double one = contact_force(1.4e-3, 2e-3, scene.model.contact_stiffness).force;
  CHECK(most <= 1.15 * one);
  CHECK(least >= 0.85 * one);
  CHECK(largest_jump <= 0.05 * one);  // largest change over a displacement of 0.03 mm
}

TEST_CASE("a smooth surface pushes along its rounded normals, and its edges carry no force") {
  TestScene scene = make_scene(
      {{grid_cells(0.02, 0.02, 8, 8).moved(Vec3(0.001, 0.002, 0.0503)), Kind::Cloth, 2e-3},
       {icosphere(0.05, 2), Kind::Script, 2e-3}});
  scene.model.surfaces[0].self_collision = false;
  const auto worst_angle = [&](bool smooth) {
    scene.model.surfaces[1].smooth = smooth;
    double worst = 0.0;
    Index last = -1;
    int n = 0;
    CollisionStage stage(scene.model);
    for (const Contact& contact : stage.proximity(Team{1}, scene.x, {})) {
      if (smooth) CHECK(contact.kind == ContactKind::VertexFace);
      if (contact.kind != ContactKind::VertexFace || contact.a >= 81) continue;
      if (smooth) CHECK(contact.a != last);  // one contact per vertex
      last = contact.a;
      ++n;
      const Vec3 radial = scene.x.row(contact.a).transpose().normalized();
      worst = std::max(worst, std::acos(std::min(1.0, radial.dot(contact.normal))));
    }
    CHECK(n > 10);
    return worst;
  };
  // The facets of the sphere have edges of 14 to 16 mm on a radius of 50 mm. The angle between the
  // normal of a facet and the radius is up to 0.19 rad, at the corners of the facet. The bound for
  // interpolated normals is about a tenth of this angle.
  CHECK(worst_angle(false) > 0.1);
  CHECK(worst_angle(true) < 0.02);
}

TEST_CASE("contacts become stiffer where forces press taut cloth together") {
  const TestScene scene = sheet_over_sheet();
  const double k = scene.model.contact_stiffness;
  CollisionStage stage(scene.model);
  const std::vector<Contact> contacts = stage.proximity(Team{1}, scene.x, {});
  REQUIRE(contacts.size() > 20);
  const auto stiffness = [&](const Points& forces) {
    return contact_stiffness(contacts, scene.model, scene.inverse_mass, forces);
  };
  const Index n = scene.model.n_vertices, n_low = scene.model.surfaces[0].n_vertices;
  for (const double each : stiffness(Points(0, 3))) CHECK(each == k);
  // The upper sheet is pressed down by 8 N per vertex. The thickness is 4 mm.
  Points forces = Points::Zero(n, 3);
  forces.bottomRows(n - n_low).col(2).setConstant(-8.0);
  const std::vector<double> stiffer = stiffness(forces);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const double pressing = 8.0 * std::abs(contacts[c].normal.z());
    CHECK(stiffer[c] == Approx(std::max(k, 16.0 / 3.0 * pressing / 4e-3 - k)));
  }
  // Stiffening begins at a force of 3/8 k xi = 1.5 N, where xi is the thickness. An eighth of the
  // forces above, 1 N per vertex, is less than that.
  for (const double each : stiffness(forces / 8.0)) CHECK(each == k);
  // Forces that pull the sheets apart stiffen no contacts, nor do forces on prescribed vertices.
  for (const double each : stiffness(-forces)) CHECK(each == k);
  const Vector held = Vector::Zero(n);
  for (const double each : contact_stiffness(contacts, scene.model, held, forces)) CHECK(each == k);
}

TEST_CASE("a contact that would close is stiffened until its gap stays open under the same force") {
  TestScene scene = sheet_over_sheet();
  const Points& x = scene.x;
  const Index n = static_cast<Index>(x.rows());
  CollisionStage stage(scene.model);
  // Keeps only contacts with normals perpendicular to the sheets. Their gap is thickness / 2.
  const double gap = 2e-3, thickness = 4e-3, k = scene.model.contact_stiffness;
  std::vector<Contact> contacts = stage.proximity(Team{1}, x, {});
  std::erase_if(contacts, [&](const Contact& c) { return c.distance > gap + 1e-9; });
  const Points still = Points::Zero(n, 3), no_bodies(0, 3);
  const ContactInputs inputs{x, still, still, no_bodies, 1e-3, n, scene.inverse_mass, Points(0, 3)};
  ExtraTerms terms;
  const ContactTerms made = stage.terms({}, inputs, contacts, {}, terms);
  REQUIRE(terms.size() > 20);
  // The upper sheet sinks by `sunk` times the gap. Contacts are stiffened only if it sinks by more
  // than three quarters of the gap.
  for (const double sunk : {0.5, 0.7, 0.8, 1.5, 3.0}) {
    Points moved = still;
    moved.bottomRows(36).col(2).array() -= sunk * gap;
    ExtraTerms again = terms;
    const double error =
        made.forces_after(Team{1}, moved, 1e-3, scene.inverse_mass, false, again).relative(false);
    CHECK((error == 1.0) == (sunk > 0.75));
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const Vec3 normal = made.normal(i);
      const double force = -normal.dot(terms[i].gradient);
      const double tangent = normal.dot(terms[i].hessian * normal);
      const double secant = normal.dot(again[i].hessian * normal);
      if (sunk < 0.75) {
        CHECK(secant == Approx(tangent).epsilon(1e-12));
        continue;
      }
      // In the stiffened law, the force plus `share` times k xi / 8 is inversely proportional to
      // the gap, where xi is the thickness.
      const double share = tangent * gap * gap / (k * 0.25 * thickness * thickness);
      const double offset = share * k * thickness / 8.0;
      const double predicted = force + tangent * sunk * gap;
      const double left = gap - (predicted - force) / secant;
      CHECK(left == Approx(gap * (force + offset) / (predicted + offset)).epsilon(1e-9));
    }
  }
}
