"""The commands loomstone plot and loomstone field."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .._core import CacheError
from ..pictures import plots
from ..pictures.parallel import plot_parallel
from ..runs.cache import Run
from ..runs.parallel import read_parallel
from ..runs.steps import read_steps
from .application import WrongCommand, app, command_line, refuse_options, session
from .options import one_of

KINDS = (*plots.KINDS, "parallel")
CURVES = ("force", "torque")  # curves for the magnets that --mesh gives
# Defaults.
ALONG_Z = "0,0,1"
PLANE = "xz"
WHAT = "energy"


@app.command()
def plot(
    runs: Annotated[
        list[Path],
        typer.Argument(
            help="directory of a run (several with --what parallel), or `force` or `torque` for"
            " magnets given by --mesh",
            metavar="RUN...",
        ),
    ],
    what: Annotated[str, typer.Option(help=" | ".join(KINDS), autocompletion=one_of(KINDS))] = WHAT,
    out: Annotated[
        Path | None,
        typer.Option(help="picture to write; default: WHAT.png in the first run, or force.png"),
    ] = None,
    mesh: Annotated[
        list[Path],
        typer.Option(
            help="closed mesh of a magnet [m]; if given twice: force on the first by the second"
        ),
    ] = [],  # noqa: B006
    polarization: Annotated[
        str, typer.Option(help="polarization J = mu0 M of the magnets [T]")
    ] = ALONG_Z,
    axis: Annotated[
        str, typer.Option(help="direction from the second magnet to the first")
    ] = ALONG_Z,
    reach: Annotated[
        float, typer.Option(help="largest distance [m]; 0: the second magnet's radius")
    ] = 0.0,
) -> None:
    """Plots a run over time, a comparison of parallel runs, or forces between magnets.

    For a run, plots energy, stages, contacts, stretch, strain, iterations or step from its
    steps.csv. The plot of strain shows the largest strain in each direction, its excess over
    limits, and the sweeps of strain limiting. `--what parallel` compares runs of a scene on
    different numbers of ranks, and shows the predictions of `loomstone replay`. It averages runs
    that have the same number of ranks and the same decomposition. `force` plots the force on the
    first magnet against the gap between it and the second. `torque` plots the torque on the first
    magnet against the angle by which this magnet is turned.

    \b
        loomstone plot out/drape --what stages
        loomstone plot out/one out/two out/two-again --what parallel
        loomstone plot force --mesh magnet.obj --polarization 0,0,1.2 --out force.png
    """
    with session(parallel=False):
        if curve := _curve(runs):
            from ..magnetics.mesh_pictures import curve_of_meshes, numbers

            _refuse_for_magnets(what, curve, reach)
            with command_line():
                vector, along = numbers(polarization, "--polarization"), numbers(axis, "--axis")
            path = curve_of_meshes(curve, mesh, vector, along, reach, out or Path(f"{curve}.png"))
        else:
            _refuse_for_runs(mesh, polarization, axis, reach)
            run = _only_run(runs, what)
            path = _plot_runs(runs, what, out or run / f"{what}.png")
        print(f"plot: {path}")


@app.command()
def field(
    mesh: Annotated[Path, typer.Argument(help="closed mesh [m], OBJ or PLY")],
    polarization: Annotated[
        str, typer.Option(help="polarization J = mu0 M of the magnet [T]")
    ] = "0,0,1",
    lines: Annotated[
        int, typer.Option(help="number of field lines, each of equal flux", min=1)
    ] = 150,
    out: Annotated[
        Path, typer.Option(help="picture (PNG) of the magnet with its field lines")
    ] = Path("field.png"),
    eye: Annotated[str, typer.Option(help="direction from the magnet to the eye")] = "0.6,-1,0.35",
    slice_: Annotated[
        Path | None,
        typer.Option("--slice", help="picture (PNG) of |B| and its direction in a plane"),
    ] = None,
    plane: Annotated[
        str, typer.Option(help="plane of the slice, through the centre: xy | xz | yz")
    ] = PLANE,
) -> None:
    """Draws the field of a uniformly polarized magnet of any shape.

    \b
        loomstone field horseshoe.obj --polarization 0,0,1 --lines 200 --slice slice.png
    """
    with session(parallel=False):
        if slice_ is None:
            refuse_options({"--plane": plane != PLANE}, "has no effect without --slice")
        from ..magnetics import figures
        from ..magnetics import mesh_pictures as pictures
        from ..meshes import read

        with command_line():
            vector = pictures.numbers(polarization, "--polarization")
            towards = pictures.numbers(eye, "--eye")
        surface = read(mesh, with_uv=False)
        path, found = pictures.draw_field(surface, vector, out, n_lines=lines, eye=towards)
        print(f"{len(found.lines)} field lines of {sum(map(len, found.lines))} points: {path}")
        if slice_:
            magnet = pictures.magnet_of(mesh, vector)
            print(f"slice: {figures.plot_slice(magnet, slice_, plane=plane)}")  # type: ignore[arg-type]


def _curve(runs: list[Path]) -> str | None:
    """Returns the name in CURVES that is given in place of a run, or None if there are only runs.

    Raises WrongCommand if such a name is given together with a run or with another name.
    """
    named = [str(run) for run in runs if str(run) in CURVES and not run.is_dir()]
    others = [str(run) for run in runs if str(run) not in named]
    if named and (others or len(named) > 1):
        other = (others or named[1:])[0]
        raise WrongCommand(
            f"`plot {named[0]}` plots magnets given by --mesh, and nothing else, got also {other};"
            f" leave out {other}"
        )
    return named[0] if named else None


def _refuse_for_magnets(what: str, curve: str, reach: float) -> None:
    """Raises WrongCommand for options that have no effect on this curve of magnets."""
    refuse_options({"--what": what != WHAT}, f"is an option for runs, not for `plot {curve}`")
    if curve == "torque":
        refuse_options({"--reach": reach != 0.0}, "is an option for `plot force`")


def _refuse_for_runs(mesh: list[Path], polarization: str, axis: str, reach: float) -> None:
    """Raises WrongCommand for options that affect only curves of magnets."""
    turned = {"--polarization": polarization != ALONG_Z, "--axis": axis != ALONG_Z}
    refuse_options(
        {"--mesh": bool(mesh), **turned, "--reach": reach != 0.0},
        "is an option for the magnets of `plot force` and `plot torque`, not for runs",
    )


def _only_run(runs: list[Path], what: str) -> Path:
    """Returns the first run.

    Raises WrongCommand if `what` is not in KINDS, or if there are several runs and `what` is not
    "parallel".
    """
    if what not in KINDS:
        raise WrongCommand(f"--what must be one of {', '.join(KINDS)}, got {what!r}")
    if len(runs) > 1 and what != "parallel":
        raise WrongCommand(f"only --what parallel plots several runs, got {len(runs)} for {what}")
    return runs[0]


def _plot_runs(runs: list[Path], what: str, target: Path) -> Path:
    if what == "parallel":
        shared = [read_parallel(run) for run in runs]
        return plot_parallel(shared, target, title=_title(runs[0]))
    return plots.plot_steps(read_steps(runs[0]), target, kind=what, title=_title(runs[0]))


def _title(directory: Path) -> str:
    """Returns a title: the directory of a run, with its scene and parameters if they are known."""
    name = str(directory)
    try:
        made = Run(directory).metadata.get("scene_file")
    except CacheError:  # the table of steps may lie outside a run directory
        return name
    if not made:
        return name
    given = ", ".join(f"{key}={value}" for key, value in made["parameters"].items())
    return f"{name}: {Path(made['path']).name}{f' ({given})' if given else ''}"
