"""Scene files: Python files that define `scene(**parameters)` and how to run the scene.

    duration = 1.0                                 # [s]
    rate = 25.0                                    # frames per second
    integrator = ls.SemiImplicitEuler(step=2e-3)
    render = ls.RenderOptions()                    # options of the pictures
    def scene(triangles: int = 14450) -> ls.Scene: ...
    def control(sim: ls.Simulation) -> None: ...   # called before every step; must depend on time
                                                   # and state alone
    def check(run: ls.Run) -> None: ...            # asserts claims about the frames

Only scene() is required. By default, the duration is 1 s, the rate 25 frames/s and the integrator
SemiImplicitEuler(). Each of `duration`, `rate`, `integrator` and `render` may also be a function of
the parameters.

A scene file is a module: it can import modules in its directory. Relative paths in its code are
relative to its directory. check() finds the directory of the run in run.directory.
"""

from __future__ import annotations

import difflib
import inspect
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .. import _core
from .._core import CacheError, Error, InvalidInput, RenderOptions, Scene
from ..exchange.baked import SUFFIXES
from ..integrators import Integrator, SemiImplicitEuler, from_record, to_record
from ..pictures.directory import options_from_dict
from .parameters import Parameter, literals, parameters_of
from .scene_module import absolute_files, execute_module, in_directory_of
from .stored_program import Stored, stored_program

__all__ = ["SceneFile", "stored_options"]


