// Expresses a weighted sum of velocities of collision vertices in terms of the unknowns of the
// implicit solve, and tells whether a contact acts on given rows of the solve.
#pragma once

#include <span>

#include "core/collision/model/collision_model.h"
#include "core/collision/model/contact.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"

namespace loomstone {

// Sets the entries of `term` for the relative velocity sum_i w_i v_i of up to 5 vertices.
// Velocities of obstacle vertices enter `term.drift`. All vertices of a body use its translation
// row and its rotation row.
void set_entries(const CollisionModel& model, std::span<const Index> vertices,
                 std::span<const double> weights, const ContactInputs& inputs, ExtraTerm& term);

// Whether a contact acts on any row, and whether it acts on one of the given rows.
struct ActingOn {
  bool any = false, given = false;
  // True if the lowest row on which the contact acts is one of the given rows, or if the contact
  // acts on no row and the given rows include row 0. If each row belongs to one rank, each contact
  // thus counts on one rank.
  bool counts = false;
};
ActingOn acting_on(const CollisionModel& model, const Contact& contact, IndexRange rows);

}  // namespace loomstone
