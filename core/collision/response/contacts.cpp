#include "core/collision/response/contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/collision/narrow_phase/distance.h"
#include "core/collision/response/found_contacts.h"
#include "core/parallel/merge_runs.h"

namespace loomstone {

namespace {

// Smallest distance in the force law, as a fraction of the thickness. It keeps forces finite if
// features touch.
constexpr double least_distance = 1e-6;
// The share of an edge contact is 1 if each closest point is farther from both ends of its edge
// than the fraction `end_fade` of the edge's length, and if the squared sine of the angle between
// the edges exceeds `parallel_fade`. Otherwise the share is smaller.
constexpr double end_fade = 0.1, parallel_fade = 0.04;
// Upper bound of contact_stiffness(), in units of the model's contact stiffness. With stiffer
// contacts, the matrix could lose positive definiteness in single precision.
constexpr double stiffest = 1e4;

double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

double edge_share(const Contact& contact, const Points& x0) {
  const auto edge = [&](int i) {
    return Vec3((x0.row(contact.vertices[i + 1]) - x0.row(contact.vertices[i])).transpose());
  };
  const Vec3 a = edge(0), b = edge(2);
  const double lengths2 = a.squaredNorm() * b.squaredNorm();
  if (!(lengths2 > 0.0)) return 0.0;
  double share = smooth_step(a.cross(b).squaredNorm() / lengths2 / parallel_fade);
  for (const double weight : contact.weights) share *= smooth_step(std::abs(weight) / end_fade);
  return share;
}

// Returns the unit normal at the closest point of a face, interpolated from the normals of the
// vertices of the face. It is oriented like `flat`, the contact normal without interpolation.
// Returns `flat` if the interpolation degenerates.
Vec3 rounded_normal(const SmoothNormals& normals, const std::array<Index, 4>& v,
                    const ClosestPair& closest, const Vec3& flat) {
  Vec3 sum = Vec3::Zero();
  for (int k = 1; k < 4; ++k) sum -= closest.weights[k] * normals.of(v[k]).transpose();
  const double length = sum.norm(), along = sum.dot(flat);
  return length > 0.5 && along != 0.0 ? Vec3(sum / std::copysign(length, along)) : flat;
}

// Returns whether `other` replaces `contact`. Both are contacts of one vertex with a face. `other`
// replaces `contact` if its face is nearer (or as near, with a smaller id) and contains the edge or
// corner on which the closest point of `contact` lies.
bool outdone(const CollisionModel& model, const Contact& contact, const Contact& other) {
  if (contact.distance < other.distance ||
      (contact.distance == other.distance && contact.b < other.b))
    return false;
  bool inside = true;
  for (int k = 1; k < 4; ++k) {
    if (contact.weights[k] == 0.0) {
      inside = false;
      continue;
    }
    const Index corner = contact.vertices[k];
    if (model.triangles(other.b, 0) != corner && model.triangles(other.b, 1) != corner &&
        model.triangles(other.b, 2) != corner)
      return false;
  }
  return !inside;
}

// Of the contacts of a vertex with a smooth surface, keeps only the nearest. Distance and
// interpolated normal are then continuous across faces. Of several equally near contacts, keeps the
// one whose triangle has the smallest id. `contacts` must be sorted.
void keep_nearest_on_smooth(const CollisionModel& model, std::vector<Contact>& contacts) {
  const auto surface = [&](const Contact& c) { return model.surface_of_triangle(c.b); };
  std::vector<Contact> kept;
  kept.reserve(contacts.size());
  std::size_t first_of_vertex = 0;
  for (const Contact& contact : contacts) {
    if (contact.kind != ContactKind::VertexFace || !model.surfaces[surface(contact)].smooth) {
      kept.push_back(contact);
      continue;
    }
    while (first_of_vertex < kept.size() && kept[first_of_vertex].a < contact.a) ++first_of_vertex;
    std::size_t i = first_of_vertex;
    while (i < kept.size() && surface(kept[i]) != surface(contact)) ++i;
    if (i == kept.size()) {
      kept.push_back(contact);
    } else if (contact.distance < kept[i].distance) {
      // `contact` comes after all kept contacts in sorted order, so it is appended.
      kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
      kept.push_back(contact);
    }
  }
  contacts = std::move(kept);
}

static_assert(sizeof(FoundContact) == bytes_of_found_contact);

// Finds contacts among pairs of features.
class ContactFinder {
 public:
  ContactFinder(const ContactSearch& search, const Points& x)
      : model_(search.model),
        pairs_(search.pairs),
        x_(x),
        normals_(search.normals.at(search.model, x)),
        selection_(search.selection) {}

