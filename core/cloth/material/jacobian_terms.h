// Selects the derivatives of elastic and viscous forces that an assembled matrix contains.
#pragma once

namespace loomstone {

// Factors of the stiffness matrix K and the damping matrix D in elastic K + viscous D.
struct StiffnessScales {
  double elastic = 1.0, viscous = 0.0;
};

// Positive: K is positive semi-definite, because the geometric stiffness of the membrane uses the
// positive part of the stress and that of bending is omitted.
enum class JacobianKind { Exact, Positive };

// The motion in the last step. The stress in the geometric stiffness excludes the stress of the
// strain 1/2 dF^T dF, where dF is the gradient of this motion. If this strain exceeds a bound, it
// is scaled down to the bound (see past_strain() in membrane_kernels.cpp).
struct PastMotion {
  const double* velocity = nullptr;  // (n x 3) [m/s]; null: nothing is excluded
  double step = 0.0;                 // [s]
};

struct JacobianTerms {
  JacobianKind kind = JacobianKind::Exact;
  StiffnessScales scales;
  PastMotion past = {};
};

}  // namespace loomstone
