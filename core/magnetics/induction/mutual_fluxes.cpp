#include "core/magnetics/induction/mutual_fluxes.h"

namespace loomstone {

MutualFluxes::MutualFluxes(const Team& team, const PanelSet& on, const RigidPose& pose,
                           const PanelSet& by)
    : pose_(pose) {
  for (const GridPair& grids : interacting_grids(on, by)) {
    Part& part = parts_.emplace_back();
    part.share = grids.share;
    part.on = std::make_unique<const PanelClusters>(on, grids.one);
    part.by = std::make_unique<const PanelClusters>(by, grids.other);
    part.pairs = std::make_unique<const ClusterPairs>(*part.on, pose, *part.by);
    part.near.resize(part.on->clusters().size());
    parallel_tasks(team, static_cast<Index>(part.near.size()), [&](Index c) {
      const PanelCluster& to = part.on->clusters()[c];
      for (const Index b : part.pairs->near[c]) {
        const PanelCluster& from = part.by->clusters()[b];
        part.near[c].push_back(panel_fluxes({part.on->panels(), to.begin, to.end}, pose,
                                            {part.by->panels(), from.begin, from.end}));
      }
    });
  }
}

void MutualFluxes::add(const Team& team, const Vector& charges, Vector& fluxes) const {
  for (const Part& part : parts_) {
    const Vector own = part.by->gathered(charges);
    Vector sum = part.on->fluxes(
        far_fields(team, *part.pairs, *part.on, pose_, *part.by, part.by->node_charges(own)));
    parallel_tasks(team, static_cast<Index>(part.near.size()), [&](Index c) {
      const PanelCluster& to = part.on->clusters()[c];
      for (std::size_t k = 0; k < part.near[c].size(); ++k) {
        const PanelCluster& from = part.by->clusters()[part.pairs->near[c][k]];
        sum.segment(to.begin, to.end - to.begin).noalias() +=
            part.near[c][k] * own.segment(from.begin, from.end - from.begin);
      }
    });
    part.on->scatter(sum, 1.0 / part.share, fluxes);
  }
}

}  // namespace loomstone
