// Aerodynamic drag on each triangle, in still air or in wind.
#pragma once

#include "core/base/field.h"
#include "core/base/own_rows.h"
#include "core/base/types.h"
#include "core/mesh/adjacency.h"
#include "core/parallel/team.h"

namespace loomstone {

struct Air {
  double density = 1.2;
  double normal_drag = 0.0;
  double tangential_drag = 0.0;
  Vec3 wind = Vec3::Zero();
  double gust = 0.0;

  bool drags() const { return density != 0.0 && (normal_drag != 0.0 || tangential_drag != 0.0); }

  static auto fields() {
    using A = Air;
    return std::make_tuple(
        field("density", &A::density, "kg/m^3", non_negative(), "density of the air"),
        field("normal_drag", &A::normal_drag, "1", non_negative(),
              "drag coefficient normal to a triangle"),
        field("tangential_drag", &A::tangential_drag, "1", non_negative(),
              "drag coefficient tangential to a triangle"),
        field("wind", &A::wind, "velocity of the wind [m/s]"),
        field("gust", &A::gust, "1", between(0.0, 1.0),
              "relative amplitude of slow variations of the wind"));
  }
};

// Returns the velocity of the air [m/s] at position `place` [m] and `time` [s]. It is the wind
// times (1 + gust * w), where w, between -1 and 1, is the sum of three travelling sine waves. If
// the wind is not vertical, turning the wind and the place about the z axis turns the returned
// velocity with them. The waves are not taken from the literature.
Vec3 wind_at(const Air& air, const Vec3& place, double time);

// The surface on which drag acts, at one instant.
struct DraggedSurface {
  double time;  // [s]
  const Triangles& triangles;
  const Incidence& triangles_of_vertex;
  const Points& x;  // (n x 3) positions [m]
  const Points& v;  // (n x 3) velocities [m/s]
};

// Adds drag [N] to rows [begin, end) of `force`. A vertex gets one third of the drag of each of its
// triangles. The drag of a triangle is
//   f = density / 2 * A * (normal_drag |u.n| (u.n) n + tangential_drag |u_t| u_t),
// where A is the current area, n the unit normal, u the velocity of the air relative to the mean
// velocity of the triangle, and u_t the part of u tangential to the triangle.
void add_drag(const Team& team, const Air& air, const DraggedSurface& surface, Index begin,
              Index end, RowsOut force);

// Returns an upper bound of the rates [1/s] at which drag alone lets the velocities of vertices
// relative to the air decay, for the vertices in rows [begin, end). The bound is the largest sum
// over the triangles of one of these vertices. A triangle contributes a third of its normal drag
// divided by |u.n|, plus a third of its tangential drag divided by |u_t| (symbols of add_drag()),
// both also divided by the mass of the vertex. `mass` contains the masses of all vertices [kg].
double drag_rate(const Team& team, const Air& air, const DraggedSurface& surface,
                 const Vector& mass, Index begin, Index end);

}  // namespace loomstone
