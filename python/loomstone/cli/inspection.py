"""Descriptions of files, and checks of scenes and runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .. import _core, meshes
from .._core import CacheError, Error, Frame, InvalidInput, TriangleMesh
from ..integrators import step_text
from ..pictures.plots import ROUNDING, scale_of_gains
from ..pictures.renderer import Renderer
from ..runs.cache import Run
from ..runs.checkpoints import checkpoint_files, latest_checkpoint
from ..runs.scene_file import SceneFile, stored_options
from ..runs.steps import summary_of_steps
from ..runs.stored_program import printable, stored_program
from ..runs.stored_scene import STORED_SCENE, begun_in_python
from ..runs.verification import count_intersections
from ..simulation import Simulation
from .facts import mesh_of

__all__ = ["check_run", "check_scene", "describe", "print_source", "report_text"]

# Printed names of losses of energy. Losses that are not listed are printed under their own names.
# `withheld` includes the energy that certification dissipates at impacts, even if it withholds no
# motion.
LOSSES = {"withheld": "impacts and withheld motion"}


def describe(path: Path) -> None:
    """Prints the content of a run, cache file, checkpoint, mesh or scene file."""
    if not path.exists():
        raise CacheError(f"{path}: no such file or directory")
    if path.is_dir() or path.suffix == ".vtkhdf":
        _describe_run(Run(path))
    elif path.suffix == ".py":
        file = SceneFile.open(path, {})
        print(f"scene file, {file.duration:g} s at {file.rate:g} frames/s, {file.integrator!r}")
        for name, default in file.known.items():
            print(f"  -p {name}={default}")
    elif path.suffix == ".h5":
        checkpoint = _core.read_checkpoint(str(path))
        for name, array in sorted(checkpoint.arrays.items()):
            print(f"  {name} {array.shape}")
        for name, values in sorted(checkpoint.integers.items()):
            print(f"  {name} {values if len(values) < 8 else f'{len(values)} integers'}")
        for name, text in sorted(checkpoint.texts.items()):
            print(f"  {name} {text}")
    else:
        _describe_mesh(mesh_of(path))


def _describe_mesh(mesh: TriangleMesh) -> None:
    quality = meshes.quality(mesh)
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    print(
        f"{mesh!r}, mean edge {mesh.mean_edge:.4g} m, from {np.round(low, 4)} to"
        f" {np.round(high, 4)} m"
    )
    print(
        f"smallest angle {quality['min_angle_degrees']:.1f} degrees, ratio of largest to smallest"
        f" area {quality['area_ratio']:.2f}"
    )


def _describe_run(run: Run) -> None:
    print(repr(run))
    print(repr(run.topology))
    for kind, names in (("cloth", run.topology.cloth_names), ("body", run.topology.body_names)):
        for name in names:
            print(f"  {kind} {name}")
    kept = run.metadata
    if "loomstone" in kept:
        begun = begun_in_python(kept)
        path = "Python" if begun else printable(str(stored_program(run).path))
        parameters = {} if begun else stored_program(run).parameters
        print(f"written by loomstone {printable(str(kept.get('loomstone')))} from {path}")
        duration, rate, options, _ = stored_options(run)
        print(f"  parameters {parameters or 'default'}, {duration:g} s at {rate:g} frames/s")
        print(f"  integrator {options.method}, {step_text(options)}")
    print(f"checkpoints: {', '.join(p.name for p in checkpoint_files(run.directory)) or 'none'}")
    if len(run):
        contacts, stretch = run[-1].report.contacts.near, run[-1].stretch
        told = f", largest stretch {stretch.max():.4f}" if len(stretch) else ""
        print(f"last frame: {contacts} contacts{told}")
    if (run.directory / "steps.csv").exists():
        summary = summary_of_steps(run.directory / "steps.csv")
        lines = [*event_lines(run, summary), *contact_lines(summary), *limit_lines(summary)]
        lines += energy_lines(summary)
        for line in lines:
            print(line)


def print_source(path: Path) -> None:
    """Prints the scene program stored in a run.

    Raises InvalidInput if `path` is neither a directory nor a .vtkhdf file, or if the run was begun
    in Python.
    """
    if not path.is_dir() and path.suffix != ".vtkhdf":
        raise InvalidInput(f"--source needs the directory of a run, got {path}")
    run = Run(path)
    if begun_in_python(run.metadata):
        raise InvalidInput(
            f"{path}: was begun in Python, so it contains no program; its scene is data"
            f" ({STORED_SCENE})"
        )
    print(printable(stored_program(run).source))


def check_run(run: Run, *, trust: bool = False) -> bool:
    """Prints the frames with intersecting cloth, and checks the claims (check()) of the scene file.

    trust : run the program stored in the run even if it differs from the scene file on disk

    Returns True if no triangles of cloth intersect in any frame. Raises CacheError if the run has
    no frames, and AssertionError if a claim does not hold.
    """
    if not len(run):
        raise CacheError(f"{run.directory} has no frames yet; resume it, and check it later")
    counts = [count_intersections(run.topology, frame) for frame in run]
    tangled = {index: count.cloth for index, count in enumerate(counts) if count.cloth}
    print(f"{len(run)} frames, {len(tangled)} with intersecting triangles of cloth")
    if bodies := max((count.bodies for count in counts), default=0):
        print(
            f"bodies and obstacles among themselves: at most {bodies} intersecting pairs (not"
            " prevented)"
        )
    for index, number in tangled.items():
        print(f"  frame {index} at {run.times[index]:.3f} s: {number} pairs")
    if begun_in_python(run.metadata):
        print("the run was begun in Python, so there is no scene file with a check()")
        return not tangled
    claims = SceneFile.of_run(run, trust=trust).check
    if claims is None:
        print("the scene file has no check()")
    else:
        claims(run)
        print("the scene's claims hold")
    return not tangled


def check_scene(file: SceneFile, picture: Path | None) -> bool:
    """Prints sizes and intersections of a scene; returns whether it can be run.

    A scene cannot be run if, at the start, cloth intersects a surface or lies inside a closed body
    or obstacle, unless the scene allows this or has no collisions. Other faults raise an error.

    picture : path where a picture of the initial state is written, or None
    """
    scene = file.scene()
    problem: Error | None = None
    try:
        simulation = Simulation(scene, integrator=file.integrator)
    except InvalidInput as error:
        if not scene.collisions or scene.allow_initial_intersections:
            raise
        problem = error
        simulation = Simulation(
            scene.replace(allow_initial_intersections=True), integrator=file.integrator
        )
    # Intersections among bodies and obstacles are allowed; the walls of a box, for example,
    # overlap at its corners.
    pairs = [
        pair
        for pair in simulation.intersecting_pairs()
        if min(pair) < len(simulation.topology.triangles)
    ]
    print(repr(simulation))
    for cloth in scene.cloths:
        _describe_mesh(cloth.mesh)
    print(f"{len(pairs)} intersecting pairs of triangles{': ' + str(pairs[:20]) if pairs else ''}")
    if picture:
        frame = _marked(simulation.frame(), simulation, pairs)
        look = file.render.replace(color_by="contact", wireframe=True) if pairs else file.render
        _core.write_png(str(picture), Renderer(simulation.topology, look).render(frame))
        print(f"picture: {picture}")
    if problem:
        print(f"refused: {problem}")
    return problem is None


def _marked(frame: Frame, simulation: Simulation, pairs: list[Any]) -> Frame:
    marks = np.zeros(len(frame.positions), np.uint8)
    cloth = simulation.topology.triangles
    for triangle in np.asarray(pairs, int).reshape(-1):
        if triangle < len(cloth):
            marks[cloth[triangle]] = 2
    return frame.with_contact(marks)


def event_lines(run: Run, summary: dict[str, Any]) -> list[str]:
    """Returns lines about the steps of individual triangles in an asynchronous run.

    The first line compares the number of events with the number that there would be if all
    triangles had the shortest step. Without events, no lines are returned.

    If there are checkpoints, further lines count triangles by the longest step that each may take
    at the time of the newest checkpoint.
    """
    if not summary.get("events"):
        return []
    lines = [
        f"asynchronous steps: {summary['events']} events of triangles, instead of"
        f" {summary['synchronous_events']} if all triangles had the shortest step"
    ]
    checkpoint = latest_checkpoint(run.directory)
    if checkpoint is None:
        return lines
    steps = np.ravel(checkpoint.arrays["cloth.element_steps"])
    longest = steps.max()
    levels = np.floor(np.log2(longest / steps)).astype(int)
    for level, count in enumerate(np.bincount(levels)):
        low, high = (1e3 * longest * 0.5 ** (level + k) for k in (1, 0))
        lines.append(f"  longest step {low:.3g} to {high:.3g} ms: {count} triangles")
    return lines


def contact_lines(summary: dict[str, Any]) -> list[str]:
    """Returns lines of text about the contacts of a run, from the summary of its steps."""
    if not summary.get("most_contacts") and not summary.get("impacts"):
        return []
    lines = [
        (
            f"contact: largest stretch {summary['largest_stretch']:.3f}, acceleration in contact"
            f" {summary['contact_acceleration']:.3g} m/s^2 (root mean square), {summary['impacts']}"
            " impacts"
        ),
        (
            f"certification withheld {100 * summary['withheld']:.2g} % of the motion"
            f" ({100 * summary['withheld_in_worst_step']:.2g} % in the worst step) and"
            f" {summary['withheld_momentum']:.2g} kg m/s of momentum"
        ),
    ]
    if summary["forced_steps"]:
        lines.append(
            f"{summary['forced_steps']} steps ended with triangles forced to intersect, at most"
            f" {summary['most_forced']} pairs: scripted motion left the cloth no room"
            " (forced.csv; value 2 of --color-by contact)"
        )
    return lines


def limit_lines(summary: dict[str, Any]) -> list[str]:
    """Returns a line of text about steps that exceeded strain limits, if there are any."""
    if not summary.get("steps_with_broken_limits"):
        return []
    return [
        f"strain limits: {summary['steps_with_broken_limits']} steps exceeded them, in at most"
        f" {summary['most_broken_limits']} triangles and by at most {summary['largest_excess']:.2g}"
        " (limits.csv); look for pins, bodies and obstacles that pull cloth apart"
    ]


def energy_lines(summary: dict[str, Any]) -> list[str]:
    """Returns lines of text about the energies of a run, from the summary of its steps."""
    if not summary.get("largest_kinetic_energy"):
        return []

    energies = summary["energy_at_end"]
    largest = max(map(abs, (summary["largest_kinetic_energy"], *energies.values())))

    def listed(values: dict[str, float]) -> str:
        return ", ".join(
            f"{LOSSES.get(name, name)} {value:.3g} J"
            for name, value in values.items()
            if abs(value) > ROUNDING * largest
        )

    account = dict(summary["account_at_end"])
    work = {name: account.pop(name) for name in ("scripts", "loads")}
    lines = [f"energy at the end: {listed(energies) or '0 J'}"]
    if any(work.values()):
        lines.append(f"work: {listed(work)}")
    lines.append(f"losses: {listed(account) or '0 J'}")
    scale, relative_to = _scale_of_gains(summary)
    kinetic = summary["largest_kinetic_energy"]
    most, with_contacts, at_end = (
        _ratio(summary[name] * kinetic / scale)
        for name in ("largest_energy_balance", "largest_contact_balance", "energy_balance_at_end")
    )
    lines.append(
        f"rise of energy minus work: at most {most} ({with_contacts} with contacts), {at_end} at"
        f" the end, relative to the {relative_to}, {scale:.3g} J"
    )
    return lines


def _scale_of_gains(summary: dict[str, Any]) -> tuple[float, str]:
    return scale_of_gains(summary["largest_kinetic_energy"], summary["account_at_end"]["scripts"])


def _ratio(value: float) -> str:
    """Returns a ratio in per cent, or as a multiple if its magnitude is 10 or more."""
    return f"{value:.2%}" if abs(value) < 10.0 else f"{value:,.0f} times"


def _gain_lines(report: dict[str, Any]) -> list[str]:
    lines: list[str] = []
    if not report.get("largest_kinetic_energy"):
        return lines
    scale, relative_to = _scale_of_gains(report)
    for name, tolerated, which in (
        ("largest_energy_balance", 0.02, ""),
        ("largest_contact_balance", 0.05, " (including that of contacts)"),
    ):
        rise = report[name] * report["largest_kinetic_energy"] / scale
        if rise > tolerated:
            lines.append(
                f"energy{which} minus work rose by {100 * rise:.3g} % of the {relative_to}"
            )
    return lines


def report_text(report: dict[str, Any]) -> str:
    """Returns the report of a run as readable text."""
    wall, frames = report["wall_seconds"], max(report["frames"], 1)
    lines = [
        f"{report['steps']} steps to {report['time']:.3f} s in {wall:.1f} s ({wall / frames:.3f} s"
        " per frame)"
    ]
    if "seconds_per_stage" in report:
        total = sum(report["seconds_per_stage"].values()) or 1.0
        shares = (
            f"{name} {100 * value / total:.0f} %"
            for name, value in report["seconds_per_stage"].items()
        )
        lines.append("stages: " + ", ".join(shares))
        lines.append(
            f"{report['linear_iterations_per_step']:.1f} linear iterations per step, at most"
            f" {report['most_contacts']} contacts, largest stretch {report['largest_stretch']:.3f}"
        )
        lines.extend([*contact_lines(report), *limit_lines(report)])
    if report.get("unresolved_steps"):
        lines.append(
            f"{report['unresolved_steps']} steps left impacts unresolved, and at most"
            f" {report.get('most_intersections', 0)} triangle pairs intersected (see steps.csv):"
            " scripted motion leaves the cloth no room"
        )
    elif report.get("most_intersections"):
        lines.append(
            f"at most {report['most_intersections']} triangle pairs intersected: the cloth"
            " started with intersections"
        )
    if "verified_frames" in report:
        lines.append(
            f"{report['verified_frames']} frames verified: {report['intersecting_frames']} with"
            " intersecting triangles of cloth"
            + (
                f", at most {report['most_intersecting_pairs']} pairs"
                if report["intersecting_frames"]
                else ""
            )
        )
    if report.get("steps_in_parts"):
        lines.append(
            f"{report['steps_in_parts']} steps were taken in parts; parts last"
            f" {1e3 * report['mean_part']:.3g} ms on average, the shortest"
            f" {1e3 * report['least_part']:.3g} ms"
        )
    if report.get("steps_beyond_accuracy"):
        lines.append(
            f"the error of {report['steps_beyond_accuracy']} steps is larger than"
            " integrator.accuracy allows, even in the shortest parts; look for pins that pull cloth"
            " apart, or shorten a given integrator.step"
        )
    lines.extend(_gain_lines(report))
    lines.append(f"state {report['digest'][:16]}")
    return "\n".join(lines)
