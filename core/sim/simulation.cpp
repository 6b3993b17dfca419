#include "core/sim/simulation.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/message.h"
#include "core/collision/tangle/intersections.h"
#include "core/electrodynamics/coil_currents.h"
#include "core/integration/stable_step.h"
#include "core/parallel/agreement.h"
#include "core/sim/model/motion.h"
#include "core/sim/record/capture.h"
#include "core/sim/record/frame_magnets.h"
#include "core/sim/scene/scene_digest.h"
#include "core/sim/step/near_contacts.h"
#include "core/sim/step/step_choice.h"
#include "core/sim/step/stepper.h"
#include "core/sim/step/user_writes.h"

namespace loomstone {

namespace {

// Marks a running step. Throws if another step of the same simulation is running, because two
// concurrent steps would corrupt the state.
class Stepping {
 public:
  explicit Stepping(std::atomic_flag& flag) : flag_(flag) {
    if (flag_.test_and_set())
      throw Unsupported(
          "a step of this simulation is running in another thread; step a simulation from one "
          "thread at a time");
  }
  ~Stepping() { flag_.clear(); }

 private:
  std::atomic_flag& flag_;
};
}  // namespace

struct Simulation::Data {
  IntegratorOptions options;  // options.step() is steps.largest, even if steps are automatic
  StepChoice steps;
  std::map<std::string, std::string> digests;  // hashes of fields; see scene_digest.h
  Team team;
  std::shared_ptr<const Communicator> communicator;
  Decomposition decomposition = Decomposition::Predicted;
  Model model;
  std::unique_ptr<FrameTopology> topology;  // built in the first call of topology()
  State state;
  StepOutcome outcome;
  std::unique_ptr<RowLayout> layout;
  std::unique_ptr<Stepper> stepper;
  UserWrites writes;
  std::atomic_flag stepping = ATOMIC_FLAG_INIT;
  bool measured = false;  // true: energies and strains in the report are those of the current state
  std::int64_t iterations = 0;

