"""Reading of a run from its directory."""

from __future__ import annotations

import copy
import json
import operator
import os
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._core import CacheError, Frame, FrameReader, FrameTopology, Scene
from ..exchange.export import Format, export_run
from ..pictures.notebook import picture_of_frame, remember
from .extension import extension
from .leftovers import PARTS, leftovers
from .magnet_record import magnets_from_record
from .scene_file import SceneFile
from .stacked import Stacked
from .steps import read_steps, refuse_sweep
from .stored_scene import read_scene

__all__ = ["Run"]


class Run:
    """The sequence of frames of a run that is finished, interrupted or still in progress.

    path : directory of the run, or its run.vtkhdf

    Raises CacheError if there is no run, or if its file cannot be read.

    `positions` and similar properties stack the arrays of all frames along a first axis, and read
    only the requested frames. Pickling a Run stores only its path. A Run can be used in a `with`
    statement, which closes its files.

    >>> with ls.Run("out/drape") as run:               # doctest: +SKIP
    ...     print(run[-1].positions.shape, run.positions[::10].shape)
    ...     print(run.steps["contacts.near"].max())
    (7396, 3) (3, 7396, 3)
    5321
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        if Path(path).is_dir() and not (Path(path) / "run.vtkhdf").exists():
            refuse_sweep(path)
            if PARTS[0] in leftovers(Path(path)):
                quoted = shlex.quote(str(path))
                raise CacheError(
                    f"{path}: nothing was saved yet, because the run ended while it wrote its"
                    f" first file; start it again: loomstone run SCENE --out {quoted}"
                )
            raise CacheError(
                f"{path}: holds no run (there is no run.vtkhdf in it); give the directory of a run"
            )
        # This path is absolute, so that a copy made by pickle can be read from any directory.
        self._path = os.path.abspath(path)
        self._file: FrameReader | None = FrameReader(self._path)
        # Copies, made on first use. The arrays of the FrameReader itself would keep its files open
        # after close().
        self._topology: FrameTopology | None = None
        self._times: NDArray[np.float64] | None = None
        self._directory = Path(path) if Path(path).is_dir() else Path(path).parent
        self._working_directory = os.getcwd()

    @property
    def _reader(self) -> FrameReader:
        if self._file is None:
            raise CacheError(f"{self._path}: the run is closed; open it again by loomstone.Run")
        return self._file

    def close(self) -> None:
        """Closes the files. Frames that have been read stay valid."""
        self._file = self._topology = self._times = None

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        return Run, (self._path,)

    def __len__(self) -> int:
        return self._reader.n_frames

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        n = len(self)
        if isinstance(index, slice):
            return [remember(self._reader.frame(i), self.topology) for i in range(n)[index]]
        if not -n <= (index := operator.index(index)) < n:
            raise IndexError(f"frame {index} of {n}")
        return remember(self._reader.frame(index % n), self.topology)

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(len(self)))

    @property
    def times(self) -> NDArray[np.float64]:
        """(frames) times of the frames [s]."""
        if self._times is None:
            self._times = self._reader.times.copy()
            self._times.flags.writeable = False
        return self._times

    @property
    def positions(self) -> Stacked:
        """(frames x n x 3) positions of the cloth vertices [m]."""
        return Stacked(self, "positions")

    @property
    def velocities(self) -> Stacked:
        """(frames x n x 3) velocities of the cloth vertices [m/s]."""
        return Stacked(self, "velocities")

    @property
    def strain(self) -> Stacked:
        """(frames x m x 3) Green strain of the cloth triangles: weft, warp, shear (E12) [1]."""
        return Stacked(self, "strain")

    @property
    def stretch(self) -> Stacked:
        """(frames x m) largest principal stretch of the cloth triangles [1]."""
        return Stacked(self, "stretch")

    @property
    def body_vertices(self) -> Stacked:
        """(frames x nb x 3) positions of the vertices of rigid bodies and obstacles [m]."""
        return Stacked(self, "body_vertices")

    @property
    def directory(self) -> Path:
        """Directory of the run. It is absolute after a change of the working directory."""
        if os.getcwd() == self._working_directory:
            return self._directory
        return Path(self._working_directory, self._directory)

    @property
    def steps(self) -> dict[str, NDArray[Any]]:
        """Columns of steps.csv by name, with one entry per step, in SI units."""
        return read_steps(self.directory)

    @property
    def topology(self) -> FrameTopology:
        """The data that all frames of the run have in common."""
        if self._topology is None:
            self._topology = copy.copy(self._reader.topology)
        return self._topology

    @property
    def metadata(self) -> dict[str, Any]:
        """Metadata of the run: options, magnets and coils, and a digest of scene and integrator.

        A run of `loomstone run` also has its scene file and the parameters. Files of other programs
        have no metadata. `duration` is the longest that was given so far. `control` tells whether a
        control function was ever given. If one was given at the start, the digest (`identity`) is a
        random number. Raises CacheError if extension.json cannot be read.
        """
        try:
            content = json.loads(self._reader.metadata or "{}")
        except json.JSONDecodeError:
            return {}
        if not content or not isinstance(content, dict):
            return {}
        return content | extension(self.directory)

    @property
    def metadata_text(self) -> str:
        """The stored text of the metadata (JSON); empty if there is none."""
        return self._reader.metadata or ""

    @property
    def rate(self) -> float:
        """Frames per second of simulated time [1/s].

        It is 25 if it is neither stored nor evident from the times of the frames.
        """
        if isinstance(rate := self.metadata.get("rate"), (int, float)):
            return float(rate)
        length = self.times[-1] - self.times[0] if len(self) > 1 else 0.0
        return float(f"{(len(self) - 1) / length:.6g}") if length > 0.0 else 25.0

    def scene(self, *, trust: bool = False) -> Scene:
        """Returns the scene as it was when the run began.

        trust : run the program stored in the run even if it differs from the scene file on disk.
            The program of a run from a stranger can do anything that you can do.

        Raises CacheError if the run has stored neither a scene file nor a scene, or if its program
        must not be run without `trust`.
        """
        if "scene_file" in self.metadata:
            return SceneFile.of_run(self, trust=trust).scene()
        return read_scene(self.directory)

    def magnetic_scene(self) -> Scene | None:
        """Returns a Scene of the bodies, obstacles, magnets, coils, bearings and uniform field.

        The result is None if there are neither magnets nor coils. The scene is read from stored
        numbers, so no program of the run is executed. Obstacles are at rest. Raises CacheError if
        the numbers are damaged.
        """
        record = self.metadata.get("magnetic_scene")
        if record is None:
            return None
        try:
            return magnets_from_record(record)
        except CacheError as error:
            raise CacheError(f"{self.directory}: {error}") from error

    def export(
        self,
        out: str | os.PathLike[str] | None = None,
        *,
        to: Format | None = None,
        frames: range | None = None,
        every: int = 1,
        overwrite: bool = False,
    ) -> list[Path]:
        """Writes frames for other programs; returns the paths of the files.

        to : usd (.usdc, .usd or .usda: points and poses over time, uv, materials), gltf (.glb or
            .gltf: morph targets and animated nodes, uv, materials), alembic (.abc: points and poses
            over time, uv, colours), pc2 or mdd (an OBJ file for each surface, and a point cache for
            each that moves), obj or ply (a mesh file for each surface or, if it moves, one for each
            frame). None: usd, gltf or alembic, according to the suffix of `out`.
        out : file, or directory for pc2, mdd, obj and ply; default: in the directory of the run
        frames : frames to export, such as range(10, 50); None: all
        every : export only every n-th of these frames
        overwrite : replace an earlier export

        Lengths are in metres. z is up, except in gltf and alembic, which have y up. Vertices are
        doubles in obj and ply, and floats in the others. In usd, gltf and alembic, bodies and
        obstacles that move rigidly have poses instead of moving points.

        Raises InvalidInput if the format is unknown, a file or directory is in the way or the run
        lacks some of `frames`, Unsupported if a package is missing, and CacheError if files cannot
        be read or written.

        >>> ls.Run("out/drape").export("drape.usdc", frames=range(0, 50))      # doctest: +SKIP
        """
        return export_run(self, out, to=to, frames=frames, every=every, overwrite=overwrite)

    def intersecting_pairs(self, index: int = -1) -> list[tuple[int, int]]:
        """Returns the pairs of triangles that intersect in a frame and share no vertex.

        Triangles are numbered in the order of surface(): cloth first, then bodies and obstacles.
        """
        points, triangles = self.surface(index)
        return [(int(a), int(b)) for a, b in _core.intersecting_pairs(points, triangles)]

    def surface(self, index: int = -1) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Returns the points (n x 3) [m] and triangles (m x 3) of all surfaces in a frame.

        Cloth comes first, then bodies and obstacles.
        """
        frame = self[index]
        triangles = np.concatenate(
            [self.topology.triangles, self.topology.body_triangles + len(frame.positions)]
        )
        return np.concatenate([frame.positions, frame.body_vertices]), triangles

    def _repr_png_(self) -> bytes | None:
        return picture_of_frame(self[-1]) if self._file is not None and len(self) else None

    def __repr__(self) -> str:
        if self._file is None:
            return f"Run({str(self.directory)!r}: closed)"
        end = f", to {self.times[-1]:g} s" if len(self) else ""
        return f"Run({str(self.directory)!r}: {len(self)} frames{end})"
