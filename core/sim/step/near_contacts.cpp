#include "core/sim/step/near_contacts.h"

#include <algorithm>
#include <utility>

#include "core/collision/model/rigid_motion.h"
#include "core/sim/model/motion.h"
#include "core/sim/step/user_writes.h"

namespace loomstone {

namespace {

// Fraction of the forces of limit phases that counts as pressing cloth against other surfaces, for
// cloths that bodies load; see add_limit_forces() and contact_stiffness(). Our choice. Without
// these forces, contacts are too soft: a body that is much heavier than the cloth pushes through
// them, certification stretches the cloth beyond its limits, and the limit phases then throw the
// body back. In a step, limit phases can exert forces much larger than the load. If these forces
// counted fully, contacts would push cloth beyond its limits. With 0.001, no pile and no box of
// tests/benchmarks/extreme_scenes.py gains energy, in automatic steps and in steps of 1 to 10 ms
// (docs/experiments/strain_limits.md).
constexpr double share_of_limit_forces = 0.001;

// Returns the predicted velocities of the vertices of bodies and obstacles [m/s]. Bodies are
// expected to keep the velocities that they have at the start of the part; obstacles have their
// mean velocities in the part. Row 0 belongs to the first collision vertex after the cloth.
Points body_vertex_velocities(const StepContext& part, const Loads& loads, const State& state,
                              const Model& model) {
  const Index n = model.cloth.n_vertices;
  Points velocities(loads.x0.rows() - n, 3);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    for (Index i = 0; i < model.bodies[b].local.rows(); ++i) {
      const Index vertex = model.bodies[b].first + i;
      const Vec3 place = loads.x0.row(vertex).transpose();
      velocities.row(vertex - n) =
          velocity_at(state.rigid, static_cast<Index>(b), place).transpose();
    }
  velocities.bottomRows(loads.next_obstacles.rows()) =
      (loads.next_obstacles - state.obstacle_vertices) / part.h;
  return velocities;
}

// Returns the predicted velocities of all collision vertices [m/s]. Free cloth vertices are
// expected to keep the velocities that they have at the start of the part; prescribed vertices have
// their mean velocities in the part.
VertexVelocities predicted_velocities(const StepContext& part, const Loads& loads,
                                      const State& state, const Model& model) {
  return VertexVelocities([&, of_bodies = body_vertex_velocities(part, loads, state, model)](
                              Index vertex) -> Eigen::RowVector3d {
    const Index n = model.cloth.n_vertices;
    if (vertex >= n) return of_bodies.row(vertex - n);
    if (!model.cloth.prescribed[vertex]) return state.cloth.v.row(vertex);
    return (loads.target.row(vertex) - loads.x0.row(vertex)) / part.h;
  });
}

// Returns the mean velocities of obstacle vertices in this part minus those in the previous part
// (k x 3) [m/s]. Returns no rows if the length of the previous part is unknown or no obstacle moves
// in this part. Velocities in the previous part are turned with an obstacle that rotates, so steady
// rotation gives no change. The change is 0 for obstacles whose pose the user has set, if no
// obstacle had a pose set by the user in the previous part.
Points obstacle_changes(const StepContext& part, const Loads& loads, const State& state,
                        const Model& model) {
  const Points &now = state.obstacle_vertices, &next = loads.next_obstacles,
               &known = state.previous_obstacle_vertices;
  const double last = state.cloth.previous_step;
  if (!(last > 0.0) || now == next) return Points(0, 3);
  Points before;
  obstacle_vertices(model, state, part.t0 - last, 1.0, before);
  Points changes = Points::Zero(now.rows(), 3);
  Index row = 0;
  for (std::size_t o = 0; o < model.obstacles.size(); ++o) {
    const Index n = static_cast<Index>(model.obstacles[o].local.rows());
    const auto x1 = now.middleRows(row, n), x2 = next.middleRows(row, n);
    const bool by_user = state.pose_override[o];
    if (!by_user || known.rows() > 0) {
      const RigidMotion motion = rigid_motion(x1, x2);
      const Mat3 turn = motion.rigid ? motion.rotation : Mat3::Identity();
      const auto x0 = (by_user ? known : before).middleRows(row, n);
      changes.middleRows(row, n) = (x2 - x1) / part.h - (x1 - x0) / last * turn.transpose();
    }
    row += n;
  }
  return changes;
}

// Returns the change of velocity [m/s] that contact terms assume for each collision vertex in this
// part. The assumption reduces the lag of sliding contacts. For cloth, returns the change in the
// previous part, scaled to the length of this part; for obstacles, the result of
// obstacle_changes(). Returns 0 for bodies and for unknown changes.
VertexVelocities expected_change(const StepContext& part, const Points& of_obstacles,
                                 const State& state, const Model& model) {
  const bool has_change = state.cloth.last_change.rows() == model.n_rows();
  const double scale = state.cloth.change_scale(part.h);
  const Index first = static_cast<Index>(model.collision.n_vertices) - of_obstacles.rows();
  return VertexVelocities([=, &of_obstacles, &state, &model](Index vertex) -> Eigen::RowVector3d {
    if (vertex >= first) return of_obstacles.row(vertex - first);
    if (!has_change || vertex >= model.cloth.n_vertices) return Eigen::RowVector3d::Zero();
    return scale * state.cloth.last_change.row(vertex);
  });
}

// Adds a stiff two-way spring between each attached vertex and its point on the body. In parts that
// are shorter than the time in which strains recover (see recovery_rate()), the spring is viscous,
// too. Without viscosity, a vertex that rotation or contacts have moved away from its point would
// return to it within such a part, and would get a large velocity.
void add_attachments(const StepContext& part, const Engines& engines, const State& state,
                     ExtraTerms& terms) {
  const Model& model = engines.model;
  const double viscosity = std::max(1.0, 1.0 / (engines.recovery_rate * part.h));
  for (const AttachedVertex& attached : model.attachments) {
    const Vec3 point = to_world(state.rigid, attached.body, attached.local);
    ExtraTerm term;
    const Index row = model.cloth.n_vertices + 2 * attached.body;
    term.entries[0] = {attached.row, false, 1.0, Vec3::Zero()};
    term.entries[1] = {row, false, -1.0, Vec3::Zero()};
    term.entries[2] = {row + 1, true, -1.0,
                       point - state.rigid.positions.row(attached.body).transpose()};
    term.n_entries = 3;
    term.gradient =
        model.attachment_stiffness * (state.cloth.x.row(attached.row).transpose() - point);
    term.hessian = viscosity * model.attachment_stiffness * Mat3::Identity();
    terms.push_back(term);
  }
}

// Returns the cloth rows of this rank if `elasticity` is divided among ranks, otherwise all rows.
Rows cloth_rows(const Engines& engines, const Elasticity& elasticity) {
  const Index n = engines.model.cloth.n_vertices;
  if (!elasticity.divided()) return {0, n};
  return {std::min(engines.layout.begin(), n), std::min(engines.layout.end(), n)};
}

// Adds the elastic forces on cloth at x to `forces` (n x 3) [N]. Collective if `elasticity` is
// divided among ranks.
void add_elastic_forces(const Points& x, const Engines& engines, Elasticity& elasticity,
                        Points& forces) {
  const Rows rows = cloth_rows(engines, elasticity);
  const Points still = Points::Zero(x.rows(), 3);
  elasticity.add_implicit_forces(engines.team, x, nullptr, rows.begin, rows.end, forces);
  elasticity.add_explicit_bending(engines.team, x, still, rows.begin, rows.end, forces);
  if (elasticity.divided()) gather_rows(engines.layout, forces);
}

// Adds to `forces` (n x 3) [N] a fraction of the forces that limit phases exert at x on cloths that
// bodies load. `yields` has the same meaning as in LimitPhase::enter(). Collective if `elasticity`
// is divided among ranks.
void add_limit_forces(const Points& x, const ContactTotals& contacts, const Engines& engines,
                      Elasticity& elasticity, Points& forces,
                      const std::uint8_t* yields = nullptr) {
  if (!engines.limits_in_solve || !engines.limiter) return;
  const CollisionModel& collision = engines.model.collision;
  const std::vector<std::uint8_t> loaded = loaded_by_bodies(engines.model, contacts);
  bool any = false;
  for (std::size_t s = 0; s < loaded.size(); ++s)
    any = any || (loaded[s] && collision.surfaces[s].kind == CollisionSurface::Kind::Cloth);
  if (!any) return;
  const Rows rows = cloth_rows(engines, elasticity);
  Points of_limits = Points::Zero(x.rows(), 3);
  static_cast<void>(elasticity.limit_phase(engines.team, x, rows.begin, rows.end, yields));
  elasticity.add_phase_forces(engines.team, x, rows.begin, rows.end, of_limits);
  if (elasticity.divided()) gather_rows(engines.layout, of_limits);
  for (Index v = 0; v < x.rows(); ++v)
    if (loaded[collision.surface_of_vertex(v)])
      forces.row(v) += share_of_limit_forces * of_limits.row(v);
}

// Returns the elastic and external forces on cloth at the start of the part (n x 3) [N], including
// those of add_limit_forces(). Returns no rows if no contact is closer than half its thickness.
// contact_stiffness() reads these forces, and stiffens no contact if there are no rows.
Points pressing_forces(const Loads& loads, const NearContacts& near, Engines& engines) {
  const ContactTotals& contacts = near.totals;
  if (!contacts.pressed) return Points(0, 3);
  const Points x = loads.x0.topRows(engines.model.cloth.n_vertices);
  Points forces = loads.force.whole(engines.model.cloth.n_vertices);
  add_elastic_forces(x, engines, *engines.elasticity, forces);
  add_limit_forces(x, contacts, engines, *engines.elasticity, forces,
                   near.yields.empty() ? nullptr : near.yields.data());
  return forces;
}

// Returns whether some rank has terms of contacts. Collective.
bool any_terms(const NearContacts& near, const Engines& engines) {
  const std::int64_t n_counted = near.contact_terms.n_counted();
  if (!near.terms_divided || near.totals.n == 0) return n_counted > 0;
  return near.totals.vertex_on_face || engines.layout.communicator().maximum(n_counted) > 0;
}

// Sets `forces` to the elastic and external forces on cloth in `state` (n x 3) [N], including those
// of add_limit_forces(). Unlike in pressing_forces(), no limit phase yields. Collective if
// `elasticity` is divided among ranks.
void find_pressing_forces(const State& state, double time, const ContactTotals& contacts,
                          const Engines& engines, Elasticity& elasticity, Points& forces) {
  forces = Points::Zero(state.cloth.x.rows(), 3);
  find_cloth_forces(time, state, engines, cloth_rows(engines, elasticity), forces);
  add_elastic_forces(state.cloth.x, engines, elasticity, forces);
  add_limit_forces(state.cloth.x, contacts, engines, elasticity, forces);
}

IndexRange owned_rows(const RowLayout& layout) { return {layout.begin(), layout.end()}; }

// Finds the pairs whose contacts the integrator handles at events, and passes them to
// engines.event_contacts. Sets NearContacts::v0 and NearContacts::touching.
void register_events(const StepContext& part, const Loads& loads, const State& state,
                     Engines& engines, NearContacts& near, StepReport& report) {
  const VertexVelocities velocities = predicted_velocities(part, loads, state, engines.model);
  near.v0.resize(loads.x0.rows(), 3);
  parallel_for(engines.team, static_cast<Index>(near.v0.rows()),
               [&](Index i) { near.v0.row(i) = velocities.row(i); });
  const ExpectedMotion motion{loads.x0, near.v0, part.h};
  Approach approach = engines.collision->approach(engines.collision_team, motion, near.tangle);
  report.contacts.candidates += approach.candidates;
  report.contacts.registered += static_cast<std::int64_t>(approach.pairs.size());
  for (const ApproachingPair& pair : approach.pairs)
    if (pair.contact)
      near.touching.push_back(pair_vertices(engines.model.collision, pair.kind, pair.key));
  report.contacts.near =
      std::max(report.contacts.near, static_cast<std::int64_t>(near.touching.size()));
  engines.event_contacts->set_pairs(motion, std::move(approach.pairs));
}

void find_contacts(const StepContext& part, const Loads& loads, const State& state,
                   Engines& engines, NearContacts& near, StepReport& report) {
  CollisionStage& collision = *engines.collision;
  const Index n = engines.model.cloth.n_vertices;
  if (state.tangled) near.tangle = collision.find_tangle(loads.x0);
  if (engines.event_contacts) return register_events(part, loads, state, engines, near, report);
  near.contacts = collision.proximity(engines.collision_team, loads.x0, near.tangle);
  near.totals = collision.totals();
  if (!engines.contacts_in_solve) near.repelled = near.contacts;
  if (!engines.contacts_in_solve) return;
  const Points of_obstacles = obstacle_changes(part, loads, state, engines.model);
  const VertexVelocities v0 = predicted_velocities(part, loads, state, engines.model),
                         change = expected_change(part, of_obstacles, state, engines.model);
  const Points forces = pressing_forces(loads, near, engines);
  ContactInputs inputs{
      loads.x0, v0, change, state.rigid.positions, part.h, n, engines.model.inverse_mass, forces};
  near.terms_divided = collision.divided();
  if (near.terms_divided) inputs.rows = owned_rows(engines.layout);
  near.contact_terms =
      collision.terms(engines.collision_team, inputs, near.contacts, state.contacts, near.terms);
  near.any_terms = any_terms(near, engines);
  collision.untangle(inputs, near.tangle, near.terms);
}

// Returns for each cloth vertex whether it touches an obstacle; no entries if none does. Reads the
// friction anchors, because every rank has those of all contacts.
std::vector<std::uint8_t> vertices_at_obstacles(const State& state, const Model& model) {
  const CollisionModel& collision = model.collision;
  const auto kind = [&](Index v) {
    return collision.surfaces[collision.surface_of_vertex(v)].kind;
  };
  std::vector<std::uint8_t> touch;
  for (const ContactState::Anchor& anchor : state.contacts.anchors) {
    const std::array<Index, 4> vertices =
        pair_vertices(collision, anchor.kind, pair_key(anchor.a, anchor.b));
    if (std::none_of(vertices.begin(), vertices.end(),
                     [&](Index v) { return kind(v) == CollisionSurface::Kind::Script; }))
      continue;
    touch.resize(model.cloth.n_vertices, 0);
    for (const Index v : vertices)
      if (kind(v) == CollisionSurface::Kind::Cloth) touch[v] = 1;
  }
  return touch;
}

// Sets NearContacts::forced and NearContacts::yields. Collective.
void find_forced_limits(const State& state, Engines& engines, NearContacts& near) {
  near.forced.clear(), near.yields.clear();
  if (!engines.limits_in_solve || !engines.limiter) return;
  const Model& model = engines.model;
  std::vector<std::uint8_t> touch = vertices_at_obstacles(state, model);
  if (touch.empty()) return;
  const auto surface = [&](Index v) { return model.collision.surface_of_vertex(v); };
  std::vector<std::uint8_t> forced(model.collision.surfaces.size(), 0);
  bool any = false;
  for (const Index t : engines.limiter->measure(engines.team, state.cloth.x).broken_elements())
    for (int c = 0; c < 3; ++c)
      if (const Index v = model.cloth.triangles(t, c); touch[v]) forced[surface(v)] = 1, any = true;
  if (!any) return;
  for (Index v = 0; v < model.cloth.n_vertices; ++v) touch[v] &= forced[surface(v)];
  near.forced = std::move(forced), near.yields = std::move(touch);
}

}  // namespace

std::vector<std::uint8_t> loaded_by_bodies(const Model& model, const ContactTotals& contacts) {
  using Kind = CollisionSurface::Kind;
  const CollisionModel& collision = model.collision;
  std::vector<std::uint8_t> loaded(collision.surfaces.size(), 0);
  for (std::size_t s = 0; s < loaded.size(); ++s)
    loaded[s] = collision.surfaces[s].kind == Kind::Body;
  for (const AttachedVertex& attached : model.attachments)
    loaded[collision.surface_of_vertex(attached.row)] = 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : contacts.surfaces)
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        if (loaded[from] && !loaded[to] && collision.surfaces[to].kind == Kind::Cloth)
          loaded[to] = 1, changed = true;
  }
  return loaded;
}

