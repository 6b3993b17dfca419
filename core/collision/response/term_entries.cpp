#include "core/collision/response/term_entries.h"

#include <algorithm>
#include <array>
#include <limits>

namespace loomstone {

void set_entries(const CollisionModel& model, std::span<const Index> vertices,
                 std::span<const double> weights, const ContactInputs& inputs, ExtraTerm& term) {
  struct BodySide {
    Index row = -1;
    double weight = 0.0;
    Vec3 moment = Vec3::Zero();  // sum of w_i (x_i - centre) [m]
  };
  std::array<BodySide, 3> bodies;
  int n_bodies = 0;
  term.n_entries = 0;
  term.drift = Vec3::Zero();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Index vertex = vertices[i], row = model.rows.row[vertex];
    const double weight = weights[i];
    if (weight == 0.0) continue;
    if (row < 0) {
      term.drift -= weight * inputs.v0.row(vertex).transpose();
    } else if (!model.rows.is_body[vertex]) {
      term.entries[term.n_entries++] = {row, false, weight, Vec3::Zero()};
    } else {
      int b = 0;
      while (b < n_bodies && bodies[b].row != row) ++b;
      if (b == n_bodies) bodies[n_bodies++].row = row;
      bodies[b].weight += weight;
      bodies[b].moment +=
          weight *
          (inputs.x0.row(vertex) - inputs.body_centres.row((row - inputs.n_cloth) / 2)).transpose();
    }
  }
  for (int b = 0; b < n_bodies; ++b) {
    if (bodies[b].weight == 0.0) continue;
    term.entries[term.n_entries++] = {bodies[b].row, false, bodies[b].weight, Vec3::Zero()};
    term.entries[term.n_entries++] = {bodies[b].row + 1, true, bodies[b].weight,
                                      bodies[b].moment / bodies[b].weight};
  }
  std::sort(term.entries.begin(), term.entries.begin() + term.n_entries,
            [](const TermEntry& x, const TermEntry& y) { return x.row < y.row; });
}

ActingOn acting_on(const CollisionModel& model, const Contact& contact, IndexRange rows) {
  ActingOn acting;
  Index first = std::numeric_limits<Index>::max();
  for (int i = 0; i < 4; ++i) {
    const Index vertex = contact.vertices[i], row = model.rows.row[vertex];
    if (row < 0 || contact.weights[i] == 0.0) continue;
    acting.any = true;
    first = std::min(first, row);
    acting.given = acting.given || rows.contains(row) ||
                   (model.rows.is_body[vertex] && rows.contains(row + 1));
  }
  acting.counts = rows.contains(acting.any ? first : 0);
  return acting;
}

}  // namespace loomstone
