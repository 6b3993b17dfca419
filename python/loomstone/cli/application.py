"""The command `loomstone`."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from .. import _core
from . import inspection
from ..pictures import plots
from ..runs import progress
from ..pictures import drawing as video
from .._core import Communicator, Error, IntegratorOptions, InvalidInput, RenderOptions
from ..runs.cache import Run
from ..ranks import share_failure
from ..runs.execution import Interrupted, RunOptions, execute
from ..runs.scene_file import SceneFile, parse_parameters, stored_options
from ..simulation import Simulation, frame_count

__all__ = ["app", "main"]

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"max_content_width": 100},
    rich_markup_mode=None,  # plain text: units in brackets are no markup
    help="""Simulates cloth and renders it.

    A scene file is Python with a function scene() that returns a loomstone.Scene; see the
    directory scenes. First steps:

    \b
        loomstone run scenes/hanging.py --out out/hanging --render
        loomstone info out/hanging
    """,
)

report = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Measures by simulation what is known otherwise.",
)
app.add_typer(report, name="report")

SceneArgument = Annotated[Path, typer.Argument(help="Python file with a function scene()")]
RunArgument = Annotated[Path, typer.Argument(help="directory of a run")]
Parameters = Annotated[
    list[str],
    typer.Option(
        "-p", "--parameter", help="parameter of scene() as name=value; may be given again"
    ),
]
Threads = Annotated[int, typer.Option(help="threads, 0: all processors", min=0)]
Render = Annotated[bool, typer.Option("--render", help="draw every frame and make a video")]

METHODS = {
    "semi-implicit-euler",
    "explicit-euler",
    "symplectic-euler",
    "backward-euler",
    "implicit-midpoint",
    "nonlinear-midpoint",
    "bdf2",
}


@app.command()
def run(
    scene: SceneArgument,
    out: Annotated[
        Path | None,
        typer.Option(help="directory for the results; default: out/NAME of the scene file"),
    ] = None,
    p: Parameters = [],  # noqa: B006
    duration: Annotated[
        float | None, typer.Option(help="simulated time [s]; default: as the scene file says")
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(help="frames a second of simulated time; default: as the scene file says"),
    ] = None,
    step: Annotated[
        float | None, typer.Option(help="time step [s]; default: as the scene file says")
    ] = None,
    integrator: Annotated[str | None, typer.Option(help=" | ".join(sorted(METHODS)))] = None,
    threads: Threads = 0,
    render: Render = False,
    verify: Annotated[
        bool, typer.Option("--verify", help="count intersecting triangles of every frame exactly")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="replace a run that is there")
    ] = False,
) -> None:
    """Simulates a scene.

    Writes run.vtkhdf and bodies.vtkhdf (ParaView opens them), checkpoints, steps.csv, report.json,
    with --render frames/*.png and video.mp4, with --verify frames.csv (exit code 1 where triangles
    of cloth intersect). Ctrl-C, SIGTERM and SIGUSR1 leave a run that `loomstone resume` continues
    bit for bit; so does a crash. On several ranks: mpirun -n 2 loomstone run scene.py.

    \b
        loomstone run scenes/drape.py -p triangles=3600 --duration 0.5 --threads 2 --render
    """
    with _session() as (communicator, rank):
        file = SceneFile.open(scene, parse_parameters(p))
        options = (
            file.integrator if integrator is None else _other_method(file.integrator, integrator)
        )
        if step is not None:
            options = options.replace(step=step)
        settings = (
            file.duration if duration is None else duration,
            file.rate if rate is None else rate,
        )
        frame_count(*settings)
        directory = out or Path("out") / scene.stem
        _advance(
            file,
            *settings,
            options,
            file.render if render else None,
            directory,
            threads,
            communicator,
            rank,
            verify=verify,
            overwrite=overwrite,
        )


@app.command()
def resume(run: RunArgument, threads: Threads = 0, render: Render = False) -> None:
    """Continues a run that was interrupted or killed, bit for bit.

    Scene, parameters and options are those the run began with; threads and ranks may differ.
    Pictures in frames/ are continued with the options they were drawn with; --render draws them
    where there are none. Missing ones are drawn at the end.

    \b
        loomstone resume out/drape
    """
    with _session() as (communicator, rank):
        begun = Run(run)
        file = SceneFile.of_run(begun)
        duration, rate, options, look = stored_options(begun)
        looks = video.drawn_with(run / "frames") or (look if render else None)
        del begun
        verify = (run / "frames.csv").exists()
        _advance(file, duration, rate, options, looks, run, threads, communicator, rank,
                 verify=verify, resume=True)  # fmt: skip


@app.command()
def render(
    run: RunArgument,
    width: Annotated[int | None, typer.Option(help="[pixels]")] = None,
    height: Annotated[int | None, typer.Option(help="[pixels]")] = None,
    color_by: Annotated[
        str | None,
        typer.Option(
            help=(
                "cloth | stretch | strain_weft | strain_warp | strain_shear | strain_split |"
                " contact; several joined by +"
            )
        ),
    ] = None,
    color_map: Annotated[str | None, typer.Option(help="viridis | magma | diverging")] = None,
    color_low: Annotated[
        float | None, typer.Option(help="value at the low end of the colours")
    ] = None,
    color_high: Annotated[
        float | None, typer.Option(help="value at the high end of the colours")
    ] = None,
    pattern: Annotated[str | None, typer.Option(help="weave | checker | plain")] = None,
    wireframe: Annotated[bool | None, typer.Option(help="edges over the cloth")] = None,
    field_lines: Annotated[
        int | None, typer.Option(help="lines of the magnets' field, 0: none")
    ] = None,
    frame: Annotated[
        list[int], typer.Option(help="only this frame, -1 is the last; may be given again")
    ] = [],  # noqa: B006
    out: Annotated[
        Path | None,
        typer.Option(
            help="directory for pictures and video; default: frames in the run, its video.mp4"
        ),
    ] = None,
    jobs: Annotated[int, typer.Option(help="frames drawn at once, 0: one a processor", min=0)] = 0,
    again: Annotated[
        bool, typer.Option("--again", help="delete the pictures that are there and draw all")
    ] = False,
) -> None:
    """Draws the frames of a run and makes a video.

    Options that are not given are those of the pictures in frames/, else those of the scene file.
    Pictures (PNG) that are there are kept, so it continues where it was interrupted. A directory
    holds pictures of one set of options: others need --out, or --again. Single frames (--frame) are
    drawn anew, into the directory of the run unless --out says otherwise. A fitted camera shows
    what it would of the first frame; colours without --color-low and --color-high span the values
    of all frames.

    Strain is U - I, as limits are; strain_split shows weft on the left half of each cloth and warp
    on the right; contact is 1, and 2 where triangles were forced to intersect; several --color-by
    joined by + lie one below another.

    \b
        loomstone render out/drape --color-by stretch --wireframe
        loomstone render out/disc --color-by strain_split+strain_shear --color-map diverging
    """
    with _session(parallel=False):
        source = Run(run)
        options = video.drawn_with(source.directory / "frames")
        options = options or (
            stored_options(source)[3] if "render" in source.metadata else RenderOptions()
        )
        given: dict[str, Any] = {
            "width": width,
            "height": height,
            "color_by": color_by,
            "color_map": color_map,
            "color_low": color_low,
            "color_high": color_high,
            "pattern": pattern,
            "wireframe": wireframe,
            "field_lines": field_lines,
        }
        options = options.replace(
            **{name: value for name, value in given.items() if value is not None}
        )
        for i in frame:
            if not -len(source) <= i < len(source):
                raise InvalidInput(
                    f"--frame must be in [0, {len(source) - 1}], or count from the end, got {i}"
                )
        wanted = [i % len(source) for i in frame] or None
        with typer.progressbar(
            length=len(wanted or source), label="rendering", hidden=not sys.stdout.isatty()
        ) as bar:
            paths = video.render_run(
                source, options, out=out, jobs=jobs, again=again, frames=wanted, progress=bar.update
            )
        print(
            f"pictures: {paths[0]}"
            if len(paths) == 1
            else f"pictures: {paths[0].parent} ({len(paths)})"
        )
        if not frame:
            target = (out or source.directory) / "video.mp4"
            path = video.encode(paths[0].parent, target, frames=len(paths), rate=source.rate)
            print(f"video: {path}")


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="scene file, or directory of a run")],
    p: Parameters = [],  # noqa: B006
    render: Annotated[
        Path | None,
        typer.Option(help="draw the start here (PNG), vertices of intersecting triangles marked"),
    ] = None,
) -> None:
    """Checks a scene before it is run, or the claims of a run.

    A scene: whether it can be simulated, and the intersecting triangles of its start. A run:
    intersecting triangles of every frame, and what the scene file's check() claims. Exit code 1
    where something does not hold.

    \b
        loomstone check scenes/drape.py --render start.png
        loomstone check out/drape
    """
    with _session(parallel=False):
        if path.is_dir():
            good = inspection.check_run(Run(path))
        else:
            good = inspection.check_scene(SceneFile.open(path, parse_parameters(p)), render)
        if not good:
            raise typer.Exit(1)


@app.command()
def info(
    path: Annotated[Path, typer.Argument(help="run, .vtkhdf file, checkpoint, mesh or scene file")],
) -> None:
    """Says what is in a file or directory.

    \b
        loomstone info out/drape
    """
    with _session(parallel=False):
        inspection.describe(path)


@app.command()
def plot(
    run: Annotated[
        Path,
        typer.Argument(
            help="directory of a run; or `force` or `torque`, of magnets given by --mesh"
        ),
    ],
    what: Annotated[str, typer.Option(help=" | ".join(plots.KINDS))] = "energy",
    out: Annotated[
        Path | None,
        typer.Option(help="picture to write; default: WHAT.png in the run, or force.png"),
    ] = None,
    mesh: Annotated[
        list[Path],
        typer.Option(help="closed mesh of a magnet [m]; given twice: the first over the second"),
    ] = [],  # noqa: B006
    magnetization: Annotated[str, typer.Option(help="J = mu0 M of the magnets [T]")] = "0,0,1",
    axis: Annotated[str, typer.Option(help="where the first magnet is from the second")] = "0,0,1",
    reach: Annotated[
        float, typer.Option(help="largest distance [m], 0: the size of the magnet")
    ] = 0.0,
) -> None:
    """Plots a run over time, or forces between magnets.

    Of a run: energies, stages, contacts, stretch, strain, iterations, from its steps.csv; strain is
    the largest in each direction, what of it is beyond limits, and the sweeps of strain limiting.
    `force`: of one magnet on another over the gap between them; `torque`: over the angle by which
    one is turned.

    \b
        loomstone plot out/drape --what stages
        loomstone plot force --mesh magnet.obj --magnetization 0,0,1.2 --out force.png
    """
    with _session(parallel=False):
        if str(run) in ("force", "torque") and not run.is_dir():
            from ..magnetics import mesh_pictures as pictures

            values = (
                pictures.numbers(magnetization, "--magnetization"),
                pictures.numbers(axis, "--axis"),
            )
            path = pictures.curve_of_meshes(
                str(run), mesh, *values, reach, out or Path(f"{run}.png")
            )
            print(f"plot: {path}")
        else:
            print(f"plot: {plots.plot_run(run, kind=what, path=out)}")


@app.command()
def field(
    mesh: Annotated[Path, typer.Argument(help="closed mesh [m], OBJ or PLY")],
    magnetization: Annotated[str, typer.Option(help="J = mu0 M inside [T]")] = "0,0,1",
    lines: Annotated[int, typer.Option(help="field lines, each of equal flux", min=1)] = 150,
    out: Annotated[
        Path, typer.Option(help="picture (PNG) of the magnet with its field lines")
    ] = Path("field.png"),
    eye: Annotated[str, typer.Option(help="direction from which it is seen")] = "0.6,-1,0.35",
    slice_: Annotated[
        Path | None,
        typer.Option("--slice", help="also draw |B| and its direction in a plane here (PNG)"),
    ] = None,
    plane: Annotated[
        str, typer.Option(help="of the slice, through the centre: xy | xz | yz")
    ] = "xz",
) -> None:
    """Draws the field of a magnet of any shape.

    \b
        loomstone field horseshoe.obj --magnetization 0,0,1 --lines 200 --slice slice.png
    """
    with _session(parallel=False):
        from ..magnetics import figures
        from ..magnetics import mesh_pictures as pictures
        from ..meshes.shapes import read_mesh

        polarization = pictures.numbers(magnetization, "--magnetization")
        surface = read_mesh(mesh, with_uv=False)
        path, found = pictures.draw_field(
            surface, polarization, out, n_lines=lines, eye=pictures.numbers(eye, "--eye")
        )
        print(f"{len(found.lines)} field lines of {sum(map(len, found.lines))} points: {path}")
        if slice_:
            magnet = pictures.magnet_of(mesh, polarization)
            print(f"slice: {figures.plot_slice(magnet, slice_, plane=plane)}")  # type: ignore[arg-type]


@app.command()
def fabrics(
    as_json: Annotated[bool, typer.Option("--json", help="all fields, for programs")] = False,
) -> None:
    """Lists the fabrics of loomstone.fabrics.

    Stiffness, limits of strain, bending by direction, published drape coefficients and sources.

    \b
        loomstone fabrics
    """
    from ..fabrics import listing as fabric_list

    print(fabric_list.fabrics_json() if as_json else fabric_list.fabrics_text())


@report.command("fabrics")
def fabrics_report(
    names: Annotated[
        str, typer.Option("--fabrics", help="names, separated by commas; default: all")
    ] = "",
    p: Annotated[
        list[str],
        typer.Option(
            "-p",
            "--parameter",
            help="triangles of a draped specimen, or number of specimens, as name=value",
        ),
    ] = [],  # noqa: B006
    out: Annotated[Path, typer.Option(help="directory for report.json and drape.png")] = Path(
        "out/fabrics"
    ),
    threads: Threads = 0,
) -> None:
    """Measures fabrics as a laboratory does, by simulation.

    Each is draped over Cusick's pedestal (disc 18 cm, specimen 30 cm), and strips of it hang until
    41.5 degrees (ASTM D1388): drape coefficient beside the published band, overhang beside the
    elastica. Three specimens with different meshes are draped; a fabric takes about half a minute.

    \b
        loomstone report fabrics --fabrics cotton,denim -p triangles=3000
    """
    with _session(parallel=False):
        from ..fabrics.measurements import report as made

        settings, chosen = made.parameters(parse_parameters(p)), made.chosen(names)
        print(made.HEADER, flush=True)
        made.report_fabrics(chosen, out=out, threads=threads, done=made.print_report, **settings)
        print(f"report: {out / 'report.json'}\npicture: {out / 'drape.png'}")


@app.command()
def versions() -> None:
    """Prints what this installation consists of.

    Paste it into reports of problems.
    """
    from ..versions import show_versions

    show_versions()


def _advance(
    file: SceneFile,
    duration: float,
    rate: float,
    integrator: IntegratorOptions,
    look: RenderOptions | None,
    directory: Path,
    threads: int,
    communicator: Communicator,
    rank: int,
    *,
    verify: bool = False,
    overwrite: bool = False,
    resume: bool = False,
) -> None:
    share = int(
        os.environ.get("OMPI_COMM_WORLD_LOCAL_SIZE", "1")
    )  # ranks that share these processors
    threads = threads or max(1, _core.default_thread_count() // share)
    simulation = Simulation(
        file.scene(), integrator=integrator, threads=threads, communicator=communicator
    )
    say: Callable[..., None] = print if rank == 0 else (lambda *_: None)
    say(
        f"{simulation!r}, step {simulation.step_size:g} s, {simulation.threads} threads,"
        f" {simulation.ranks} ranks"
    )
    try:
        report = execute(
            simulation,
            RunOptions(duration, rate, look, verify),
            directory,
            metadata=file.metadata(duration, rate, integrator, file.render),
            overwrite=overwrite,
            resume=resume,
            control=file.control,
            observer=progress.observer(rank),
        )
    except Interrupted as stop:
        say(
            f"stopped by {stop} at {simulation.time:.3f} s; continue with: loomstone resume"
            f" {directory}"
        )
        raise typer.Exit(128 + stop.signal) from None
    say(inspection.report_text(report))
    say(f"frames: {directory / 'run.vtkhdf'}")
    if look:
        say(
            f"pictures: {directory / 'frames'}\n"
            f"video: {report.get('video', 'none: frames/ was given other options while it ran')}"
        )
    if report.get("intersecting_frames"):
        raise typer.Exit(1)


def _other_method(options: IntegratorOptions, name: str) -> IntegratorOptions:
    if name not in METHODS:
        raise InvalidInput(
            f"--integrator must be one of {', '.join(sorted(METHODS))}, got {name!r}"
        )
    if name in (
        "explicit-euler",
        "symplectic-euler",
    ):  # what the scene file says about solving does not concern them
        return IntegratorOptions(method=name, step=options.step)
    return options.replace(method=name)


@contextmanager
def _session(parallel: bool = True) -> Iterator[tuple[Communicator, int]]:
    """The ranks of this command; turns our errors into one sentence, and one rank's failure into
    the end of all.
    """
    if parallel and _core.launched_by_mpi():
        communicator = _core.mpi_communicator()
    else:
        communicator = _core.single_communicator()

    def fail(message: str) -> NoReturn:
        print(f"loomstone: {message}", file=sys.stderr, flush=True)
        raise typer.Exit(1)

    try:
        yield communicator, communicator.rank
    except (Error, OSError) as error:
        share_failure(communicator, error)
        if communicator.rank != 0:  # rank 0 has the same error by now and says it
            raise typer.Exit(1) from None
        fail(str(error))
    except AssertionError as error:
        fail(f"a claim does not hold: {error}")
    except KeyboardInterrupt:
        fail("interrupted")
    except (typer.Exit, typer.Abort):
        raise
    except BaseException:
        if communicator.size > 1:
            import traceback

            traceback.print_exc()
            sys.stderr.flush()
            communicator.abort(1)
        raise


def main() -> Any:
    """Entry point of the command."""
    return app()