void find_near_contacts(const StepContext& part, const Loads& loads, const State& state,
                        Engines& engines, NearContacts& near, StepReport& report) {
  near.contacts.clear();
  near.totals = {};
  near.repelled.clear();
  near.touching.clear();
  near.terms.clear();
  near.contact_terms = {};
  near.any_terms = false;
  near.tangle = {};
  engines.contact_energy.reset();
  find_forced_limits(state, engines, near);
  if (engines.collision) find_contacts(part, loads, state, engines, near, report);
  const std::size_t n_contact_terms = near.terms.size();
  if (engines.integrator->implicit()) add_attachments(part, engines, state, near.terms);
  near.n_attachments = near.terms.size() - n_contact_terms;
  report.contacts.near = std::max(report.contacts.near, near.totals.n);
}

double energy_at_end(const State& state, double time, const Engines& engines) {
  const double energy = contact_energies(state, time, engines, *engines.elasticity).back();
  engines.contact_energy = {time, state.tangled, energy};
  return energy;
}

void know_contacts(const State& state, const Engines& engines) {
  if (!engines.collision || !engines.contacts_in_solve) return;
  Points x;
  collision_vertices(engines.model, state, x);
  engines.collision->proximity(engines.collision_team, x, {});
}

std::vector<double> contact_energies(const State& state, double time, const Engines& engines,
                                     Elasticity& elasticity, const Points* x0, int n_parts) {
  std::vector<double> energies(n_parts, 0.0);
  if (!engines.collision || !engines.contacts_in_solve) return energies;
  CollisionStage& collision = *engines.collision;
  const bool together = elasticity.divided() && collision.divided();
  Points x, forces(0, 3);
  collision_vertices(engines.model, state, x);
  const Tangle tangle = state.tangled ? collision.find_tangle(x) : Tangle();
  const std::vector<Contact>& contacts =
      together ? collision.proximity(engines.collision_team, x, tangle)
               : collision.proximity_alone(engines.team, x, tangle);
  const ContactTotals& totals = collision.totals();
  if (totals.n == 0) return energies;
  if (totals.pressed) find_pressing_forces(state, time, totals, engines, elasticity, forces);
  std::vector<BinnedSum> sums = collision.energies(
      {x, x0 ? *x0 : x, n_parts}, {x, engines.model.inverse_mass, forces, state.contacts}, contacts,
      together ? owned_rows(engines.layout) : all_indices);
  if (together) engines.layout.communicator().add(sums.data(), n_parts);
  for (int i = 0; i < n_parts; ++i) energies[i] = sums[i].value();
  return energies;
}

std::vector<Contact> present_contacts(const State& state, const Engines& engines) {
  if (!engines.collision) return {};
  Points x;
  collision_vertices(engines.model, state, x);
  const Tangle tangle = state.tangled ? engines.collision->find_tangle(x) : Tangle();
  Team uncounted = engines.team;
  uncounted.iterations = nullptr;  // only iterations within steps are counted
  return engines.collision->all_contacts(uncounted, x, tangle);
}

double terms_at(NearContacts& near, const Engines& engines, const Points& displacement, double time,
                TermRequest request, ExtraTerms& terms) {
  double energy = near.contact_terms.at(engines.collision_team, displacement, time, request, terms);
  for (std::size_t i = near.contact_terms.size(); i < terms.size(); ++i)
    energy += terms[i].move_linearly(displacement, time);
  return energy;
}

}  // namespace loomstone
