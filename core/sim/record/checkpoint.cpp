// Conversion of State to and from a checkpoint, table by table.
#include <algorithm>
#include <cmath>

#include "core/base/message.h"
#include "core/sim/record/capture.h"

namespace loomstone {

namespace {

template <class Matrix>
void put(Checkpoint& c, const std::string& name, const Matrix& matrix) {
  auto& array = c.arrays[name];
  array.shape = {matrix.rows(), matrix.cols()};
  array.values.assign(matrix.data(), matrix.data() + matrix.size());
}

template <class Matrix>
void get(const Checkpoint& c, const std::string& name, Matrix& matrix) {
  const auto found = c.arrays.find(name);
  if (found == c.arrays.end() || found->second.shape.size() != 2 ||
      static_cast<Index>(found->second.shape[0] * found->second.shape[1]) !=
          static_cast<Index>(found->second.values.size()))
    throw CacheError("the checkpoint has no usable table \"" + name +
                     "\"; it was written by another version");
  matrix.resize(found->second.shape[0], found->second.shape[1]);
  std::copy(found->second.values.begin(), found->second.values.end(), matrix.data());
}

// Reads a table whose size is determined by the scene. The table must have the shape of `now`.
template <class Matrix>
void get(const Checkpoint& c, const std::string& name, Matrix& matrix, const Matrix& now) {
  get(c, name, matrix);
  if (matrix.rows() != now.rows() || matrix.cols() != now.cols())
    fail<CacheError>(
        "the checkpoint's table \"{}\" must have {} x {} numbers, got {} x {}; it is damaged", name,
        now.rows(), now.cols(), matrix.rows(), matrix.cols());
}

// Reads a table. If the checkpoint does not contain it, the table has no rows.
template <class Matrix>
void get_if_present(const Checkpoint& c, const std::string& name, Matrix& matrix) {
  matrix.resize(0, matrix.cols());
  if (c.arrays.count(name)) get(c, name, matrix);
}

// Reads a table. If the checkpoint does not contain it, all entries are zero.
void get_unless_zero(const Checkpoint& c, const std::string& name, Points& matrix) {
  if (c.arrays.count(name))
    get(c, name, matrix, Points(matrix));
  else
    matrix.setZero();
}

const std::vector<std::int64_t>& integers(const Checkpoint& c, const std::string& name) {
  const auto found = c.integers.find(name);
  if (found == c.integers.end())
    throw CacheError("the checkpoint has no list \"" + name +
                     "\"; it was written by another version");
  return found->second;
}

std::int64_t integer(const Checkpoint& c, const std::string& name) {
  const std::vector<std::int64_t>& list = integers(c, name);
  if (list.size() != 1)
    throw CacheError("the checkpoint's \"" + name + "\" is not one number; it is damaged");
  return list[0];
}

std::vector<std::uint8_t> flags(const Checkpoint& c, const std::string& name) {
  const auto found = c.bytes.find(name);
  if (found == c.bytes.end())
    throw CacheError("the checkpoint has no flags \"" + name +
                     "\"; it was written by another version");
  return found->second;
}

// Returns whether some entry is not +0.
bool has_values(const Points& table) {
  return std::any_of(table.data(), table.data() + table.size(),
                     [](double value) { return value != 0.0 || std::signbit(value); });
}

// Writes a table of cloth rows. A table without rows is written with zeros in all rows.
void put_rows(Checkpoint& c, const std::string& name, const Points& table, const State& state) {
  const Index n = state.cloth.x.rows();
  put(c, name, table.rows() == n ? table : Points(Points::Zero(n, 3)));
}

Vector vector_of(std::initializer_list<double> values) {
  return Eigen::Map<const Vector>(values.begin(), static_cast<Index>(values.size()));
}

void get_account(const Checkpoint& c, EnergyAccount& account) {
  Vector a;
  get(c, "account", a, Vector(Vector::Zero(10)));
  account = {a[0] != 0.0, a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8], a[9]};
}

// Reads the state of cloth. On entry, `cloth` has positions and velocities of the size that the
// checkpoint must have.
void get_cloth(const Checkpoint& c, ClothState& cloth) {
  const Points like = cloth.x;
  get(c, "cloth.x", cloth.x, like);
  get(c, "cloth.v", cloth.v, like);
  get(c, "cloth.last_change", cloth.last_change);
  get(c, "cloth.previous_x", cloth.previous_x);
  get(c, "cloth.previous_v", cloth.previous_v);
  get(c, "cloth.previous_bending", cloth.previous_bending);
  // Only the asynchronous integrator writes these tables.
  get_if_present(c, "cloth.element_steps", cloth.element_steps);
  get_if_present(c, "cloth.element_clocks", cloth.element_clocks);
  get_if_present(c, "cloth.element_positions", cloth.element_positions);
}

// Reads `external_force` and `pin_target` into `s`, which is later copied to `state`. This copy
// must not change the size of a table, because numpy views refer to its memory in `state`. If a
// stored table has values other than +0, `state` therefore gets rows for it first. If all values of
// a stored table are +0 and `state` has no rows for it, the rows of `s` are removed.
void get_user_rows(const Checkpoint& c, State& s, State& state) {
  get(c, "external_force", s.external_force, state.cloth.x);
  get(c, "pin_target", s.pin_target, state.cloth.x);
  for (Points State::* const table : {&State::external_force, &State::pin_target}) {
    if (has_values(s.*table)) state.made(state.*table);
    if ((state.*table).rows() == 0) (s.*table).resize(0, 3);
  }
}

}  // namespace

