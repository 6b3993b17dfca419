// Base class of the asynchronous integrators, which differ in the schedule of their events.
#pragma once

#include <memory>
#include <vector>

#include "core/integration/asynchronous/attached_bodies.h"
#include "core/integration/asynchronous/element_steps.h"
#include "core/integration/asynchronous/level_bending.h"
#include "core/integration/asynchronous/limit_impulses.h"
#include "core/integration/integrator_factories.h"

namespace loomstone {

// Each call of advance() integrates one interval of the length StepInputs::step. The vertices are
// synchronised at the start and at the end of the interval. Every rank computes all rows.
class AsynchronousIntegrator : public Integrator {
 public:
  AsynchronousIntegrator(const Asynchronous& options, const ClothModel& model,
                         Elasticity& elasticity);

  bool implicit() const override { return false; }
  bool moves_bodies() const override { return true; }
  IntegrationReport advance(const Team& team, const RowLayout& layout, const StepInputs& inputs,
                            ClothState& state, Points& body_velocity) override;

 protected:
  // Result of take_interval().
  struct Taken {
    Vector steps;                     // (m) steps that the triangles have taken [s]
    std::int64_t events;              // number of events of all triangles
    std::vector<LimitPhases> phases;  // (m) highest phases entered; empty: no limit potential
  };
  // Moves cloth and bodies from the start to the end of the interval. `steps` (m) [s] are the
  // longest steps that the triangles may take. On entry, prescribed vertices must have their
  // prescribed velocities.
  virtual Taken take_interval(const Team& team, double interval, const Vector& steps,
                              ClothState& state) = 0;

  // Longest steps between events of bending (m) [s]: the steps of the membrane at rest or, if
  // options_.bending_multiple is not 0, this multiple of their mean_of_patches() (level_bending.h).
  // In either case, bending_ limits the result.
  Vector bending_event_steps() const;

  const ClothModel& model_;
  std::vector<LimitModes> limits_;  // (m) modes of the limit potential; empty: none
  const Asynchronous options_;
  ElementSteps steps_;
  std::unique_ptr<LimitImpulses> impulses_;  // null: strain limits do not act by impulses
  std::vector<BendingMesh> meshes_;
  Vector bending_;       // (m) longest steps of bending [s]
  Points load_;          // (n x 3) forces that do not change within the interval [N]
  Vector inverse_mass_;  // (n) zero for prescribed vertices [1/kg]
  AttachedBodies bodies_;
  EventCollisions* collisions_ = nullptr;  // collisions of the step; null: none

 private:
  bool shorten(const Taken& taken, Vector& steps) const;

  Elasticity& elasticity_;
  Points wide_;
};

std::unique_ptr<Integrator> make_nested(const Asynchronous& options, const ClothModel& model,
                                        Elasticity& elasticity);
std::unique_ptr<Integrator> make_queue(const Asynchronous& options, const ClothModel& model,
                                       Elasticity& elasticity);

}  // namespace loomstone
