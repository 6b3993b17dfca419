// How fast what carries magnets and coils could oscillate now, which sub-steps must resolve
// (core/magnetics/forces/stiffness.h).
#include <algorithm>
#include <cmath>

#include "core/electrodynamics/magnetic_motion.h"
#include "core/sim/model/motion.h"

namespace loomstone {

namespace {

// Contacts are answered to first order in the sub-step, and friction damps what oscillates in them:
// bodies that touch something may take sub-steps four times as long. Our choice; of 250 iron balls
// of 10 mm that stick to one another two overlap by at most 0.08 mm then, by 0.06 in sub-steps half
// as long.
constexpr double touching_share = 1.0 / 16.0;

}  // namespace

double MagneticMotion::frequency(const Team& team, const RigidState& state,
                                 const std::vector<RigidPose>& obstacles, const Vector& currents,
                                 const RigidWorld& world) const {
  std::vector<Carrier> carriers(model_.n_bodies() + 1);
  for (Index b = 0; b < model_.n_bodies(); ++b)
    carriers[b] = {currents_.held(b) ? 0.0 : 1.0 / model_.body_mass[b].mass,
                   1.0 / rotors_[b].moments.minCoeff(), state.positions.row(b).transpose()};
  std::vector<CoarseMagnet> coarse = coarse_;
  std::vector<RigidPose> poses;
  std::vector<MagneticBody> magnets = now_.magnets;
  if (!induced_.empty() && !currents_.circuits().empty())  // as these magnetise them too
    magnets = placed(team, state, obstacles, carrying_coils(model_, state, obstacles, currents));
  for (const MagneticBody& magnet : magnets) poses.push_back(magnet.pose);
  // An induced moment changes on the way as well: of forces like r^-7 the derivative is 7/4 of that
  // of r^-4. Charge on a surface acts as its absolute value does, also where the whole moment is
  // small; of what is written as a sum of charges of both signs that is the least found.
  const auto spread = [](const SourcePtr& source) {
    double sum = 0.0;
    for (const PanelSample& sample : source->charges())
      sum += std::abs(sample.charge) * sample.position.norm();
    return sum;
  };
  std::vector<SoftSphere> spheres;
  const bool soft_spheres = !soft_ && !induced_.empty() && polarizabilities_.minCoeff() > 0.0;
  for (const Index i : induced_) {
    if (soft_spheres) {
      spheres.push_back(
          {groups_[i], poses[i].position, magnets[i].moment(), model_.magnets[i].radius});
      coarse[i].soft_sphere = true;
      coarse[i].moment =
          spheres.back().moment.norm() / static_cast<double>(coarse[i].positions->rows());
      continue;
    }
    const SourcePtr &source = magnets[i].source, panel_means = source->panel_means();
    double moment = source->induced() ? spread(source) : magnets[i].moment().norm();
    if (panel_means) moment = std::min(moment, spread(panel_means));
    coarse[i].moment = 1.75 * moment / static_cast<double>(coarse[i].positions->rows());
  }
  std::vector<Index> groups = groups_;
  for (std::size_t j = 0; j < model_.coils.size(); ++j) {
    const Model::Wound& wound = model_.coils[j];
    coarse.push_back(coarse_coils_[j]);
    coarse.back().moment *= std::abs(currents[static_cast<Eigen::Index>(j)]);
    poses.push_back(carried_pose(state, obstacles, wound.carrier, wound.local));
    groups.push_back(std::min(wound.carrier, model_.n_bodies()));
  }
  std::vector<double> squares =
      frequencies2(coarse, poses, groups, carriers, model_.scene.magnetic_field.norm());
  if (!spheres.empty()) {
    add_sphere_frequencies2(team, spheres, carriers, squares);
    for (std::size_t k = 0; k < hard_.size(); ++k) {
      const Index i = hard_[k];
      if (groups_[i] == model_.n_bodies())
        add_sphere_frequencies2(team, spheres, {coarse[i], poses[i], now_.known[k].there.gradient},
                                carriers, squares);
    }
    Points x(spheres.size(), 3);
    for (std::size_t k = 0; k < spheres.size(); ++k) x.row(k) = spheres[k].position.transpose();
    for (std::size_t j = 0; j < model_.coils.size(); ++j) {
      const std::size_t i = model_.magnets.size() + j;
      if (groups[i] != model_.n_bodies() || coarse[i].moment == 0.0) continue;
      const MagneticBody coil{
          wound_source(model_.scene.coils[j], currents[static_cast<Eigen::Index>(j)]), poses[i]};
      add_sphere_frequencies2(team, spheres,
                              {coarse[i], poses[i], magnetic_gradient(team, {coil}, x)}, carriers,
                              squares);
    }
  }
  const std::vector<std::uint8_t> touching = world.touching();
  for (std::size_t b = 0; b < touching.size(); ++b)
    if (touching[b]) squares[b] *= touching_share;
  return std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

}  // namespace loomstone
