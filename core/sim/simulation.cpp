#include "core/sim/simulation.h"

#include <cmath>

#include "core/base/error.h"
#include "core/sim/capture.h"
#include "core/sim/motion.h"
#include "core/sim/stepper.h"

namespace loomstone {

struct Simulation::Data {
  IntegratorOptions options;
  Team team;
  std::shared_ptr<const Communicator> communicator;
  Model model;
  State state;
  StepOutcome outcome;
  std::unique_ptr<RowLayout> layout;
  std::unique_ptr<Stepper> stepper;
  bool measured = false;   // energies of the report are those of the state

  void make_stepper() {
    stepper = std::make_unique<Stepper>(model, options, team, *layout, state);
  }
  Points to_user(const Points& rows) const {
    Points user(model.cloth.n_vertices, 3);
    for (Index i = 0; i < model.cloth.n_vertices; ++i) user.row(i) = rows.row(model.row_of_vertex[i]);
    return user;
  }
  Points to_rows(const Points& user, const char* name) const {
    if (user.rows() != model.cloth.n_vertices)
      throw InvalidInput(std::string(name) + " must have " + std::to_string(model.cloth.n_vertices) +
                         " rows (all cloth vertices), got " + std::to_string(user.rows()));
    Points rows(user.rows(), 3);
    for (Index i = 0; i < user.rows(); ++i) {
      if (!user.row(i).allFinite())
        throw InvalidInput(std::string(name) + " must be finite, row " + std::to_string(i) + " is not");
      rows.row(model.row_of_vertex[i]) = user.row(i);
    }
    return rows;
  }
  void forget_history() {
    state.cloth.last_change.resize(0, 3);
    state.cloth.previous_x.resize(0, 3);
    state.cloth.previous_v.resize(0, 3);
    state.cloth.previous_bending.resize(0, 3);
    measured = false;
  }
};

Simulation::Simulation(const Scene& scene, const IntegratorOptions& integrator, int threads,
                       std::shared_ptr<const Communicator> communicator)
    : data_(std::make_unique<Data>()) {
  if (threads < 0) throw InvalidInput("threads must be >= 0 (0: all processors), got " + std::to_string(threads));
  check_fields(integrator, "integrator");
  if (integrator.jacobian != "spd" && integrator.jacobian != "exact")
    throw InvalidInput("integrator.jacobian must be spd or exact, got \"" + integrator.jacobian + "\"");
  data_->options = integrator;
  data_->team.threads = threads == 0 ? default_thread_count() : threads;
  data_->communicator = std::move(communicator);
  build(scene, data_->model, data_->state);
  data_->layout = std::make_unique<RowLayout>(data_->model.n_rows(), data_->communicator);
  data_->make_stepper();
  data_->outcome.start_cloth = data_->state.cloth.x;
  data_->outcome.contact.assign(data_->model.cloth.n_vertices, 0);
}

Simulation::~Simulation() = default;

void Simulation::step() {
  data_->measured = false;
  data_->stepper->advance(data_->state, data_->outcome);
}

double Simulation::time() const { return static_cast<double>(data_->state.step) * data_->options.step; }
std::int64_t Simulation::step_index() const { return data_->state.step; }
double Simulation::step_size() const { return data_->options.step; }
int Simulation::threads() const { return data_->team.threads; }
const Communicator& Simulation::communicator() const { return *data_->communicator; }

const StepReport& Simulation::report() const {
  if (!data_->measured) {
    measure(data_->model, data_->state, data_->team, data_->stepper->elasticity(), data_->outcome.report);
    data_->measured = true;
  }
  return data_->outcome.report;
}

bool Simulation::may_checkpoint() const {
  return data_->model.n_bodies() == 0 || data_->state.step % data_->model.scene.rigid_rebuild_interval == 0;
}

const FrameTopology& Simulation::topology() const { return data_->model.topology; }

Frame Simulation::frame() const { return frame_at(time()); }

Frame Simulation::frame_at(double at) const {
  const double share = 1.0 - (time() - at) / data_->options.step;
  if (share > 1.0 + 1e-9 || share < -1e-9)
    throw InvalidInput("a frame must lie within the last step (" + std::to_string(time() - data_->options.step) + " to " +
                       std::to_string(time()) + " s), got " + std::to_string(at));
  report();
  // Within rounding of the end of the step the state itself is the frame.
  return capture(data_->model, data_->state, data_->outcome, data_->team, data_->stepper->elasticity(),
                 data_->options.step, share > 1.0 - 1e-9 ? 1.0 : share);
}

const std::vector<Index>& Simulation::vertex_order() const { return data_->model.row_of_vertex; }

Points Simulation::positions() const { return data_->to_user(data_->state.cloth.x); }
void Simulation::set_positions(const Points& positions) {
  data_->state.cloth.x = data_->to_rows(positions, "positions");
  data_->state.tangled = 1;
  data_->forget_history();
}
Points Simulation::velocities() const { return data_->to_user(data_->state.cloth.v); }
void Simulation::set_velocities(const Points& velocities) {
  data_->state.cloth.v = data_->to_rows(velocities, "velocities");
  data_->forget_history();
}
Points Simulation::external_forces() const { return data_->to_user(data_->state.external_force); }
void Simulation::set_external_forces(const Points& forces) {
  data_->state.external_force = data_->to_rows(forces, "external_forces");
}

void Simulation::set_pin_targets(const Points& targets) {
  data_->state.pin_target = data_->to_rows(targets, "pin_targets");
  data_->state.pin_override = data_->model.cloth.pinned;
}

void Simulation::set_obstacle_pose(int obstacle, const Vec3& position, const Vec4& orientation) {
  const int n = static_cast<int>(data_->model.obstacles.size());
  if (obstacle < 0 || obstacle >= n)
    throw InvalidInput("obstacle must be in [0, " + std::to_string(n - 1) + "], got " + std::to_string(obstacle));
  if (!position.allFinite() || std::abs(orientation.norm() - 1.0) > 1e-6)
    throw InvalidInput("an obstacle's pose must be a finite position [m] and a unit quaternion (w, x, y, z)");
  data_->state.pose_override[obstacle] = 1;
  data_->state.pose_position.row(obstacle) = position.transpose();
  data_->state.pose_orientation.row(obstacle) = orientation.normalized().transpose();
}

Points Simulation::body_positions() const { return data_->state.rigid.positions; }

Checkpoint Simulation::checkpoint() const {
  if (!may_checkpoint())
    throw InvalidInput("a scene with rigid bodies can be saved only at multiples of scene.rigid_rebuild_interval = " +
                       std::to_string(data_->model.scene.rigid_rebuild_interval) + " steps, this is step " +
                       std::to_string(data_->state.step));
  // Every rank owns a part of what integrators keep of explicit bending.
  if (data_->state.cloth.previous_bending.rows() == data_->model.cloth.n_vertices && !data_->layout->single()) {
    Points wide = Points::Zero(data_->model.n_rows(), 3);
    wide.topRows(data_->model.cloth.n_vertices) = data_->state.cloth.previous_bending;
    data_->layout->gather(wide.data(), 3);
    data_->state.cloth.previous_bending = wide.topRows(data_->model.cloth.n_vertices);
  }
  return to_checkpoint(data_->model, data_->state, data_->outcome);
}

void Simulation::restore(const Checkpoint& checkpoint) {
  from_checkpoint(data_->model, checkpoint, data_->state, data_->outcome);
  data_->outcome.report = StepReport{};
  data_->outcome.report.step = data_->state.step;
  data_->outcome.report.time = time();
  data_->outcome.start_cloth = data_->state.cloth.x;
  Points vertices;
  collision_vertices(data_->model, data_->state, vertices);
  data_->outcome.start_surfaces = vertices.bottomRows(vertices.rows() - data_->model.cloth.n_vertices);
  data_->measured = false;
  data_->make_stepper();
}

void Simulation::rebuild_stages() { data_->make_stepper(); }

std::vector<std::array<Index, 2>> Simulation::intersecting_pairs() const {
  Points vertices;
  collision_vertices(data_->model, data_->state, vertices);
  auto pairs = loomstone::intersecting_pairs(vertices, data_->model.collision.triangles);
  const Index n = static_cast<Index>(data_->model.triangle_of.size());
  for (auto& pair : pairs)
    for (Index& t : pair)
      if (t < n) t = data_->model.triangle_of[t];
  return pairs;
}

}  // namespace loomstone
