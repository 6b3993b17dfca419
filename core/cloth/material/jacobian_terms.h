// Which derivatives of the elastic and viscous forces an assembled matrix contains.
#pragma once

namespace loomstone {

// Factors of the stiffness K and the damping D: elastic K + viscous D.
struct StiffnessScales {
  double elastic = 1.0, viscous = 0.0;
};

// Positive: the geometric term takes the positive part of the stress, so K is positive
// semi-definite.
enum class JacobianKind { Exact, Positive };

struct JacobianTerms {
  JacobianKind kind = JacobianKind::Exact;
  StiffnessScales scales;
};

}  // namespace loomstone
