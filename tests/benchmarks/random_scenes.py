"""Simulates random scenes, each with an integrator drawn at random, and lists what goes wrong.

    python tests/benchmarks/random_scenes.py [--scenes 100 --seed 1 --integrators bdf2 asynchronous]
    python tests/benchmarks/random_scenes.py --kinds mixture
    python tests/benchmarks/random_scenes.py --kinds sheet --seed 1 --only 17

The integrators are by default all except explicit Euler, which gains energy. A scene of the kind
`sheet` is one sheet, whose size varies by a factor of 200, stiffness by 10,000 and, for a given
size, speed by 500. In a `mixture`, up to three cloths meet bodies, magnets, coils, and pins and
obstacles that move. A scene is listed if it is refused (for example because cloths intersect at the
start), or if

- a step fails;
- an impact remains or triangles intersect, before a script has forced any triangles to intersect;
- the balance of energy with contacts rises by more than --tolerance of the largest kinetic energy
  or of the work of scripts, whichever is larger;
- the solve creates more energy than initial motion, gravity, scripts and loads supply, even if
  certification removes it;
- or a step takes longer than --longest.

A run stops after --wall seconds, even if its simulated time is not over. The exit status is 1 if
the first or the second item of this list applies to any scene.
"""

import argparse
import time
from dataclasses import dataclass

import loomstone as ls
import numpy as np
from random_parts.mixtures import random_mixture
from random_parts.sheets import random_sheet
from smoke import parsed

METHODS = ls.integrators.METHODS
INTEGRATORS = [name for name in METHODS if name != "explicit-euler"]  # explicit Euler gains energy
KINDS = {"sheet": random_sheet, "mixture": random_mixture}


@dataclass
class Verdict:
    """Result of a run."""

    failure: str = ""
    n_wrong: int = 0  # steps with unresolved impacts or intersections that nothing forces
    balance: float = 0.0  # largest gain / larger of kinetic energy and work of scripts
    created: float = 0.0  # energy that the solve creates, as a fraction of the supplied energy
    longest: float = 0.0  # wall time of the slowest step [s]
    wrong: bool = False
    gaining: bool = False  # `balance` or `created` is too large
    slow: bool = False  # `longest` is too long


def judge(sim: ls.Simulation, end: float, given: argparse.Namespace) -> Verdict:
    """Runs until `end` [s], a failure or the given wall time, and returns how the run went."""
    verdict, forced, start = Verdict(), False, time.perf_counter()
    gain = work = created = 0.0  # [J]
    first_kinetic = None  # after the first step [J]
    while sim.time < end and time.perf_counter() - start < given.wall:
        before = time.perf_counter()
        try:
            sim.step()
        except ls.SolverFailure as failure:
            verdict.failure = str(failure)
            break
        verdict.longest = max(verdict.longest, time.perf_counter() - before)
        contacts, account = sim.report.contacts, sim.report.account
        forced = forced or contacts.forced > 0
        if (contacts.unresolved > 0 or contacts.intersections > 0) and not forced:
            verdict.n_wrong += 1
        if first_kinetic is None:
            first_kinetic = account.largest_kinetic
        gain = max(gain, account.contact_balance * account.largest_kinetic)
        work = max(work, abs(account.scripts))
        created = max(created, -account.lost)
    account = sim.report.account
    verdict.balance = gain / max(account.largest_kinetic, work, 1e-300)
    supplied = (first_kinetic or 0.0) + work + abs(account.loads) + abs(sim.report.energy.gravity)
    verdict.created = created / (supplied + 1e-12)  # 1e-12 J: rounding of cloth at rest
    verdict.gaining = verdict.balance > given.tolerance or verdict.created > 1.0
    verdict.slow = verdict.longest > given.longest
    verdict.wrong = bool(verdict.failure) or verdict.n_wrong > 0
    return verdict


def run(kind: str, number: int, given: argparse.Namespace) -> Verdict:
    """Runs a scene and returns its verdict, which has no faults if the scene is refused. Prints a
    line if the scene is refused, if something goes wrong, or with --only.
    """
    random = np.random.default_rng((given.seed, number))
    name = given.integrators[int(random.integers(len(given.integrators)))]
    words, size, scene = KINDS[kind](random)
    try:
        sim = ls.Simulation(scene, integrator=METHODS[name](), threads=1)
    except (ls.InvalidInput, ls.Unsupported) as refusal:  # for example intersections at the start
        print(f"{kind} {number} is refused: {str(refusal)[:60]} ...", flush=True)
        return Verdict()
    end = 0.3 * size**0.5 if kind == "sheet" else min(1.0, 1.2 * size**0.5)
    verdict = judge(sim, end, given)
    if verdict.wrong or verdict.gaining or verdict.slow or given.only is not None:
        found = f"balance {verdict.balance:.3f}, {verdict.created:.2g} created, "
        found += f"{verdict.n_wrong} wrong steps, longest step {verdict.longest:.2f} s, "
        found += f"{sim.step_index} steps to {sim.time / end:.2f}"
        print(f"{kind} {number}: {verdict.failure or found}: {name}, {words}", flush=True)
    return verdict


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kinds", nargs="+", choices=list(KINDS), default=list(KINDS))
    parser.add_argument("--scenes", type=int, default=100, help="number of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="number of the only scene to run")
    parser.add_argument("--integrators", nargs="+", choices=INTEGRATORS, default=INTEGRATORS)
    parser.add_argument("--tolerance", type=float, default=0.05)
    parser.add_argument("--wall", type=float, default=8.0, help="[s]")
    parser.add_argument("--longest", type=float, default=5.0, help="[s]")
    given = parsed(parser, scenes=8, wall=0.3)
    numbers = range(given.scenes) if given.only is None else range(given.only, given.only + 1)
    n_wrong = 0
    for kind in given.kinds:
        verdicts = [run(kind, number, given) for number in numbers]
        wrong = sum(verdict.wrong for verdict in verdicts)
        gaining = sum(verdict.gaining for verdict in verdicts)
        slow = sum(verdict.slow for verdict in verdicts)
        n_wrong += wrong
        print(
            f"{len(verdicts)} scenes of kind {kind}: {wrong} wrong, {gaining} gain energy, "
            f"{slow} have slow steps",
            flush=True,
        )
    raise SystemExit(1 if n_wrong else 0)


if __name__ == "__main__":
    main()
