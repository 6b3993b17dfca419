"""The commands loomstone fabrics and loomstone report fabrics."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..runs.parameters import parse_parameters
from .application import app, command_line, report, session
from .options import Threads


@app.command()
def fabrics(
    as_json: Annotated[bool, typer.Option("--json", help="print all fields, as JSON")] = False,
) -> None:
    """Lists the fabrics of loomstone.fabrics.

    The list shows the density, stiffness, strain limits, bending by direction, use and source of
    each fabric, and published drape coefficients of similar fabrics.

    \b
        loomstone fabrics
    """
    from ..fabrics.listing import fabrics_json, fabrics_text

    print(fabrics_json() if as_json else fabrics_text())


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
            help="triangles=N (of each draped specimen) or specimens=N; may be repeated",
        ),
    ] = [],  # noqa: B006
    out: Annotated[Path, typer.Option(help="directory for report.json and drape.png")] = Path(
        "out/fabrics"
    ),
    threads: Threads = 0,
) -> None:
    """Measures fabrics by simulated laboratory tests.

    Drape: the fabric is draped over Cusick's pedestal (disc 18 cm, specimen 30 cm), and the drape
    coefficient is compared with the published range. By default, three specimens with different
    meshes are draped. Bending: the overhang at which the chord of a strip is inclined by 41.5
    degrees (ASTM D1388) is compared with that of the elastica. Each fabric takes about half a
    minute.

    \b
        loomstone report fabrics --fabrics cotton,denim -p triangles=3000
    """
    with session(parallel=False):
        from ..fabrics.measurements import report as made

        with command_line():
            settings, chosen = made.parameters(parse_parameters(p)), made.chosen(names)
        print(made.HEADER, flush=True)
        made.report_fabrics(chosen, out=out, threads=threads, done=made.print_report, **settings)
        print(f"report: {out / 'report.json'}\npicture: {out / 'drape.png'}")
