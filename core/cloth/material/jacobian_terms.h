// Selects the derivatives of elastic and viscous forces that an assembled matrix contains.
#pragma once

namespace loomstone {

// Factors of the stiffness matrix K and the damping matrix D in elastic K + viscous D.
struct StiffnessScales {
  double elastic = 1.0, viscous = 0.0;
};

// Exact: the geometric stiffness of the membrane uses the whole stress (see PastMotion), and the
// geometric stiffness of implicit bending is included. The stiffness matrix K may be indefinite.
// Positive: K is positive semi-definite, because the geometric stiffness of the membrane uses only
// the positive part of the stress, and that of bending is omitted.
enum class JacobianKind { Exact, Positive };

// The motion dx in the last step. The stress in the geometric stiffness of the membrane follows
// from the Green strain at positions `at` minus the strain 1/2 dF^T dF ((M41) in docs/method.md),
// where dF is the gradient of `step` times `motion`. If the subtracted strain exceeds a bound, it
// is scaled down to the bound (see past_strain() in membrane_kernels.cpp).
struct PastMotion {
  const double* motion = nullptr;  // (n x 3) dx [m], or a velocity [m/s]; null: subtracts nothing
  double step = 0.0;               // factor of `motion`: [1], or a time [s]
  const double* at = nullptr;      // (n x 3) positions [m]; null: those at which K is assembled
};

struct JacobianTerms {
  JacobianKind kind = JacobianKind::Exact;
  StiffnessScales scales;
  PastMotion past = {};
};

}  // namespace loomstone