  void make_stepper() {
    Team counted = team;
    counted.iterations = &iterations;
    stepper = std::make_unique<Stepper>(model, options, steps,
                                        Workers{counted, *layout, decomposition}, state);
  }
  Points to_user(const Points& rows) const {
    Points user(model.cloth.n_vertices, 3);
    for (Index i = 0; i < model.cloth.n_vertices; ++i)
      user.row(i) = rows.row(model.row_of_vertex[i]);
    return user;
  }
  std::vector<std::array<Index, 2>> to_user(std::vector<std::array<Index, 2>> triangles) const {
    const Index n = static_cast<Index>(model.triangle_of.size());
    for (auto& pair : triangles)
      for (Index& t : pair)
        if (t < n) t = model.triangle_of[t];
    return triangles;
  }
  void check_rows(const Points& user, const char* name) const {
    if (user.rows() != model.cloth.n_vertices)
      fail<InvalidInput>("{} must have {} rows (all cloth vertices), got {}", name,
                         model.cloth.n_vertices, user.rows());
    for (Index i = 0; i < user.rows(); ++i)
      if (!user.row(i).allFinite())
        fail<InvalidInput>("{} must be finite, but row {} is not; nothing was changed", name, i);
  }
  // Copies `user`, in the user's order, to `rows`, in row order. Does not reallocate `rows`, so
  // numpy views of it remain valid.
  void to_rows(const Points& user, const char* name, Points& rows,
               UserWrites::Kind kind = UserWrites::Table) {
    check_rows(user, name);
    for (Index i = 0; i < user.rows(); ++i) rows.row(model.row_of_vertex[i]) = user.row(i);
    note(kind);
  }
  void set_bodies(const Points& user, const char* name, Points& rows) {
    if (user.rows() != model.n_bodies())
      fail<InvalidInput>("{} must have {} rows (all rigid bodies), got {}", name, model.n_bodies(),
                         user.rows());
    for (Index i = 0; i < user.rows(); ++i)
      if (!user.row(i).allFinite())
        fail<InvalidInput>("{} must be finite, but row {} is not; nothing was changed", name, i);
    std::copy(user.data(), user.data() + user.size(), rows.data());
    note(UserWrites::Table);
  }
  void note(UserWrites::Kind kind) {
    writes.note(kind);
    measured = false;
  }
  void settle() {
    const UserWrites::Kind written = writes.settle(*layout, state);
    if (written >= UserWrites::Velocities) forget_last_step();
    if (written == UserWrites::Positions) state.tangled = 1;
  }
  // Collective. Measures the energies and strains of the report if there are several ranks, because
  // the user may later request the report on one rank alone. A run on one rank measures on request.
  void measure_together() {
    if (communicator->size() == 1) return;
    const std::int64_t counted = iterations;  // iterations of this measurement do not count
    know_contacts(state, stepper->engines());
    measure(state, state.time, stepper->engines(), Measuring::Together, outcome.report);
    iterations = counted;
    measured = true;
  }
  void forget_last_step() {
    state.cloth.forget_all();
    state.account = {};
    measured = false;
  }
};

namespace {
void check_attachments(const IntegratorOptions& integrator, const Model& model) {
  if (integrator.implicit() != nullptr || model.attachments.empty()) return;
  if (!integrator.is<Asynchronous>())
    fail<Unsupported>(
        "attachments require an implicit or asynchronous integrator, got {}; choose one of them or "
        "remove the attachments",
        integrator.name());
  for (std::size_t i = 1; i < model.attachments.size(); ++i) {
    const AttachedVertex &a = model.attachments[i - 1], &b = model.attachments[i];
    if (a.row == b.row)
      fail<Unsupported>(
          "attachments must tie a vertex to one body with an asynchronous integrator, got vertex "
          "{} of all cloths tied to {} and {}; attach it once, or choose an implicit integrator",
          model.vertex_of_row(a.row), model.scene.bodies[a.body].name,
          model.scene.bodies[b.body].name);
  }
}
}  // namespace

Simulation::Simulation(const Scene& scene, const IntegratorOptions& integrator, int threads,
                       std::shared_ptr<const Communicator> communicator,
                       Decomposition decomposition)
    : data_(std::make_unique<Data>()) {
  if (threads < 0 || threads > most_threads)
    fail<InvalidInput>("threads must be in [0, {}] (0: OMP_NUM_THREADS or all processors), got {}",
                       most_threads, threads);
  integrator.visit([](const auto& method) { check_fields(method, "integrator"); });
  data_->team.threads = threads == 0 ? default_thread_count() : threads;
  data_->communicator = std::move(communicator);
  data_->decomposition = decomposition;
  together(*data_->communicator, [&] { build(scene, data_->model, data_->state); });
  data_->digests = digests(scene, integrator);
  check_same_on_ranks(*data_->communicator, data_->digests);
  check_attachments(integrator, data_->model);
  together(*data_->communicator,
           [&] { data_->steps = choose_steps(integrator, data_->model, data_->state); });
  data_->options = integrator;
  data_->options.set_step(data_->steps.largest);
  data_->layout = std::make_unique<RowLayout>(data_->model.n_rows(), data_->communicator);
  data_->make_stepper();
  data_->outcome.start = data_->state;
  data_->outcome.contact.assign(data_->model.cloth.n_vertices, 0);
  together(*data_->communicator, [&] { data_->measure_together(); });
}

Simulation::~Simulation() = default;

void Simulation::step() {
  Data& d = *data_;
  const Stepping alone(d.stepping);
  together(*d.communicator, [&] { d.writes.check(d.model, d.state); });
  d.settle();
  together(*d.communicator, [&] {
    d.stepper->advance(d.state, d.outcome);
    d.measured = false;
    d.measure_together();
  });
  d.writes.remember(d.state);
}

double Simulation::time() const { return data_->state.time; }
std::int64_t Simulation::step_index() const { return data_->state.step; }
double Simulation::step_size() const { return data_->steps.largest; }
double Simulation::stable_step() const {
  const Model& model = data_->model;
  Elasticity elasticity(model.cloth, BendingTreatment::Explicit);
  return loomstone::stable_step(elasticity, model.cloth, data_->state.cloth.x);
}
int Simulation::threads() const { return data_->team.threads; }
void Simulation::keep_collision_motion(bool keep) {
  if (CollisionStage* const collision = data_->stepper->engines().collision.get())
    collision->keep_motion(keep);
}
CollisionRecord Simulation::collision_motion() const {
  const CollisionStage* const collision = data_->stepper->engines().collision.get();
  return collision ? collision->motion() : CollisionRecord{};
}
std::size_t Simulation::hierarchy_bytes() const {
  const CollisionStage* const collision = data_->stepper->engines().collision.get();
  return collision ? collision->hierarchy_bytes() : 0;
}
std::vector<Simulation::MemoryPart> Simulation::memory() const {
  const Data& d = *data_;
  const Engines& engines = d.stepper->engines();
  const CollisionStage* const collision = engines.collision.get();
  const Integrator::Memory solve = engines.integrator->memory();
  const auto of_all = [&](std::size_t (Elasticity::*bytes)() const) {
    return engines.all_elements ? (*engines.all_elements.*bytes)() : 0;
  };
  return {{"model", d.model.bytes() + bytes_of(d.topology)},
          {"state", bytes_of(d.state, d.outcome.start, d.outcome.contact, d.writes)},
          {"step", d.stepper->step_bytes()},
          {"membrane", engines.elasticity->membrane_bytes() + of_all(&Elasticity::membrane_bytes)},
          {"bending", engines.elasticity->bending_bytes() + of_all(&Elasticity::bending_bytes)},
          {"strain_limits", bytes_of(engines.limiter)},
          {"matrix", engines.elasticity->matrix_bytes() + of_all(&Elasticity::matrix_bytes)},
          {"solver", solve.solver},
          {"preconditioner", solve.preconditioner},
          {"collision_model", d.model.collision.bytes()},
          {"hierarchies", collision ? collision->hierarchy_bytes() : 0},
          {"neighbour_lists", collision ? collision->list_bytes() : 0},
          {"contacts", d.stepper->contact_bytes()},
          {"recorded_motion", collision ? collision->motion_bytes() : 0}};
}
Decomposition Simulation::decomposition() const { return data_->decomposition; }
const Communicator& Simulation::communicator() const { return *data_->communicator; }

const StepReport& Simulation::report() const {
  if (!data_->measured || data_->writes.watching()) {
    // Not collective, because the user may have requested the report on this rank alone.
    measure(data_->state, time(), data_->stepper->engines(), Measuring::Alone,
            data_->outcome.report);
    data_->measured = true;
  }
  return data_->outcome.report;
}

bool Simulation::may_checkpoint() const {
  return data_->model.n_bodies() == 0 ||
         data_->state.step % data_->model.scene.rigid_rebuild_interval == 0;
}

const FrameTopology& Simulation::topology() const {
  if (!data_->topology)
    data_->topology = std::make_unique<FrameTopology>(frame_topology(data_->model));
  return *data_->topology;
}

Frame Simulation::frame() const { return frame_at(time()); }

Frame Simulation::frame_at(double at) const {
  const double start = data_->outcome.start.time, length = time() - start;
  // Allows for rounding errors in times that users compute.
  const double slack = 1e-9 * data_->steps.largest;
  if (!std::isfinite(at) || at > time() + slack || at < start - slack)
    fail<InvalidInput>("a frame must lie within the last step ({} to {} s), got {} s", start,
                       time(), at);
  report();
  // If the time is the end of the step up to rounding, the frame shows the state itself.
  const FrameTime end{time(), 1.0};
  const double share = length > 0.0 ? (at - start) / length : 1.0;
  return capture(data_->state, data_->outcome, data_->stepper->engines(),
                 time() - at > slack ? FrameTime{at, std::max(share, 0.0)} : end);
}

const std::vector<Index>& Simulation::vertex_order() const { return data_->model.row_of_vertex; }

Points Simulation::positions() const { return data_->to_user(data_->state.cloth.x); }
void Simulation::set_positions(const Points& positions) {
  data_->to_rows(positions, "positions", data_->state.cloth.x, UserWrites::Positions);
  data_->state.tangled = 1;
  data_->forget_last_step();
}
Points Simulation::velocities() const { return data_->to_user(data_->state.cloth.v); }
void Simulation::set_velocities(const Points& velocities) {
  data_->to_rows(velocities, "velocities", data_->state.cloth.v, UserWrites::Velocities);
  data_->forget_last_step();
}
Points Simulation::external_forces() const {
  const Points& rows = data_->state.external_force;
  return rows.rows() > 0 ? data_->to_user(rows) : Points::Zero(data_->model.cloth.n_vertices, 3);
}
void Simulation::set_external_forces(const Points& forces) {
  data_->to_rows(forces, "external_forces", data_->state.made(data_->state.external_force));
}
Points Simulation::external_body_forces() const { return data_->state.body_force; }
void Simulation::set_external_body_forces(const Points& forces) {
  data_->set_bodies(forces, "external_body_forces", data_->state.body_force);
}
Points Simulation::external_body_torques() const { return data_->state.body_torque; }
void Simulation::set_external_body_torques(const Points& torques) {
  data_->set_bodies(torques, "external_body_torques", data_->state.body_torque);
}

void Simulation::set_pin_targets(const Points& targets) {
  const std::vector<std::uint8_t>& pinned = data_->model.cloth.prescribed;
  const bool any = std::find(pinned.begin(), pinned.end(), 1) != pinned.end();
  Points of_pins = targets;
  for (Index i = 0; any && i < std::min<Index>(of_pins.rows(), data_->model.cloth.n_vertices); ++i)
    if (!pinned[data_->model.row_of_vertex[i]]) of_pins.row(i).setZero();
  data_->check_rows(of_pins, "pin_targets");
  if (!any)
    throw InvalidInput("the cloth must have pins to move them, but has none; give Cloth.pins");
  data_->to_rows(of_pins, "pin_targets", data_->state.made(data_->state.pin_target));
  data_->state.pin_override = pinned;
  data_->state.target_time = time() + step_size();
}

void Simulation::set_obstacle_pose(int obstacle, const Vec3& position, const Vec4& orientation) {
  const int n = static_cast<int>(data_->model.obstacles.size());
  if (n == 0) throw InvalidInput("the scene must have obstacles to move one, but has none");
  if (obstacle < 0 || obstacle >= n)
    fail<InvalidInput>("obstacle must be in [0, {}], got {}", n - 1, obstacle);
  if (!position.allFinite() || !(std::abs(orientation.norm() - 1.0) <= 1e-6))
    throw InvalidInput(
        "an obstacle's pose must be a finite position [m] and a unit quaternion (w, x, y, z)");
  data_->state.pose_override[obstacle] = 1;
  data_->state.target_time = time() + step_size();
  data_->state.pose_position.row(obstacle) = position.transpose();
  data_->state.pose_orientation.row(obstacle) = orientation.normalized().transpose();
  data_->note(UserWrites::Table);
}

Points Simulation::body_centres() const { return data_->state.rigid.positions; }

std::array<Points, 2> Simulation::magnetic_forces() const {
  const std::vector<Wrench> wrenches =
      loomstone::magnetic_forces(data_->state, time(), data_->stepper->engines());
  std::array<Points, 2> rows = {Points(wrenches.size(), 3), Points(wrenches.size(), 3)};
  for (std::size_t b = 0; b < wrenches.size(); ++b) {
    rows[0].row(b) = wrenches[b].force.transpose();
    rows[1].row(b) = wrenches[b].torque.transpose();
  }
  return rows;
}

const CircuitState& Simulation::circuits() const { return data_->state.magnetic.circuits; }

double Simulation::current() const {
  return first_circuit_current(data_->model.magnetics, circuits());
}
Vector Simulation::currents() const {
  return coil_currents(data_->model.magnetics, circuits(), time());
}

std::vector<MagneticBody> Simulation::magnets(const Frame& frame) const {
  return magnets_of_frame(data_->team, data_->model, frame);
}

State& Simulation::state() {
  data_->writes.watch(data_->state);
  return data_->state;
}

std::array<Index, 2> Simulation::owned_rows() const {
  const Index n = data_->model.cloth.n_vertices;
  return {std::min(data_->layout->begin(), n), std::min(data_->layout->end(), n)};
}

void Simulation::gather() {
  data_->writes.note(UserWrites::Table);
  data_->settle();
  gather_rows(*data_->layout, data_->state.cloth.previous_bending);
}

std::int64_t Simulation::loop_iterations() const { return data_->iterations; }

Checkpoint Simulation::checkpoint() const {
  if (!may_checkpoint())
    fail<InvalidInput>(
        "a scene with rigid bodies can be saved only at multiples of scene.rigid_rebuild_interval "
        "= {} steps, got step {}",
        data_->model.scene.rigid_rebuild_interval, data_->state.step);
  data_->settle();
  // previous_bending is up to date only in the rows of this rank.
  gather_rows(*data_->layout, data_->state.cloth.previous_bending);
  Checkpoint made = to_checkpoint(data_->model, data_->state, data_->outcome);
  made.texts = data_->digests;
  return made;
}

void Simulation::restore(const Checkpoint& checkpoint) {
  together(*data_->communicator, [&] {
    check_digests(checkpoint.texts, data_->digests);
    from_checkpoint(data_->model, checkpoint, data_->state, data_->outcome);
  });
  data_->outcome.report = StepReport{};
  data_->outcome.path.clear();
  data_->outcome.forced.clear();
  data_->outcome.broken.clear();
  data_->outcome.report.step = data_->state.step;
  data_->outcome.report.time = time();
  data_->outcome.start = data_->state;
  data_->measured = false;
  data_->writes.forget();
  data_->writes.remember(data_->state);
  data_->make_stepper();
  data_->measure_together();
}

void Simulation::rebuild_stages() { data_->make_stepper(); }

std::vector<std::array<Index, 2>> Simulation::intersecting_pairs() const {
  Points vertices;
  collision_vertices(data_->model, data_->state, vertices);
  return data_->to_user(loomstone::intersecting_pairs(vertices, data_->model.collision.triangles));
}

std::vector<Contact> Simulation::near_contacts() const {
  const Data& d = *data_;
  std::vector<Contact> contacts = present_contacts(d.state, d.stepper->engines());
  std::vector<Index> user(d.model.row_of_vertex.size());
  for (std::size_t i = 0; i < user.size(); ++i)
    user[d.model.row_of_vertex[i]] = static_cast<Index>(i);
  for (Contact& contact : contacts)
    for (Index& vertex : contact.vertices)
      if (vertex < d.model.cloth.n_vertices) vertex = user[vertex];
  return contacts;
}

std::vector<BrokenLimit> Simulation::broken_limits() const {
  std::vector<BrokenLimit> broken = data_->outcome.broken;
  for (BrokenLimit& each : broken) each.element = data_->model.triangle_of[each.element];
  return broken;
}

std::vector<std::array<Index, 2>> Simulation::forced_pairs() const {
  return data_->to_user(data_->outcome.forced);
}

}  // namespace loomstone
