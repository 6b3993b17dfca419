#include "core/rigid/contacts/contact_reduction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace loomstone {

namespace {

using Indices = std::vector<std::size_t>;

constexpr std::size_t most_kept = 4;  // largest number of contacts in a Bullet manifold

// Chooses the contacts to keep. Contacts that existed in the previous step are preferred: they
// count as slightly deeper and as slightly farther from the other contacts.
class Reduction {
 public:
  Reduction(const std::vector<HullContact>& contacts, double near, double margin,
            const std::vector<HullContact>& before)
      : contacts_(contacts), margin_(margin), all_(contacts.size()) {
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    double deepest = near;
    for (const HullContact& contact : contacts) {
      old_.push_back(std::any_of(before.begin(), before.end(), [&](const HullContact& c) {
        return (c.point - contact.on_hull()).norm() < 0.1 * near;
      }));
      deepest = std::min(deepest, contact.gap);
    }
    for (const std::size_t k : all_)
      if (contacts[k].gap < deepest + (old_[k] ? 2.0 : 1.0) * margin_) bearing_.push_back(k);
  }

  // Chooses four contacts that form the corners of the region of contact, if no other contact lies
  // deeper than the two triangles that these four span. This is so if a face of the hull meets a
  // flat obstacle, even if the face is tilted and bears load only at one edge. Without the contacts
  // at the opposite edge, a box would turn about the edge that bears load and sink in. If another
  // contact lies deeper, the hull is rounded or the obstacle is rough. In this case, or if the four
  // contacts lie on a line, only contacts that bear load are candidates for the four corners. If
  // fewer than four contacts bear load, all of these are chosen, together with the contacts that
  // are farthest from them.
  Indices kept() const {
    Indices chosen = corners(all_);
    if (lies_on(chosen)) return chosen;
    if (bearing_.size() >= most_kept) return corners(bearing_);
    return with_farthest(bearing_);
  }

 private:
  const Vec3& at(std::size_t k) const { return contacts_[k].point; }

  // Returns the contact with the largest value. Values within a fraction `ties` of each other count
  // as equal, and the first of them is chosen. Values of contacts that existed in the previous step
  // are first multiplied by 1.05.
  template <class Value>
  std::size_t largest(const Indices& among, double ties, const Value& value) const {
    std::size_t chosen = among.front();
    double most = -std::numeric_limits<double>::infinity();
    for (const std::size_t k : among) {
      const double here = value(at(k)) * (old_[k] ? 1.05 : 1.0);
      if (!(here <= most + ties * std::abs(most))) chosen = k, most = here;
    }
    return chosen;
  }

  // Returns four contacts. The first is the contact that bears load and is farthest from the mean
  // position of the contacts `among`. The others belong to `among`: the contact farthest from the
  // first, and the farthest contact on each side of the line through these two. A contact can occur
  // twice, for example if there is none on one side of the line.
  Indices corners(const Indices& among) const {
    constexpr double ties = 1e-6;
    Vec3 mean = Vec3::Zero();
    for (const std::size_t k : among) mean += at(k) / static_cast<double>(among.size());
    const std::size_t first =
        largest(bearing_, ties, [&](const Vec3& x) { return (x - mean).squaredNorm(); });
    const auto from_first = [&](const Vec3& x) -> Vec3 { return x - at(first); };
    const std::size_t second =
        largest(among, ties, [&](const Vec3& x) { return from_first(x).squaredNorm(); });
    const Vec3 line = from_first(at(second));
    const std::size_t third = largest(
        among, ties, [&](const Vec3& x) { return from_first(x).cross(line).squaredNorm(); });
    const Vec3 side = from_first(at(third)).cross(line);
    const std::size_t fourth =
        largest(among, ties, [&](const Vec3& x) { return -side.dot(from_first(x).cross(line)); });
    return {first, second, third, fourth};
  }