class SceneFile:
    """A scene file, together with values for its parameters.

    known : default of each parameter of scene(); inspect.Parameter.empty if it has none
    parameters : values of the parameters that were given
    """

    def __init__(self, path: Path, source: str, parameters: dict[str, Any]) -> None:
        self.path, self.source = path, source
        with self._located():
            self._module = execute_module(path, source)
        function = getattr(self._module, "scene", None)
        if not callable(function):
            raise InvalidInput(
                f"{path} must define a function scene(), but does not; `loomstone new` writes an"
                " example"
            )
        self._function: Callable[..., Scene] = function
        accepted = inspect.signature(function).parameters.values()
        self._any_name = any(p.kind is p.VAR_KEYWORD for p in accepted)
        names = getattr(inspect.unwrap(function), "__globals__", vars(self._module))
        self._parameters = parameters_of(function, names)
        self.known = {name: each.default for name, each in self._parameters.items()}
        self.parameters = {name: self._value(name, value) for name, value in parameters.items()}
        missing = [
            name for name, default in self.known.items() if default is inspect.Parameter.empty
        ]
        if missing := [name for name in missing if name not in parameters]:
            raise InvalidInput(
                f"{path.name}: scene() needs a value for {missing[0]}; give -p {missing[0]}=..."
            )

    @classmethod
    def open(cls, path: Path, parameters: dict[str, Any]) -> SceneFile:
        """Reads a scene file in its current state.

        parameters : for each name a value, or its text as a Given (parameters.py)

        Raises CacheError if the file cannot be read, and InvalidInput if it is not a valid scene
        file.
        """
        if path.suffix.lower() in _MESHES:
            raise InvalidInput(
                f"{path} is a mesh, not a scene file; read it in a scene file by"
                f" ls.meshes.read({path.name!r}), see `loomstone new`"
            )
        try:
            source = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise CacheError(f"{path}: scene file cannot be read: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise CacheError(
                f"{path}: scene file cannot be read: it is not a text file; give a Python file"
            ) from error
        file = cls(path.resolve(), source, parameters)
        file.parameters = absolute_files(file.parameters)
        return file

    @property
    def texts(self) -> set[str]:
        """Names of the parameters whose values are always strings."""
        return {name for name, each in self._parameters.items() if each.takes_text}

    @classmethod
    def of_run(cls, run: Stored, *, trust: bool = False) -> SceneFile:
        """Restores the scene file as it was when a run began, from the metadata of the run.

        trust : run the stored program even if it differs from the scene file on disk; see
            stored_program.py
        """
        program = stored_program(run)
        if not trust:
            program.require_same_file(run.directory)
        return cls(program.path, program.source, program.parameters)

    def scene(self) -> Scene:
        """Returns the scene that the file makes for these parameters."""
        with self._located():
            made = self._function(**self.parameters)
        if not isinstance(made, Scene):
            raise InvalidInput(
                f"{self.path}: scene() must return a Scene, got a {type(made).__name__}"
            )
        return made

    def _constant(self, name: str, default: Any) -> Any:
        value = getattr(self._module, name, default)
        if callable(value):
            wanted = inspect.signature(value).parameters
            with self._located():
                value = value(
                    **{k: v for k, v in {**self.known, **self.parameters}.items() if k in wanted}
                )
        return value

    def _number(self, name: str, default: float) -> float:
        value = self._constant(name, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InvalidInput(f"{self.path}: {name} must be a number, got {value!r}")
        return float(value)

    @contextmanager
    def _located(self) -> Iterator[None]:
        """Runs the code of a `with` block, which calls the scene file, in the file's directory.

        An error, or sys.exit(), becomes an InvalidInput that names the file, and the line if it is
        known. AssertionError and errors of loomstone other than InvalidInput stay unchanged.
        """
        try:
            with in_directory_of(self.path):
                yield
        except AssertionError:
            raise
        except InvalidInput as error:
            if str(error).startswith(str(self.path)):
                raise
            raise InvalidInput(f"{self._line_of(error)}: {error}") from error
        except Error:
            raise
        except SyntaxError as error:
            # `raise SyntaxError` in a scene file names no file.
            where = f"{error.filename}, line {error.lineno}"
            told = error.msg or "SyntaxError"
            raise InvalidInput(
                f"{where if error.filename else self._line_of(error)}: {told}"
            ) from error
        except SystemExit as error:
            raise InvalidInput(
                f"{self._line_of(error)}: a scene file must not end the program, but calls"
                f" sys.exit({'' if error.code is None else repr(error.code)}); raise an error"
                " instead"
            ) from error
        except Exception as error:
            told = " ".join(str(error).split())
            raise InvalidInput(f"{self._line_of(error)}: {_kind(error)}: {told}") from error

    def _line_of(self, error: BaseException) -> str:
        """Returns, as text, the path of the scene file and, if the traceback contains this file,
        the line of the innermost frame in it.
        """
        lines = [
            f.lineno
            for f in traceback.extract_tb(error.__traceback__)
            if f.filename == str(self.path)
        ]
        return f"{self.path}, line {lines[-1]}" if lines else str(self.path)

    @property
    def duration(self) -> float:
        """Simulated time [s]."""
        return self._number("duration", 1.0)

    @property
    def rate(self) -> float:
        """Frames per second of simulated time [1/s]."""
        return self._number("rate", 25.0)

    @property
    def integrator(self) -> Integrator:
        """Integrator of the scene, which the command line may override."""
        value = self._constant("integrator", SemiImplicitEuler())
        if not isinstance(value, Integrator):
            raise InvalidInput(
                f"{self.path}: integrator must be an Integrator, got a {type(value).__name__}"
            )
        return value

    @property
    def render(self) -> RenderOptions:
        """Options of the pictures."""
        value = self._constant("render", RenderOptions())
        if not isinstance(value, RenderOptions):
            raise InvalidInput(
                f"{self.path}: render must be RenderOptions, got a {type(value).__name__}"
            )
        return value

    @property
    def control(self) -> Callable[[Any], None] | None:
        """Function that is called before every step, or None."""
        return self._guarded("control")

    @property
    def check(self) -> Callable[[Any], None] | None:
        """Function that asserts claims about the frames, or None."""
        return self._guarded("check")

    def _guarded(self, name: str) -> Callable[[Any], None] | None:
        function = getattr(self._module, name, None)
        if function is None:
            return None
        if not callable(function):
            raise InvalidInput(
                f"{self.path}: {name} must be a function, got a {type(function).__name__}"
            )

        def call(argument: Any) -> None:
            with self._located():
                function(argument)

        return call

    def metadata(
        self, duration: float, rate: float, integrator: Integrator, render: RenderOptions
    ) -> dict[str, Any]:
        """Returns what the run stores about itself, so that it can be resumed from a checkpoint."""
        return {
            "loomstone": _core.__version__,
            "scene_file": {
                "path": str(self.path),
                "source": self.source,
                "parameters": self.parameters,
                "literals": literals(self.parameters),
            },
            "duration": duration,
            "rate": rate,
            "integrator": to_record(integrator),
            "render": render.to_dict(),
        }

    def _value(self, name: str, value: Any) -> Any:
        if name not in self.known and not self._any_name:
            close = difflib.get_close_matches(name, self.known, 1)
            hint = (
                f"did you mean {close[0]}?"
                if close
                else f"known: {', '.join(self.known) or 'none'}"
            )
            raise InvalidInput(f"{self.path.name}: scene() has no parameter {name!r}; {hint}")
        known = self._parameters.get(name) or Parameter(name, None, Any)
        try:
            return known.read(value)
        except InvalidInput as error:
            raise InvalidInput(f"{self.path.name}: {error}") from None


def _kind(error: Exception) -> str:
    """Returns the name of an error's type; types derived from TypeError count as "TypeError"."""
    return "TypeError" if isinstance(error, TypeError) else type(error).__name__


_MESHES = (".obj", ".ply", ".stl", ".abc", ".fbx", *SUFFIXES)


def stored_options(run: Stored) -> tuple[float, float, Integrator, RenderOptions]:
    """Returns the duration [s], rate [1/s], integrator and render options of a run.

    Raises CacheError if one of them is missing or has the wrong type.
    """
    kept = run.metadata
    try:
        return (
            float(kept["duration"]),
            float(kept["rate"]),
            from_record(kept["integrator"]),
            options_from_dict(kept["render"]),
        )
    except (KeyError, TypeError) as error:
        made = kept.get("loomstone", "an unknown version")
        raise CacheError(
            f"{run.directory}: options of the run cannot be read ({error}); it was written by"
            f" loomstone {made}"
        ) from error
