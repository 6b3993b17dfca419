"""Energy balance of scenes: shows whether energy minus work stays below its initial value.

    python tests/benchmarks/energy.py
    python tests/benchmarks/energy.py drape twist --integrator bdf2

Each of the given scenes (default: all scene files) runs with at most about 3,600 triangles per
cloth, for at most 1 s of simulated time. The table lists this time [s], the largest kinetic energy
K [J], the largest gain without and with the energy of contacts, the gain at the end (without
contacts), the work and losses [J], and the processor time [s]. The gain is the increase of energy
minus work since the start, in percent of K. A row is marked if the largest gain exceeds 2 % without
contacts or 5 % with them.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import loomstone as ls
import numpy as np
from loomstone.runs.scene_file import SceneFile
from smoke import SCENES, parsed

SMALL: dict[str, dict[str, Any]] = {
    "bending": {"triangles": 3600},
    "bin": {"triangles": 300},
    "card": {"triangles": 3600},
    "clasp": {},
    "disc": {"triangles": 3600},
    "dragon": {"spheres": 20, "cells": 300},
    "drape": {"triangles": 3600},
    "dress": {"triangles": 3600},
    "field_lines": {},
    "figures": {"figures": 2, "balls": 8, "response": "explicit"},
    "flag": {"triangles": 3600},
    "fold": {"triangles": 3600},
    "funnel": {"triangles": 3600},
    "halbach": {},
    "hanging": {},
    "incline": {},
    "knot": {"triangles": 3600},
    "levitation": {},
    "lift": {},
    "limit_scaling": {"triangles": 3600},
    "motor": {},
    "plunger": {},
    "obstacle_walk": {"triangles": 1200},
    "pull": {},
    "ribbon": {"triangles": 3600},
    "sphere_slide": {"triangles": 3600},
    "stack": {"triangles": 600, "sheets": 6},
    "swing": {"columns": 38, "rows": 48},
    "swing_integrators": {"triangles": 3600},
    "swing_limits": {"triangles": 3600},
    "table_cloth": {"triangles": 3600},
    "toy_magnets": {},
    "twist": {"triangles": 3600},
    "uneven": {},
    "voice_coil": {},
    "wave_bar": {"triangles": 3600},
}
TERMS = ("scripts", "loads", "friction", "damping", "limits", "withheld", "lost")


def print_row(name: str, file: SceneFile, integrator: Any, duration: float) -> None:
    began = time.process_time()
    sim = ls.Simulation(file.scene(), integrator=integrator, threads=1)
    rows = [(0.0, 0.0, 0.0)]
    while sim.time < min(duration, file.duration) - 1e-9:
        if file.control:
            file.control(sim)
        sim.step()
        account = sim.report.account
        kinetic = account.largest_kinetic
        rows.append((account.balance * kinetic, account.contact_balance * kinetic, kinetic))
    without, with_contacts, kinetic = np.array(rows).T
    largest = max(kinetic.max(), 1e-300)
    most, most_with = without.max() / largest, with_contacts.max() / largest
    terms = " ".join(f"{getattr(account, term):>9.2g}" for term in TERMS)
    print(
        f"{name:>13} {sim.time:>5.2f} {largest:>9.2g} {100 * most:>7.2f} {100 * most_with:>7.2f}"
        f" {100 * without[-1] / largest:>8.1f} {terms} {time.process_time() - began:>7.1f}"
        + (" *" if most > 0.02 or most_with > 0.05 else ""),
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", help="names of scene files; default: all")
    parser.add_argument("--duration", type=float, default=1.0, help="longest simulated time [s]")
    parser.add_argument("--integrator", help="method for all scenes; default: that of each")
    parser.add_argument("--triangles", type=int, help="of all scenes with this parameter")
    tiny = ["hanging", "drape", "motor"]
    arguments = parsed(parser, scenes=tiny, duration=0.02, triangles=200)
    print(
        "        scene  time     K [J]  most %  cont. %  end %  "
        + " ".join(f"{term:>9}" for term in TERMS)
        + " [J]  cpu [s]"
    )
    for name in arguments.scenes or SMALL:
        parameters = dict(SMALL[name])
        if arguments.triangles and "triangles" in parameters:
            parameters["triangles"] = arguments.triangles
        file = SceneFile.open(SCENES / f"{name}.py", parameters)
        integrator = file.integrator
        if arguments.integrator:
            integrator = ls.integrators.METHODS[arguments.integrator]()
        print_row(name, file, integrator, arguments.duration)


if __name__ == "__main__":
    main()