  // Returns false only if the features are at least their thickness apart.
  bool near(Index i, ContactKind kind, PairKey key) const {
    const double reach = pairs_[i].thickness * (1.0 + 1e-12);
    const FourPoints p = points(pair_vertices(model_, kind, key));
    return distance_within(kind == ContactKind::VertexFace, p, reach) <= reach;
  }

  // Returns the distance [m] between two features of surface pair i. Appends their contact to `out`
  // if they are closer than contact_distance(). Two edges have a contact only if their closest
  // points lie inside both edges and neither surface is smooth.
  double look(Index i, ContactKind kind, PairKey key, std::vector<FoundContact>& out) const {
    const std::array<Index, 4> v = pair_vertices(model_, kind, key);
    const FourPoints p = points(v);
    const bool face = kind == ContactKind::VertexFace;
    const ClosestPair closest = face ? closest_vertex_face(p) : closest_edge_edge(p);
    // Edges of a smooth surface are artefacts of its triangulation. Certification tests them, but
    // they exert no contact force.
    const SurfacePair& pair = pairs_[i];
    const bool smooth = model_.surfaces[pair.a].smooth || model_.surfaces[pair.b].smooth;
    if (!(closest.distance < contact_distance(model_, pair, kind, v)) ||
        (!face && (!closest.interior || smooth)))
      return closest.distance;
    Vec3 normal = face ? contact_normal_vertex_face(p, closest, Vec3::Zero())
                       : contact_normal_edge_edge(p, closest, Vec3::Zero());
    if (face && model_.surfaces[model_.surface_of_triangle(second_of(key))].smooth)
      normal = rounded_normal(normals_, v, closest, normal);
    out.push_back({key, i, kind, closest.weights, normal, closest.distance});
    return closest.distance;
  }

  // Appends the contacts among the pairs of a list to `out`. Updates the distances and the cost of
  // the list.
  void look(NeighbourList& list, std::vector<FoundContact>& out) const {
    list.cost += ListCosts::list;
    const double thickness = pairs_[list.pair].thickness;
    if (list.nearest - list.used >= thickness) return;
    list.nearest = std::numeric_limits<double>::infinity();
    std::size_t n_looks = 0;
    const std::size_t n_before = out.size();
    for (std::size_t i = 0; i < list.near.size(); ++i) {
      NearPair& near = list.near[i];
      if (near.distance - list.used < thickness) {
        near.distance = look(list.pair, list.kind(i), near.key, out) + list.used;
        ++n_looks;
      }
      list.nearest = std::min(list.nearest, near.distance);
    }
    list.cost += ListCosts::pair * static_cast<float>(list.near.size()) +
                 ListCosts::distance * static_cast<float>(n_looks) +
                 ListCosts::contact * static_cast<float>(out.size() - n_before);
  }

  void look(const std::vector<FeaturePairs>& pairs, std::vector<FoundContact>& out) const {
    for (Index i = 0; i < static_cast<Index>(pairs.size()); ++i) {
      for (const PairKey key : pairs[i].vertex_face) look(i, ContactKind::VertexFace, key, out);
      for (const PairKey key : pairs[i].edge_edge) look(i, ContactKind::EdgeEdge, key, out);
    }
  }

  // Returns those contacts of all ranks that this rank keeps, and the totals of all contacts. The
  // contacts of each rank must be sorted.
  ContactSet finish(Gathered<FoundContact> found) const {
    if (!selection_) return whole(merged(std::move(found), place_of_pair));
    return {chosen(selection_->kept(model_, found)),
            selection_->totals(model_, pairs_, found.elements)};
  }

  // Like finish() above, but takes the contacts of all ranks in any order.
  ContactSet finish(std::vector<FoundContact> found) const {
    if (!selection_) return whole(in_order(found));
    const std::size_t n = found.size();
    const Gathered<FoundContact> all{std::move(found), {0, n}};
    return {chosen(in_order(selection_->kept(model_, all))),
            selection_->totals(model_, pairs_, all.elements)};
  }