Checkpoint to_checkpoint(const Model& model, const State& state, const StepOutcome& outcome) {
  Checkpoint c;
  c.integers["counts"] = {model.cloth.n_vertices, model.cloth.triangles.rows(), model.n_bodies(),
                          static_cast<std::int64_t>(model.obstacles.size()),
                          model.collision.n_vertices};
  c.integers["step"] = {state.step};
  put(c, "times",
      vector_of({state.time, state.cloth.previous_step, state.cloth.expected_step,
                 state.cloth.settled_step, state.target_time}));
  c.integers["tangled"] = {state.tangled};
  const EnergyAccount& a = state.account;
  put(c, "account",
      vector_of({a.begun ? 1.0 : 0.0, a.start, a.start_of_contacts, a.scripts, a.loads, a.friction,
                 a.damping, a.limits, a.withheld, a.largest_kinetic}));
  put(c, "cloth.x", state.cloth.x);
  put(c, "cloth.v", state.cloth.v);
  put(c, "cloth.last_change", state.cloth.last_change);
  put(c, "cloth.previous_x", state.cloth.previous_x);
  put(c, "cloth.previous_v", state.cloth.previous_v);
  put(c, "cloth.previous_bending", state.cloth.previous_bending);
  if (state.cloth.element_steps.size() > 0)
    put(c, "cloth.element_steps", state.cloth.element_steps);
  if (state.cloth.element_clocks.size() > 0)
    put(c, "cloth.element_clocks", state.cloth.element_clocks);
  if (state.cloth.element_positions.size() > 0)
    put(c, "cloth.element_positions", state.cloth.element_positions);
  put(c, "rigid.positions", state.rigid.positions);
  put(c, "rigid.orientations", state.rigid.orientations);
  put(c, "rigid.velocities", state.rigid.velocities);
  put(c, "rigid.angular_velocities", state.rigid.angular_velocities);
  const CircuitState& circuits = state.magnetic.circuits;
  put(c, "circuits", Vec4(circuits.energy, circuits.heat, circuits.supply, circuits.bearings));
  put(c, "circuits.currents", circuits.currents);
  put(c, "induced_moments", state.magnetic.moments);
  c.bytes["rigid.manifolds"] = state.rigid.manifolds;
  const auto& anchors = state.contacts.anchors;
  Points slip(anchors.size(), 3);
  Vector force(anchors.size());
  auto& ids = c.integers["contacts.ids"];
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    slip.row(i) = anchors[i].slip.transpose();
    force[i] = anchors[i].normal_force;
    ids.insert(ids.end(), {static_cast<std::int64_t>(anchors[i].kind), anchors[i].a, anchors[i].b});
  }
  put(c, "contacts.slip", slip);
  put(c, "contacts.normal_force", force);
  put(c, "obstacle_vertices", state.obstacle_vertices);
  if (state.previous_obstacle_vertices.rows() > 0)
    put(c, "previous_obstacle_vertices", state.previous_obstacle_vertices);
  put_rows(c, "external_force", state.external_force, state);
  if (!state.body_force.isZero(0.0)) put(c, "body_force", state.body_force);
  if (!state.body_torque.isZero(0.0)) put(c, "body_torque", state.body_torque);
  put_rows(c, "pin_target", state.pin_target, state);
  c.bytes["pin_override"] = state.pin_override;
  put(c, "pose_position", state.pose_position);
  put(c, "pose_orientation", state.pose_orientation);
  c.bytes["pose_override"] = state.pose_override;
  c.bytes["contact_flags"] = outcome.contact;  // needed by frames captured before the next step
  return c;
}

