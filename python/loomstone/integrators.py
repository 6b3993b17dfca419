"""Integrators by name; each returns IntegratorOptions.

Fields and defaults are those of the C++ description.
"""

from __future__ import annotations

from ._core import IntegratorOptions

__all__ = [
    "BDF2",
    "BackwardEuler",
    "ExplicitEuler",
    "ImplicitMidpoint",
    "SemiImplicitEuler",
    "SymplecticEuler",
]

_D = IntegratorOptions()


def ExplicitEuler(*, step: float) -> IntegratorOptions:
    """Explicit Euler, order 1: gains energy, needs tiny steps [s]; for comparison."""
    return IntegratorOptions(method="explicit-euler", step=step)


def SymplecticEuler(*, step: float) -> IntegratorOptions:
    """Symplectic Euler, order 1: velocities first; keeps energy in the mean, stable for small steps
    [s] only.
    """
    return IntegratorOptions(method="symplectic-euler", step=step)


def SemiImplicitEuler(
    *,
    step: float = _D.step,
    jacobian: str = _D.jacobian,
    bending: str = _D.bending,
    linear_solver: str = _D.linear_solver,
    tolerance: float = _D.tolerance,
    max_iterations: int = _D.max_iterations,
) -> IntegratorOptions:
    """Backward Euler with one linear solve a step (Baraff and Witkin 1998), order 1: robust, damps.

    The default.

    step : [s]; jacobian : "spd" | "exact"; bending : "auto" | "explicit" | "implicit";
    linear_solver : "pcg" | "block-jacobi" | "gauss-seidel" | "direct"; tolerance : of the
        preconditioned residual [1]
    """
    return IntegratorOptions(
        method="semi-implicit-euler",
        step=step,
        jacobian=jacobian,
        bending=bending,
        linear_solver=linear_solver,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )


def BackwardEuler(
    *,
    step: float = _D.step,
    jacobian: str = _D.jacobian,
    bending: str = _D.bending,
    linear_solver: str = _D.linear_solver,
    tolerance: float = _D.tolerance,
    max_iterations: int = _D.max_iterations,
    newton_tolerance: float = _D.newton_tolerance,
    max_newton_iterations: int = _D.max_newton_iterations,
) -> IntegratorOptions:
    """Backward Euler solved by Newton with line search, order 1: as the semi-implicit one,
    converged.
    """
    return IntegratorOptions(
        method="backward-euler",
        step=step,
        jacobian=jacobian,
        bending=bending,
        linear_solver=linear_solver,
        tolerance=tolerance,
        max_iterations=max_iterations,
        newton_tolerance=newton_tolerance,
        max_newton_iterations=max_newton_iterations,
    )


def ImplicitMidpoint(
    *,
    step: float = _D.step,
    nonlinear: bool = False,
    jacobian: str = _D.jacobian,
    bending: str = _D.bending,
    linear_solver: str = _D.linear_solver,
    tolerance: float = _D.tolerance,
    max_iterations: int = _D.max_iterations,
    newton_tolerance: float = _D.newton_tolerance,
    max_newton_iterations: int = _D.max_newton_iterations,
) -> IntegratorOptions:
    """Implicit midpoint rule, order 2, hardly damps; linearised, or converged by Newton with
    nonlinear=True.
    """
    return IntegratorOptions(
        method="nonlinear-midpoint" if nonlinear else "implicit-midpoint",
        step=step,
        jacobian=jacobian,
        bending=bending,
        linear_solver=linear_solver,
        tolerance=tolerance,
        max_iterations=max_iterations,
        newton_tolerance=newton_tolerance,
        max_newton_iterations=max_newton_iterations,
    )


def BDF2(
    *,
    step: float = _D.step,
    jacobian: str = _D.jacobian,
    bending: str = _D.bending,
    linear_solver: str = _D.linear_solver,
    tolerance: float = _D.tolerance,
    max_iterations: int = _D.max_iterations,
) -> IntegratorOptions:
    """Second-order backward differences, linearised (Choi and Ko 2002), order 2: damps less than
    Euler.
    """
    return IntegratorOptions(
        method="bdf2",
        step=step,
        jacobian=jacobian,
        bending=bending,
        linear_solver=linear_solver,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