  // Returns the contacts that chosen() returns, and their totals. `found` must be sorted.
  ContactSet whole(const std::vector<FoundContact>& found) const {
    ContactSet set{chosen(found), {}};
    set.all = totals_of(model_, set.contacts);
    return set;
  }

 private:
  // Returns the found contacts without those that keep_nearest_on_smooth() removes. `found` must be
  // sorted.
  std::vector<Contact> chosen(const std::vector<FoundContact>& found) const {
    std::vector<Contact> contacts;
    contacts.reserve(found.size());
    for (const FoundContact& each : found) contacts.push_back(each.contact(model_, pairs_));
    if (!normals_.empty()) keep_nearest_on_smooth(model_, contacts);
    return contacts;
  }

  FourPoints points(const std::array<Index, 4>& v) const {
    FourPoints p;
    for (int k = 0; k < 4; ++k) p[k] = x_.row(v[k]).transpose();
    return p;
  }

  const CollisionModel& model_;
  const std::vector<SurfacePair>& pairs_;
  const Points& x_;
  const SmoothNormals& normals_;
  ContactSelection* const selection_;  // null: this rank keeps all contacts
};

// Returns the contacts of the pairs in the lists of this rank, and those of the unlisted pairs that
// this rank finds. The contacts are sorted.
std::vector<FoundContact> find_in_lists(const Team& team, const ContactFinder& finder,
                                        NeighbourLists& lists) {
  lists.make_ended(team);
  std::vector<std::vector<FoundContact>> of_range(lists.n_ranges());
  lists.each_list(team,
                  [&](NeighbourList& list, Index range) { finder.look(list, of_range[range]); });
  std::vector<FoundContact> found;
  for (const std::vector<FoundContact>& range : of_range)
    found.insert(found.end(), range.begin(), range.end());
  finder.look(lists.unlisted_near_pairs(team), found);
  return in_order(found);
}

}  // namespace

ContactForce contact_force(double distance, double thickness, double stiffness) {
  if (distance >= thickness) return {0.0, 0.0, 0.0};
  const double onset = 0.25 * thickness, half = 0.5 * thickness;
  const double depth = thickness - distance;
  if (depth < onset) {
    const double slope = stiffness * depth / onset;
    return {0.5 * slope * depth, slope, slope * depth * depth / 6.0};
  }
  const double offset = 0.5 * onset, energy_at_onset = stiffness * onset * onset / 6.0;
  if (distance > half)
    return {stiffness * (depth - offset), stiffness,
            energy_at_onset + 0.5 * stiffness * depth * (depth - onset)};
  const double energy_at_half = energy_at_onset + 0.5 * stiffness * half * (half - onset);
  const double d = std::max(distance, least_distance * thickness), square = half * half;
  return {stiffness * (square / d - offset), stiffness * square / (d * d),
          energy_at_half + stiffness * (square * std::log(half / d) - offset * (half - d))};
}

ContactSet find_contacts(const Team& team, const ContactSearch& search, const Points& x,
                         NeighbourLists& lists) {
  const ContactFinder finder(search, x);
  const auto find = [&](NeighbourLists::Pass& pass) {
    std::vector<FoundContact> found;
    pass = lists.pass_at_x(team);
    if (!pass.unexpected) found = find_in_lists(team, finder, lists);
    return found;
  };
  for (;;) {
    auto all =
        gather_again<FoundContact, NeighbourLists::Pass>(lists.ranks(), lists.contact_room(), find);
    if (lists.end_update(team, all.notes)) return finder.finish(std::move(all.gathered));
  }
}

ContactSet find_contacts(const Team& team, const ContactSearch& search, const Points& x,
                         SharedSearch& shared) {
  const ContactFinder finder(search, x);
  std::vector<double> inflation(search.model.surfaces.size(), 0.0);
  for (const SurfacePair& pair : search.pairs)
    for (const Index s : {pair.a, pair.b})
      inflation[s] = std::max(inflation[s], 0.5 * pair.thickness * (1.0 + 1e-12));
  const std::size_t n_threads = std::max(1, team.threads);
  std::vector<std::vector<FoundContact>> of_thread(n_threads);
  for (std::vector<FoundContact>& records : of_thread)
    records.reserve(shared.most_records<FoundContact>());
  shared.each_pair(team, {x, x, inflation},
                   [&](int thread, Index pair, ContactKind kind, PairKey key) {
                     if (finder.near(pair, kind, key))
                       finder.look(pair, kind, key, of_thread[thread]);
                   });
  return finder.finish(shared.gather(of_thread));
}

ContactSet find_contacts_alone(const Team& team, const ContactSearch& search, const Points& x,
                               BroadPhase& broad_phase) {
  std::vector<Index> which;
  std::vector<double> reach;
  for (const SurfacePair& pair : search.pairs) {
    which.push_back(static_cast<Index>(which.size()));
    reach.push_back(pair.thickness * (1.0 + 1e-9));
  }
  std::vector<FeaturePairs> near;
  broad_phase.near_pairs(team, x, which, reach, near);
  const ContactFinder finder({search.model, search.pairs, search.normals}, x);
  std::vector<FoundContact> found;
  finder.look(near, found);
  return finder.finish(std::move(found));
}

std::vector<double> contact_shares(const std::vector<Contact>& contacts,
                                   const CollisionModel& model, const Points& x0) {
  const std::size_t n = contacts.size();
  std::vector<double> shares(n, 1.0);
  std::vector<std::uint8_t> out;
  for (std::size_t begin = 0; begin < n;) {
    if (contacts[begin].kind == ContactKind::EdgeEdge) {
      shares[begin] = edge_share(contacts[begin], x0);
      ++begin;
      continue;
    }
    std::size_t end = begin + 1;
    while (end < n && contacts[end].kind == ContactKind::VertexFace &&
           contacts[end].a == contacts[begin].a)
      ++end;
    out.assign(end - begin, 0);
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = begin; j < end && !out[i - begin]; ++j)
        out[i - begin] = i != j && outdone(model, contacts[i], contacts[j]);
    for (std::size_t i = begin; i < end; ++i) {
      const Contact& own = contacts[i];
      const double own_force = contact_force(own.distance, own.thickness, 1.0).force;
      double count = 1.0;
      if (out[i - begin]) {
        shares[i] = 0.0;
        continue;
      }
      for (std::size_t j = begin; j < end; ++j) {
        const Contact& other = contacts[j];
        if (out[j - begin]) continue;
        if (i == j || model.surface_of_triangle(own.b) != model.surface_of_triangle(other.b))
          continue;
        const double alike = std::max(0.0, own.normal.dot(other.normal));
        const double other_force = contact_force(other.distance, other.thickness, 1.0).force;
        count += alike * alike * std::min(1.0, other_force / own_force);
      }
      shares[i] = 1.0 / count;
    }
    begin = end;
  }
  return shares;
}

