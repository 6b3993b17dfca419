// Continuous collision detection in floating point that proves its results. Two features a and b
// touch when the polygon of their differences a - b contains the origin. The polygon is a triangle
// for a vertex and a face, and a parallelogram for two edges. Its corners c_k move linearly in
// time. The volume spanned by three corners is a cubic in time. The normals c_k x c_(k+1), one for
// each side of the polygon, are quadratics. The interval [0, 1] is bisected into pieces until one
// piece is proved "meet" or all are proved "apart":
//   apart: the volume keeps its sign, or two normals have opposite signs in one coordinate
//          throughout;
//   meet:  the volume changes sign, and one coordinate of all normals has the same sign
//          throughout.
// Bernstein coefficients bound a polynomial over a piece. The tests of signs allow for rounding
// errors. The result is Open if rounding errors, very large or small numbers, or the limits of the
// bisection prevent a proof.
#pragma once

#include "core/collision/narrow_phase/continuous.h"

namespace loomstone {

enum class Proof { Apart, Meet, Open };  // Open: undecided

struct Decision {
  Proof proof;
  double time;  // the features are certainly apart in [0, time)
};

Decision decide_vertex_face(const MovingPoints& points);
Decision decide_edge_edge(const MovingPoints& points);

}  // namespace loomstone
