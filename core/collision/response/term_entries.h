// The rows of an implicit solve that a weighted sum of collision vertices depends on.
#pragma once

#include <span>

#include "core/collision/model/collision_model.h"
#include "core/collision/response/response_inputs.h"
#include "core/linalg/extra_terms.h"

namespace loomstone {

// Entries of the relative velocity sum w_i v_i of up to 5 vertices; vertices moved by script go
// into the drift. All corners of one body are one translation and one rotation row.
void set_entries(const CollisionModel& model, std::span<const Index> vertices,
                 std::span<const double> weights, const ContactInputs& inputs, ExtraTerm& term);

}  // namespace loomstone