void from_checkpoint(const Model& model, const Checkpoint& c, State& state, StepOutcome& outcome) {
  const std::vector<std::int64_t> counts = {
      model.cloth.n_vertices, model.cloth.triangles.rows(), model.n_bodies(),
      static_cast<std::int64_t>(model.obstacles.size()), model.collision.n_vertices};
  if (integers(c, "counts") != counts)
    throw CacheError(
        "the checkpoint is of another scene (its counts of vertices, triangles, bodies or "
        "obstacles differ); resume with the scene and parameters of the run");
  State s = state;
  s.step = integer(c, "step");
  Vector times;
  get(c, "times", times, Vector(Vector::Zero(5)));
  s.time = times[0], s.cloth.previous_step = times[1], s.cloth.expected_step = times[2];
  s.cloth.settled_step = times[3], s.target_time = times[4];
  s.tangled = static_cast<std::uint8_t>(integer(c, "tangled"));
  get_account(c, s.account);
  get_cloth(c, s.cloth);
  get(c, "rigid.positions", s.rigid.positions, state.rigid.positions);
  get(c, "rigid.orientations", s.rigid.orientations, state.rigid.orientations);
  get(c, "rigid.velocities", s.rigid.velocities, state.rigid.velocities);
  get(c, "rigid.angular_velocities", s.rigid.angular_velocities, state.rigid.angular_velocities);
  s.rigid.manifolds = flags(c, "rigid.manifolds");
  Vector energies;
  get(c, "circuits", energies, Vector(Vector::Zero(4)));
  CircuitState& circuits = s.magnetic.circuits;
  circuits.energy = energies[0], circuits.heat = energies[1], circuits.supply = energies[2];
  circuits.bearings = energies[3];
  get(c, "circuits.currents", circuits.currents, state.magnetic.circuits.currents);
  get_if_present(c, "induced_moments", s.magnetic.moments);
  Points slip;
  Vector force;
  get(c, "contacts.slip", slip);
  get(c, "contacts.normal_force", force);
  const auto& ids = integers(c, "contacts.ids");
  if (static_cast<Index>(ids.size()) != 3 * slip.rows() || force.size() != slip.rows())
    throw CacheError("the checkpoint's friction anchors do not fit together; it is damaged");
  s.contacts.anchors.resize(slip.rows());
  for (Index i = 0; i < slip.rows(); ++i)
    s.contacts.anchors[i] = {static_cast<ContactKind>(ids[3 * i]),
                             static_cast<Index>(ids[3 * i + 1]), static_cast<Index>(ids[3 * i + 2]),
                             slip.row(i).transpose(), force[i]};
  get(c, "obstacle_vertices", s.obstacle_vertices, state.obstacle_vertices);
  get_if_present(c, "previous_obstacle_vertices", s.previous_obstacle_vertices);
  if (s.previous_obstacle_vertices.rows() > 0)
    get(c, "previous_obstacle_vertices", s.previous_obstacle_vertices, state.obstacle_vertices);
  get_unless_zero(c, "body_force", s.body_force);
  get_unless_zero(c, "body_torque", s.body_torque);
  s.pin_override = flags(c, "pin_override");
  get(c, "pose_position", s.pose_position, state.pose_position);
  get(c, "pose_orientation", s.pose_orientation, state.pose_orientation);
  s.pose_override = flags(c, "pose_override");
  std::vector<std::uint8_t> contact = flags(c, "contact_flags");
  if (s.pin_override.size() != state.pin_override.size() ||
      s.pose_override.size() != state.pose_override.size() ||
      contact.size() != static_cast<std::size_t>(model.cloth.n_vertices))
    throw CacheError("the checkpoint's flags do not fit its tables; it is damaged");
  outcome.contact = std::move(contact);
  get_user_rows(c, s, state);
  state = s;  // copied, not moved, so that numpy views remain valid
}

}  // namespace loomstone
