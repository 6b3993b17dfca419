"""Reports on fabrics: drape tests and cantilever tests, compared with reference values.

Drape coefficients are compared with published ranges, and overhangs with the elastica.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..._core import CacheError, Camera, InvalidInput, RenderOptions, Unsupported
from ...base.arguments import takes, whole
from ...base.figures import new_figure, save_figure
from ...integrators import SemiImplicitEuler
from ...pictures.renderer import Renderer
from ...simulation import Simulation
from ..fabric import Fabric
from ..named_fabrics import catalogue
from .bending_test import CantileverResult, cantilever
from .drape_test import DISC, SPECIMEN, CusickResult, cusick, drape_scene, shadow

__all__ = ["FabricReport", "report_fabrics", "report_text"]

DIRECTIONS = {"weft": 0.0, "bias": 45.0, "warp": 90.0}


@dataclass(frozen=True)
class FabricReport:
    """Measurements of one fabric."""

    fabric: Fabric
    drapes: list[CusickResult]  # one per specimen
    strips: dict[str, CantileverResult]  # by direction: weft, bias, warp

    @property
    def drape_coefficient(self) -> float:
        """Mean drape coefficient of the specimens [%]."""
        return float(np.mean([drape.drape_coefficient for drape in self.drapes]))

    @property
    def spread(self) -> float:
        """Half the range of the specimens' drape coefficients [percentage points]."""
        return float(np.ptp([drape.drape_coefficient for drape in self.drapes])) / 2

    @property
    def folds(self) -> str:
        """Number of folds, such as "5", or its range over the specimens, such as "5-7"."""
        counts = [drape.folds for drape in self.drapes]
        return f"{min(counts)}-{max(counts)}" if min(counts) < max(counts) else str(counts[0])

    @property
    def in_band(self) -> bool | None:
        """Whether the mean drape coefficient lies in the published range; None without a range."""
        band = self.fabric.band
        return None if band is None else band.low <= self.drape_coefficient <= band.high

    @property
    def off_band(self) -> float:
        """Distance of the mean drape coefficient from the published range [percentage points].

        It is 0 inside the range, or if no range is known.
        """
        band = self.fabric.band
        return (
            max(0.0, band.low - self.drape_coefficient, self.drape_coefficient - band.high)
            if band
            else 0.0
        )

    @property
    def remark(self) -> str:
        """Remarks on specimens not at rest, intersections, and a mean outside the published range.

        The remark on the mean is followed by caveats on bending. Empty if there are no remarks.
        """
        said = []
        if moving := sum(not drape.rest.at_rest for drape in self.drapes):
            said.append(
                f"{moving} of {len(self.drapes)} specimens did not come to rest in the time allowed"
            )
        if pairs := sum(drape.intersections for drape in self.drapes):
            said.append(f"{pairs} pairs of triangles intersect")
        if self.in_band is False:
            within = (
                ", less than the spread of the specimens" if self.off_band <= self.spread else ""
            )
            said.append(f"{self.off_band:.1f} points outside the published range{within}")
            said += [caveat for caveat in self.fabric.caveats if caveat.startswith("bending")]
        return "; ".join(said)

    def to_dict(self) -> dict[str, Any]:
        """Returns plain values for JSON."""
        band = self.fabric.band
        return {
            "fabric": self.fabric.name,
            "drape_coefficient": self.drape_coefficient,
            "spread": self.spread,
            "band": [band.low, band.high] if band else None,
            "in_band": self.in_band,
            "specimens": [
                {
                    "drape_coefficient": drape.drape_coefficient,
                    "folds": drape.folds,
                    "at_rest": drape.rest.at_rest,
                    "intersections": drape.intersections,
                    "seconds": drape.seconds,
                }
                for drape in self.drapes
            ],
            "remark": self.remark,
            "cantilever": {
                name: {
                    "overhang": strip.overhang,
                    "overhang_of_elastica": strip.elastica,
                    "bending_length": strip.bending_length,
                    "rigidity": strip.rigidity,
                    "measured_rigidity": strip.measured_rigidity,
                    "seconds": strip.seconds,
                }
                for name, strip in self.strips.items()
            },
        }


@takes()
def report_fabrics(
    names: Sequence[str] | None = None,
    *,
    out: str | os.PathLike[str] | None = None,
    triangles: int = 3000,
    specimens: int = 3,
    threads: int = 0,
    done: Callable[[FabricReport], None] | None = None,
) -> list[FabricReport]:
    """Runs the drape test and the cantilever test on fabrics; returns a report on each.

    names : names of fabrics, or None: all
    out : directory for report.json and drape.png, or None: nothing is written
    triangles : number of triangles of a draped specimen
    specimens : number of draped specimens, each with its own mesh
    threads : as in Simulation
    done : function called with the report on each fabric when it is complete

    Raises InvalidInput for an unknown fabric or a number out of range, CacheError if `out` cannot
    be created or a file in it cannot be written, and Unsupported if `out` is given and matplotlib
    is missing.
    """
    chosen: Mapping[str, Fabric] = {
        name: catalogue[name] for name in (catalogue if names is None else names)
    }
    if not chosen:
        raise InvalidInput("report_fabrics: at least one fabric must be named, got none")
    whole("specimens", specimens, 1, 100)
    if out is not None:
        _check_plotting()
        try:
            Path(out).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CacheError(
                f"{out} must be a directory that can be written: {error.strerror}; give another"
            ) from error
    reports = []
    for fabric in chosen.values():
        strips = {
            name: cantilever(fabric, angle_degrees=angle) for name, angle in DIRECTIONS.items()
        }
        seeds = range(1, specimens + 1)
        drapes = [cusick(fabric, triangles=triangles, seed=seed, threads=threads) for seed in seeds]
        reports.append(FabricReport(fabric, drapes, strips))
        if done:
            done(reports[-1])
    if out is not None:
        table = Path(out) / "report.json"
        try:
            table.write_text(json.dumps([report.to_dict() for report in reports], indent=1) + "\n")
        except OSError as error:
            raise CacheError(f"{table}: the report cannot be written: {error.strerror}") from error
        contact_sheet(reports, Path(out) / "drape.png")
    return reports


