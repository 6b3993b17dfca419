"""Shows the frames of a run on a page with a timeline."""

from __future__ import annotations

import threading
import time
from typing import Any

from .._core import CacheError, Camera
from ..runs.cache import Run
from .page import Page

__all__ = ["Player"]

# Largest number of pictures shown per second while a run plays [1/s].
_RATE = 30.0
# Interval at which the page checks for new frames of a run in progress [s].
_LOOK = 1.0


class Player:
    """A page that plays a run. New frames of a run in progress are added to its timeline.

    Attributes: page (Page).
    """

    def __init__(self, run: Run, *, camera: Camera, host: str, port: int) -> None:
        if not len(run):
            raise CacheError(f"{run.directory} has no frames yet; view it later")
        self._run = run
        self.page = Page(
            run.directory.name, run.topology, run[0], camera=camera, host=host, port=port
        )
        gui = self.page.server.gui
        with gui.add_folder("Time"):
            self._slider = gui.add_slider(
                "frame", min=0, max=max(len(run) - 1, 1), step=1, initial_value=0
            )
            self._playing = gui.add_checkbox("play", len(run) > 1)
            self._speed = gui.add_slider("speed", min=0.05, max=4.0, step=0.05, initial_value=1.0)
            self._text = gui.add_markdown("")
        self._changed = threading.Event()
        self._stopped = threading.Event()
        self._slider.on_update(self._note_change)
        self._thread = threading.Thread(target=self._loop, name="loomstone player", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Closes the page."""
        self._stopped.set()
        self._changed.set()
        self._thread.join()
        self.page.stop()

    def wait(self) -> None:
        """Waits until stop() is called."""
        self._stopped.wait()

    def _note_change(self, event: Any) -> None:
        if event.client is not None:  # a user moved the slider, not _loop()
            self._changed.set()

    def _loop(self) -> None:
        shown, looked, place = -1, time.monotonic(), 0.0
        while not self._stopped.is_set():
            begun = time.monotonic()
            if begun - looked > _LOOK:
                looked = begun
                self._grow()
            if self._playing.value:
                last = int(self._slider.max)
                frames = self._speed.value * self._run.rate / _RATE
                place = frames + (place if int(place) == int(self._slider.value) else shown)
                self._slider.value = int(place) if place <= last else 0
                place = place if place <= last else 0.0
            i = min(int(self._slider.value), len(self._run) - 1)
            if i != shown:
                shown = i
                frame = self._run[i]
                self.page.show(frame)
                self._text.content = f"{frame.time:.3f} s, step {frame.step}"
            self._changed.wait(max(0.0, 1.0 / _RATE - (time.monotonic() - begun)))
            self._changed.clear()

    def _grow(self) -> None:
        """Extends the timeline by frames written since the run was last read.

        If the run cannot be read now, the page keeps its frames, and reads the run again later.
        """
        try:
            reopened = Run(self._run.directory)
        except CacheError:
            return
        if len(reopened) > len(self._run):
            self._run = reopened
            self._slider.max = len(reopened) - 1
