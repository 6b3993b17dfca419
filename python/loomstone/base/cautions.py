"""Category of the warnings about scenes and runs that can be simulated, but look like mistakes."""

from __future__ import annotations

__all__ = ["SceneWarning"]


class SceneWarning(UserWarning):
    """Warning about a scene or run that can be simulated, but is probably not what is intended.

    To turn these warnings off: warnings.simplefilter("ignore", loomstone.SceneWarning). To turn
    them into errors: warnings.simplefilter("error", loomstone.SceneWarning).
    """
