"""Shows a running simulation on a page, where a user can pull cloth, bodies and obstacles."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from .._core import Camera, Error, Frame, Scene
from ..integrators import Integrator
from ..magnetics.lines import frame_lines
from ..simulation import Simulation
from .grips import Grip
from .holding import Holder
from .page import Page

__all__ = ["Live"]

# Intended number of pictures per second [1/s].
_RATE = 30.0
# Largest number of updates of the field lines per second [1/s]. Tracing the lines can take longer
# than a step.
_LINE_RATE = 4.0
# If the simulation lags behind real time by more than this [s], the page shows slow motion. The
# simulation makes up for smaller delays.
_DELAY = 0.05


class Live:
    """A page with a running simulation.

    scene, integrator, threads : as in Simulation
    control : function called before every step, as in Simulation.run
    paused : whether the simulation waits for the user to start it
    lines : number of magnetic field lines at the start
    title, camera, host, port : as in live()

    Attributes: page (Page). Dragging a cloth, a rigid body or an obstacle with the left mouse
    button pulls it. Floors and obstacles with `vertex_positions` cannot be pulled.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        integrator: Integrator | None = None,
        threads: int = 0,
        control: Callable[[Simulation], None] | None = None,
        title: str = "loomstone",
        camera: Camera,
        paused: bool = False,
        lines: int = 0,
        host: str,
        port: int,
    ) -> None:
        def make() -> Simulation:
            return Simulation(scene, integrator=integrator, threads=threads)

        self._make = make
        self._control = control
        self._scene, self._n_lines = scene, lines
        self._sim = self._make()
        frame = self._sim.frame()
        self.page = Page(title, self._sim.topology, frame, camera=camera, host=host, port=port)
        self._holder = Holder(scene, self._sim)
        self._lock = threading.Lock()  # guards _sim, _grips and _restart
        self._grips: dict[int, Grip] = {}
        self._restart = False
        self._single = 0
        self._stopped = threading.Event()
        self._pictures: deque[tuple[float, float]] = deque()  # wall time and simulated time [s]
        self._lines_at = 0.0
        self._add_controls(paused)
        self._listen()
        self._thread = threading.Thread(target=self._loop, name="loomstone live", daemon=True)
        self._thread.start()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._sim.time

    @property
    def frame(self) -> Frame:
        """The frame that is shown."""
        return self.page.frame

    def rates(self) -> tuple[float, float]:
        """Returns the pictures per second [1/s] and the ratio of simulated to elapsed time [1].

        Both are means over the last 10 s before the latest picture, and 0 for fewer than two
        pictures in this time.
        """
        pictures = list(self._pictures)
        if len(pictures) < 2:
            return 0.0, 0.0
        elapsed = pictures[-1][0] - pictures[0][0]
        return (len(pictures) - 1) / elapsed, (pictures[-1][1] - pictures[0][1]) / elapsed

    def intersecting_pairs(self) -> list[list[int]]:
        """Returns the pairs of triangles that intersect now and share no vertex."""
        with self._lock:
            return self._sim.intersecting_pairs()

    def start(self) -> None:
        """Lets a paused simulation run, like the checkbox of the page."""
        self._running.value = True

    def pause(self) -> None:
        """Pauses the simulation before its next step."""
        self._running.value = False

    def stop(self) -> None:
        """Ends the simulation and closes the page."""
        self._stopped.set()
        self._thread.join()
        self.page.stop()

    def wait(self) -> None:
        """Waits until stop() is called."""
        self._stopped.wait()

    def _add_controls(self, paused: bool) -> None:
        gui = self.page.server.gui
        with gui.add_folder("Simulation"):
            self._running = gui.add_checkbox("run", not paused)
            self._speed = gui.add_slider("speed", min=0.05, max=2.0, step=0.05, initial_value=1.0)
            one, again = gui.add_button("one step"), gui.add_button("start again")
            self._text = gui.add_markdown("")
        one.on_click(lambda _: self._ask_for_step())
        again.on_click(lambda _: self._ask_to_restart())
        if self._scene.magnets or self._scene.coils:
            with gui.add_folder("Magnetic field"):
                self._lines: Any = gui.add_slider(
                    "field lines", min=0, max=200, step=10, initial_value=self._n_lines
                )
        else:
            self._lines = None

    def _ask_for_step(self) -> None:
        self._running.value = False
        self._single += 1

    def _ask_to_restart(self) -> None:
        with self._lock:
            self._restart = True

    def _listen(self) -> None:
        """Makes surfaces draggable if they can be held."""
        surfaces = self.page.surfaces
        for i, node in enumerate(surfaces.cloth_nodes):
            surfaces.on_drag(node, self._dragged("cloth", i))
        for i, node in enumerate(surfaces.body_nodes):
            if self._holder.can_hold(i):
                surfaces.on_drag(node, self._dragged("body", i))

    def _dragged(self, kind: str, index: int) -> Callable[[Any], None]:
        def follow(event: Any) -> None:
            with self._lock:
                held = self._grips.get(event.client_id)
                if event.phase == "start":
                    if held:
                        held.release(self._sim)
                    self._grips[event.client_id] = self._holder.hold(
                        self._sim, kind, index, event.start_position
                    )
                elif held and event.phase == "update":
                    held.goal = np.array(event.end_position, float)
                elif held:
                    held.release(self._sim)
                    del self._grips[event.client_id]

        return follow

    def _loop(self) -> None:
        """Keeps simulated time equal to elapsed time times speed, as far as the machine allows."""
        wall, start, shown_at = time.monotonic(), self._sim.time, 0.0
        last = start  # simulated time at the start of the latest step [s]
        while not self._stopped.is_set():
            if self._restarted():
                wall, start = time.monotonic(), self._sim.time
                last = start
            now = time.monotonic()
            wanted = start + (now - wall) * self._speed.value
            if not self._running.value:
                wall, start = now, self._sim.time
                if self._single:
                    self._single -= 1
                    self._step()
                    self._show(self._sim.time)
                else:
                    time.sleep(0.01)
                continue
            if wanted - self._sim.time > _DELAY * self._speed.value:
                wall, start = now, self._sim.time  # slow motion: ignores the delay
            if self._sim.time <= wanted:
                last = self._sim.time
                if not self._step():
                    continue
            if now - shown_at >= 1.0 / _RATE - 1e-3:
                shown_at = now
                self._show(float(np.clip(wanted, last, self._sim.time)))
            elif self._sim.time > wanted:
                time.sleep(min(1e-3, self._sim.time - wanted))

    def _restarted(self) -> bool:
        with self._lock:
            if not self._restart:
                return False
            self._restart = False
            self._grips.clear()
            self._sim = self._make()
            self._pictures.clear()
        self._show(self._sim.time)
        return True

    def _step(self) -> bool:
        """Takes a step; returns whether it succeeded. A failure pauses the simulation."""
        with self._lock:
            begun = self._sim.time
            try:
                if self._control:
                    self._control(self._sim)
                self._sim.step()
            except Error as error:
                self._running.value = False
                self._text.content = f"The simulation has stopped: {error}"
                return False
            for grip in self._grips.values():
                grip.lead(self._sim, self._sim.time - begun)
        return True

    def _show(self, at: float) -> None:
        with self._lock:
            frame = self._sim.frame_at(at)
        self.page.show(frame)
        now = time.monotonic()
        self._pictures.append((now, frame.time))
        while now - self._pictures[0][0] > 10.0:
            self._pictures.popleft()
        if len(self._pictures) % 10 == 0 or not self._running.value:
            self._tell(frame)
        if self._lines is not None and now - self._lines_at > 1.0 / _LINE_RATE:
            self._lines_at = now
            count = int(self._lines.value)
            self.page.show_lines(frame_lines(self._sim, frame, count) if count else None)

    def _tell(self, frame: Frame) -> None:
        pictures, speed = self.rates()
        stretch = float(np.max(frame.stretch, initial=0.0))
        self._text.content = (
            f"{frame.time:.2f} s, {speed:.2f} times real time, {pictures:.0f} pictures/s"
            + (f", largest stretch {stretch:.3f}" if stretch else "")
        )