  // Returns whether no contact is deeper, by more than margin_, than the two triangles between the
  // corners. False if all corners lie on a line.
  bool lies_on(const Indices& corners) const {
    const Vec3 &first = at(corners[0]), line = at(corners[1]) - first;
    bool has_area = false;
    for (const std::size_t apex : {corners[2], corners[3]}) {
      const Vec3 up = line.cross(at(apex) - first);
      const double area = up.squaredNorm();
      if (!(area > 1e-12 * line.squaredNorm() * line.squaredNorm())) continue;
      has_area = true;
      for (const std::size_t k : all_) {
        const Vec3 x = at(k) - first;
        const double of_apex = line.cross(x).dot(up) / area;
        if (of_apex < 0.0) continue;
        const double of_second = x.cross(at(apex) - first).dot(up) / area,
                     between = (1.0 - of_apex - of_second) * contacts_[corners[0]].gap +
                               of_second * contacts_[corners[1]].gap +
                               of_apex * contacts_[apex].gap;
        if (contacts_[k].gap < between - margin_) return false;
      }
    }
    return has_area;
  }

  // Adds, one by one, the contact that is farthest from those already chosen, until there are four.
  Indices with_farthest(Indices chosen) const {
    Indices others;
    for (const std::size_t k : all_)
      if (std::ranges::find(chosen, k) == chosen.end()) others.push_back(k);
    // If several contacts are about equally far away, largest() chooses the first one. Sorting
    // makes this the one with the smallest gap.
    std::ranges::stable_sort(others, {}, [&](std::size_t k) { return contacts_[k].gap; });
    while (chosen.size() < most_kept) {
      const std::size_t farthest = largest(others, 0.1, [&](const Vec3& x) {
        double least = std::numeric_limits<double>::infinity();
        for (const std::size_t k : chosen) least = std::min(least, (x - at(k)).squaredNorm());
        return least;
      });
      chosen.push_back(farthest);
      std::erase(others, farthest);
    }
    return chosen;
  }

  const std::vector<HullContact>& contacts_;
  const double margin_;  // gaps that differ by less count as equal [m]
  std::vector<bool> old_;
  Indices all_;
  // Contacts that bear load: their gap exceeds the smallest gap by less than the margin, or by less
  // than twice the margin if they existed in the previous step.
  Indices bearing_;
};

// Leaves out contacts that are closer than `distance` [m] to another contact whose gap is smaller
// by more than `distance`, or to an earlier contact whose gap differs by at most `distance`. Edges
// of the hull that share a corner give the same contact there, and so do triangles that share a
// corner or side. Both ends of an edge of a thin hull can have the same contact point on the
// surface, but only the nearer end touches it.
void leave_out_repeated(std::vector<HullContact>& contacts, double distance) {
  // Sorting the contacts along an axis brings those at almost equal points close together. The axis
  // is skew, so that few points of a grid have the same coordinate. Its length is at most 1, so the
  // coordinates of two points differ by no more than the distance between the points.
  const Vec3 axis(0.53, 0.41, 0.73);
  std::vector<std::pair<double, std::size_t>> along;
  for (std::size_t k = 0; k < contacts.size(); ++k)
    along.emplace_back(axis.dot(contacts[k].point), k);
  std::ranges::sort(along);
  const auto keeps = [&](std::size_t a, std::size_t b) {
    const double farther = contacts[a].gap - contacts[b].gap;
    return std::abs(farther) > distance ? farther < 0.0 : a < b;
  };
  std::vector<bool> repeated(contacts.size(), false);
  for (std::size_t i = 0; i < along.size(); ++i)
    for (std::size_t j = i + 1; j < along.size() && along[j].first < along[i].first + distance;
         ++j) {
      const std::size_t a = along[i].second, b = along[j].second;
      if ((contacts[a].point - contacts[b].point).norm() < distance)
        repeated[keeps(a, b) ? b : a] = true;
    }
  std::size_t n = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k)
    if (!repeated[k]) contacts[n++] = contacts[k];
  contacts.resize(n);
}

}  // namespace

void reduce_contacts(std::vector<HullContact>& contacts, double near, double margin,
                     const std::vector<HullContact>& before) {
  leave_out_repeated(contacts, 1e-6 * near);
  if (contacts.size() <= most_kept) return;
  Indices kept = Reduction(contacts, near, margin, before).kept();
  std::ranges::sort(kept);
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  std::vector<HullContact> reduced;
  for (const std::size_t k : kept) reduced.push_back(contacts[k]);
  contacts = std::move(reduced);
}

}  // namespace loomstone
