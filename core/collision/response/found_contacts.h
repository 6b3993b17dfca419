// Contacts as ranks send them to each other, and the selection of those that a rank keeps.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/model/feature_pairs.h"
#include "core/parallel/shared_work.h"

namespace loomstone {

// Data of a contact that a rank sends to other ranks. The features determine all other data of the
// contact.
struct FoundContact {
  PairKey key;
  Index pair;  // index of the surface pair
  ContactKind kind;
  std::array<double, 4> weights;
  Vec3 normal;
  double distance;

  Contact contact(const CollisionModel& model, const std::vector<SurfacePair>& pairs) const;
};

inline std::uint64_t pair_order(const FoundContact& contact) {
  return pair_order(contact.kind, contact.key);
}

// Returns the contacts sorted by (kind, a, b).
std::vector<FoundContact> in_order(const std::vector<FoundContact>& contacts);

// Totals over the contacts of all ranks.
struct ContactTotals {
  std::int64_t n = 0;    // number of contacts
  bool pressed = false;  // true: some contact is closer than half its thickness
  // True if a vertex of cloth or of a body is in contact with a face. Some contact then has a
  // positive share and acts on a row.
  bool vertex_on_face = false;
  // Pairs of surfaces in contact. The smaller index comes first, and the pairs are sorted.
  std::vector<std::array<Index, 2>> surfaces;
};

// Returns the totals of `contacts`. They are the totals of all ranks only if `contacts` contains
// the contacts of all ranks.
ContactTotals totals_of(const CollisionModel& model, const std::vector<Contact>& contacts);
// Returns the totals of a set of contacts from the totals of its parts, which do not overlap.
ContactTotals joined(const std::vector<ContactTotals>& parts);

// Selects the contacts that a rank keeps. These are the contacts with a vertex that moves with one
// of the rows of this rank (`rows`). If such a contact is between a vertex and a face, the rank
// keeps all contacts of this vertex with faces, because these contacts divide their force among
// themselves. The rank of row 0 also keeps contacts without a vertex that moves with a row
// (see VertexRows).
class ContactSelection {
 public:
  ContactSelection(const CollisionModel& model, IndexRange rows);

  // Returns the kept contacts. They are sorted if the contacts of each rank in `found` are sorted.
  std::vector<FoundContact> kept(const CollisionModel& model, const Gathered<FoundContact>& found);
  // Returns the totals of `found`, the contacts of all ranks. ContactTotals::n counts all contacts
  // of a vertex with one smooth surface (CollisionSurface::smooth) as one.
  ContactTotals totals(const CollisionModel& model, const std::vector<SurfacePair>& pairs,
                       const std::vector<FoundContact>& found) const;
  IndexRange rows() const { return rows_; }
  std::size_t bytes() const { return bytes_of(moves_, group_); }

 private:
  enum Moves : std::uint8_t { WithOwnRow = 1, WithAnyRow = 2 };

  const IndexRange rows_;
  std::vector<std::uint8_t> moves_;  // (vertices) bits of Moves
  // (vertices) 1: all contacts of the vertex with faces are kept. Scratch memory of kept().
  std::vector<std::uint8_t> group_;
};

}  // namespace loomstone