std::vector<double> contact_stiffness(const std::vector<Contact>& contacts,
                                      const CollisionModel& model, const Vector& inverse_mass,
                                      const Points& forces) {
  std::vector<double> stiffness(contacts.size(), model.contact_stiffness);
  if (forces.rows() == 0) return stiffness;
  double thickness = -1.0, of_half = 0.0;  // thickness xi of the preceding contact, and 3/8 xi [m]
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    double pressing = 0.0;  // larger of the forces that press a free feature onto the other [N]
    for (const int side : {0, 1}) {
      double force = 0.0;
      bool free = true;
      for (int i = 0; i < 4; ++i) {
        if ((contact.weights[i] < 0.0) != (side == 1) || contact.weights[i] == 0.0) continue;
        const Index v = contact.vertices[i];
        free = free && v < forces.rows() && inverse_mass[v] > 0.0;
        if (free) force -= contact.weights[i] * contact.normal.dot(forces.row(v).transpose());
      }
      if (free) pressing = std::max(pressing, force);
    }
    if (contact.thickness != thickness) {
      thickness = contact.thickness;
      of_half = contact_force(0.5 * thickness, thickness, 1.0).force;
    }
    stiffness[c] = std::clamp(2.0 * pressing / of_half - model.contact_stiffness,
                              model.contact_stiffness, stiffest * model.contact_stiffness);
  }
  return stiffness;
}

}  // namespace loomstone
