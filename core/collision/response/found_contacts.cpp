#include "core/collision/response/found_contacts.h"

#include <algorithm>
#include <numeric>

#include "core/base/sort_unique.h"
#include "core/parallel/merge_runs.h"

namespace loomstone {

namespace {

std::array<Index, 2> ascending(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

Contact FoundContact::contact(const CollisionModel& model,
                              const std::vector<SurfacePair>& pairs) const {
  const SurfacePair& surfaces = pairs[pair];
  const std::array<Index, 4> vertices = pair_vertices(model, kind, key);
  return {kind,
          first_of(key),
          second_of(key),
          vertices,
          weights,
          normal,
          distance,
          contact_distance(model, surfaces, kind, vertices),
          surfaces.friction};
}

std::vector<FoundContact> in_order(const std::vector<FoundContact>& contacts) {
  std::vector<Placed<FoundContact>> order;
  order.reserve(contacts.size());
  for (const FoundContact& contact : contacts) order.push_back({pair_order(contact), &contact});
  std::sort(order.begin(), order.end(), by_place);
  return copies(order);
}

ContactTotals totals_of(const CollisionModel& model, const std::vector<Contact>& contacts) {
  ContactTotals totals;
  totals.n = static_cast<std::int64_t>(contacts.size());
  std::array<Index, 2> last = {-1, -1};
  for (const Contact& contact : contacts) {
    totals.pressed |= contact.distance < 0.5 * contact.thickness;
    totals.vertex_on_face |=
        contact.kind == ContactKind::VertexFace && model.rows.row[contact.a] >= 0;
    const std::array<Index, 2> surfaces = ascending(model.surface_of_vertex(contact.vertices[0]),
                                                    model.surface_of_vertex(contact.vertices[3]));
    if (surfaces != last) totals.surfaces.push_back(last = surfaces);
  }
  sort_unique(totals.surfaces);
  return totals;
}

ContactTotals joined(const std::vector<ContactTotals>& parts) {
  ContactTotals sum;
  for (const ContactTotals& part : parts) {
    sum.n += part.n;
    sum.pressed |= part.pressed;
    sum.vertex_on_face |= part.vertex_on_face;
    sum.surfaces.insert(sum.surfaces.end(), part.surfaces.begin(), part.surfaces.end());
  }
  sort_unique(sum.surfaces);
  return sum;
}

ContactSelection::ContactSelection(const CollisionModel& model, IndexRange rows)
    : rows_(rows), moves_(model.n_vertices, 0), group_(model.n_vertices, 0) {
  for (Index v = 0; v < model.n_vertices; ++v) {
    const Index row = model.rows.row[v];
    if (row < 0) continue;
    const bool own = rows.contains(row) || (model.rows.is_body[v] && rows.contains(row + 1));
    moves_[v] = WithAnyRow | (own ? WithOwnRow : 0);
  }
}

std::vector<FoundContact> ContactSelection::kept(const CollisionModel& model,
                                                 const Gathered<FoundContact>& found) {
  const bool first_row = rows_.contains(0);
  const auto acts = [&](const FoundContact& contact) {
    const std::array<Index, 4> v = pair_vertices(model, contact.kind, contact.key);
    const std::uint8_t moves = moves_[v[0]] | moves_[v[1]] | moves_[v[2]] | moves_[v[3]];
    return (moves & WithOwnRow) != 0 || (first_row && moves == 0);
  };
  std::vector<Index> grouped;
  for (const FoundContact& contact : found.elements) {
    if (contact.kind != ContactKind::VertexFace) continue;
    const Index vertex = first_of(contact.key);
    if (group_[vertex] || !acts(contact)) continue;
    group_[vertex] = 1;
    grouped.push_back(vertex);
  }
  std::vector<Placed<FoundContact>> order;
  order.reserve(found.elements.size());
  std::vector<std::size_t> starts = {0};
  for (std::size_t run = 0; run + 1 < found.start.size(); ++run) {
    for (std::size_t i = found.start[run]; i < found.start[run + 1]; ++i) {
      const FoundContact& contact = found.elements[i];
      const bool face = contact.kind == ContactKind::VertexFace;
      if (face ? group_[first_of(contact.key)] != 0 : acts(contact))
        order.push_back({pair_order(contact), &contact});
    }
    starts.push_back(order.size());
  }
  for (const Index vertex : grouped) group_[vertex] = 0;
  merge_runs(order, std::move(starts), by_place);
  return copies(order);
}

ContactTotals ContactSelection::totals(const CollisionModel& model,
                                       const std::vector<SurfacePair>& pairs,
                                       const std::vector<FoundContact>& found) const {
  ContactTotals totals;
  std::vector<std::uint8_t> in_contact(pairs.size(), 0);
  std::vector<std::array<Index, 2>> on_smooth;  // (vertex, smooth surface); duplicates count once
  for (const FoundContact& contact : found) {
    in_contact[contact.pair] = 1;
    const double thickness = contact_distance(model, pairs[contact.pair], contact.kind,
                                              pair_vertices(model, contact.kind, contact.key));
    totals.pressed |= contact.distance < 0.5 * thickness;
    if (contact.kind != ContactKind::VertexFace) continue;
    totals.vertex_on_face |= moves_[first_of(contact.key)] != 0;
    const Index surface = model.surface_of_triangle(second_of(contact.key));
    if (model.surfaces[surface].smooth) on_smooth.push_back({first_of(contact.key), surface});
  }
  totals.n = static_cast<std::int64_t>(found.size() - on_smooth.size());
  sort_unique(on_smooth);
  totals.n += static_cast<std::int64_t>(on_smooth.size());
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (in_contact[i]) totals.surfaces.push_back(ascending(pairs[i].a, pairs[i].b));
  sort_unique(totals.surfaces);
  return totals;
}

}  // namespace loomstone