HEADER = (
    f"{'fabric':14s} {'drape %':>11s} {'band':>6s} folds   overhang [cm], deviation from elastica\n"
    f"{'':39s}   {'weft':>13s}  {'bias':>13s}  {'warp':>13s}"
)


def report_text(report: FabricReport) -> str:
    """Returns the report of one fabric as a line of a table, with any remark on a second line."""
    band = report.fabric.band
    limits = f"{band.low:g}-{band.high:g}" if band else "-"
    strips = "  ".join(
        f"{100 * strip.overhang:5.2f} {100 * strip.error:+5.1f}%"
        for strip in report.strips.values()
    )
    verdict = "" if report.in_band is None else "  in" if report.in_band else "  out"
    drape = f"{report.drape_coefficient:5.1f} ± {report.spread:.1f}"
    line = (
        f"{report.fabric.name:14s} {drape:>11s} {limits:>6s} {report.folds:>5s}   {strips}{verdict}"
    )
    return line + (f"\n    {report.remark}" if report.remark else "")


def print_report(report: FabricReport) -> None:
    """Prints report_text() and flushes the output."""
    print(report_text(report), flush=True)


def chosen(names: str) -> list[str]:
    """Returns the names of the chosen fabrics.

    names : names separated by commas, the value of the option --fabrics; empty: all fabrics
    """
    return [catalogue[name.strip()].name for name in names.split(",")] if names else list(catalogue)


def parameters(given: Mapping[str, Any]) -> dict[str, int]:
    """Checks and returns the parameters given by the option -p.

    They are `triangles`, the number of triangles of a specimen, and `specimens`, the number of
    draped specimens. Raises InvalidInput for another parameter or a number out of range.
    """
    limits = {"triangles": (400, 1_000_000), "specimens": (1, 100)}
    if unknown := [name for name in given if name not in limits]:
        raise InvalidInput(f"there is no parameter {unknown[0]!r}; known: {', '.join(limits)}")
    return {name: whole(name, value, *limits[name]) for name, value in given.items()}


def contact_sheet(reports: Sequence[FabricReport], path: Path) -> None:
    """Draws the first specimen of each fabric in one picture (PNG).

    Insets show the shadows of these specimens, with circles of 18 and 30 cm in diameter.
    """
    columns = min(4, len(reports))
    rows = -(-len(reports) // columns)
    figure = new_figure((4.0 * columns, 3.1 * rows))
    from matplotlib.patches import Circle

    for place, report in enumerate(reports):
        axes = figure.add_subplot(rows, columns, place + 1)
        axes.imshow(_picture(report))
        axes.set_axis_off()
        band = report.fabric.band
        published = f", published {band.low:g}-{band.high:g}" if band else ""
        axes.set_title(
            f"{report.fabric.name}: {report.drape_coefficient:.1f} ± {report.spread:.1f}"
            f" %{published}, {report.folds} folds",
            fontsize=10,
        )
        inset = axes.inset_axes((0.72, 0.0, 0.28, 0.37))
        covered, low, pixel = shadow(
            report.drapes[0].positions, report.drapes[0].mesh.triangles, pixel=1e-3
        )
        extent = (
            low[0],
            low[0] + pixel * covered.shape[0],
            low[1],
            low[1] + pixel * covered.shape[1],
        )
        inset.imshow(
            np.ma.masked_equal(covered.T, False),
            origin="lower",
            extent=extent,
            cmap="Greys",
            vmin=0,
            vmax=2,
        )
        for radius in (DISC, SPECIMEN):
            inset.add_patch(Circle((0, 0), radius, fill=False, linewidth=0.7, color="C0"))
        inset.set(xlim=(-0.155, 0.155), ylim=(-0.155, 0.155), aspect="equal")
        inset.set_axis_off()
    save_figure(figure, path, dpi=120)


def _picture(report: FabricReport) -> Any:
    camera = Camera(fit=False, eye=(0.0, -0.35, 0.21), target=(0.0, 0.0, -0.035))
    look = RenderOptions(width=640, height=440, camera=camera)
    scene = drape_scene(report.fabric, report.drapes[0].mesh)
    simulation = Simulation(scene, integrator=SemiImplicitEuler(step=1e-3), threads=1)
    simulation.positions = report.drapes[0].positions
    return np.asarray(Renderer(simulation.topology, look).render(simulation.frame()))


def _check_plotting() -> None:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise Unsupported(
            "the pictures of a report need matplotlib, which is not installed; pip install"
            " matplotlib"
        ) from None
