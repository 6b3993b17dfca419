"""Checks options of runs before the scene is read, and applies those that change the integrator."""

from __future__ import annotations

from .._core import InvalidInput
from ..integrators import Integrator, check_method, parse_step, with_method
from ..runs.frame_times import frame_count
from ..runs.replay import REPLAYED
from ..runs.scene_file import SceneFile
from .application import command_line

__all__ = ["check_decomposition", "check_given", "integrator_of"]


def check_given(
    *,
    duration: float | None,
    rate: float | None = None,
    step: str | None = None,
    integrator: str | None = None,
) -> None:
    """Raises WrongCommand for values that no scene allows; None stands for the scene's value."""
    with command_line():
        # If the duration or the rate is not given, the substitute makes their product almost 0, so
        # that only the given value is checked.
        frame_count(0.0 if duration is None else duration, 1e-300 if rate is None else rate)
        if integrator is not None:
            check_method(integrator, "--integrator")
        if step is not None:
            parse_step(step)


def check_decomposition(name: str) -> None:
    """Raises WrongCommand unless there is a decomposition of this name."""
    with command_line():
        if name not in REPLAYED:
            raise InvalidInput(f'decomposition must be one of {" | ".join(REPLAYED)}, got "{name}"')


def integrator_of(file: SceneFile, method: str | None, step: str | None) -> Integrator:
    """Returns the integrator of a scene file, changed by the options --integrator and --step."""
    options = file.integrator
    if method is not None:
        options = with_method(options, method, "--integrator")
    if step is None:
        return options
    with command_line():
        return options.replace(step=parse_step(step))
