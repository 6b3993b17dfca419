"""Progress of a run as plain lines, and what they have in common with the progress bar."""

from __future__ import annotations

import time

from .._core import Frame, StepReport

__all__ = ["Counts", "Lines"]

# Time without a progress line [s] after which Lines prints one at the end of a step.
LONGEST_SILENCE = 10.0


def trouble(report: StepReport) -> str:
    """Returns the message about a step in which certification left impacts."""
    return (
        f"step {report.step} (t {report.time:.3f} s): {report.contacts.unresolved} impacts remain"
        f" at 1/64 of the step, and {report.contacts.intersections} triangle pairs intersect:"
        " scripted motion leaves the cloth no room"
    )


def overstrained(report: StepReport) -> str:
    """Returns the message about a step in which strain limits were exceeded."""
    excess = max(report.limits.weft_excess, report.limits.warp_excess, report.limits.shear_excess)
    return (
        f"step {report.step} (t {report.time:.3f} s): {report.limits.broken} triangles exceed"
        f" their strain limits, by up to {excess:.3f} (triangle {report.limits.worst_element});"
        " limits.csv lists the worst ones"
    )


class Counts:
    """Base class of observers that print: it counts steps, keeps the last report and warns."""

    def __init__(self) -> None:
        self._began = self._last = time.perf_counter()
        self._steps = 0
        self._report = StepReport()
        self._frames = self._done_before = 0
        self._troubled = self._overstrained = False

    def start(self, frames: int, done: int) -> None:
        self._began = time.perf_counter()
        self._frames, self._done_before = frames, done

    def step(self, report: StepReport) -> None:
        self._steps, self._report = self._steps + 1, report
        if report.contacts.unresolved and not self._troubled:  # warns once per tangle
            self.say(trouble(report))
        self._troubled = report.contacts.unresolved > 0 or report.contacts.intersections > 0
        if report.limits.broken and not self._overstrained:  # warns once per run
            self.say(overstrained(report))
            self._overstrained = True

    def say(self, line: str) -> None:
        print(line, flush=True)

    def status(self, time_reached: float) -> str:
        """Returns the text of a progress line: simulated time, steps per second of wall time,
        contacts and largest stretch.

        time_reached : the simulated time [s]
        """
        rate = self._steps / max(time.perf_counter() - self._began, 1e-9)
        report = self._report
        return (
            f"t {time_reached:.3f} s  {rate:.1f} steps/s  contacts {report.contacts.near}  stretch"
            f" {report.strain.stretch:.3f}"
        )


class Lines(Counts):
    """Prints one line per frame, and further lines in between if a frame takes long."""

    def step(self, report: StepReport) -> None:
        super().step(report)
        if time.perf_counter() - self._last > LONGEST_SILENCE:
            self._last = time.perf_counter()
            print(f"step {report.step}  {self.status(report.time)}", flush=True)

    def frame(self, index: int, frame: Frame) -> None:
        self._last = time.perf_counter()
        done = index + 1 - self._done_before
        left = (time.perf_counter() - self._began) / max(done, 1) * (self._frames - index - 1)
        minutes, seconds = divmod(round(left), 60)
        print(
            f"frame {index + 1}/{self._frames}  {self.status(frame.time)}  left"
            f" {minutes}:{seconds:02d}",
            flush=True,
        )

    def end(self) -> None: ...
