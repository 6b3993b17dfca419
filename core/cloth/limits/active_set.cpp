#include "core/cloth/limits/active_set.h"

namespace loomstone {

ActiveSet::ActiveSet(const LimitElements& elements, const limit::Tables& tables, Contents contents,
                     Order order)
    : elements_(elements),
      tables_(tables),
      all_(contents == Contents::AllElements),
      singly_(order == Order::SingleElements),
      waits_(elements.n_batches(), all_ ? every_lane : 0),
      moved_(elements.n_batches(), 0),
      of_colour_(elements.colour_start().size() - 1) {
  if (all_ && !singly_)
    for (Index b = 0; b < elements.n_batches(); ++b) of_colour_[elements.colour(b)].push_back(b);
}

void ActiveSet::add(Index batch) {
  if (!singly_ && !waits_[batch]) of_colour_[elements_.colour(batch)].push_back(batch);
  waits_[batch] = every_lane;
}

void ActiveSet::take(std::size_t colour, std::vector<Index>& list) {
  std::vector<Index>& batches = of_colour_[colour];
  list.insert(list.end(), batches.begin(), batches.end());
  for (const Index b : batches) evaluations_ += elements_.n_elements(b);
  if (all_) return;
  for (const Index b : batches) waits_[b] = 0;
  batches.clear();
}

bool ActiveSet::take_one(Index slot) {
  const unsigned waiting = waits_[slot / 8], lane = 1u << slot % 8;
  if (!(waiting & lane)) return false;
  if (!all_) waits_[slot / 8] = static_cast<std::uint8_t>(waiting & ~lane);
  ++evaluations_;
  return true;
}

void ActiveSet::spread(Index corrected) {
  if (all_) return;
  for (int k = 0; k < 3; ++k) {
    if (!(tables_.moves[corrected] >> k & 1)) continue;
    const Index v = elements_.corners(corrected)[8 * k];
    for (Index s = elements_.slot_start()[v]; s < elements_.slot_start()[v + 1]; ++s) {
      const Index slot = elements_.slots()[s], b = slot / 8;
      if (!moved_[b]) moved_[b] = 1, moved_list_.push_back(b);
      if (singly_)
        waits_[b] = static_cast<std::uint8_t>(waits_[b] | 1u << slot % 8);
      else
        add(b);
    }
  }
}

}  // namespace loomstone
