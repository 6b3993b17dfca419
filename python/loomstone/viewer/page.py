"""A web page that shows frames, served by viser."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Camera, Frame, FrameTopology, Unsupported
from ..magnetics.lines import FieldLines
from .surfaces import FIELDS, Surfaces

__all__ = ["Page"]

_LINES = "/field lines"
_LINE_COLOR = (120, 60, 110)
# Direction from the target to the eye if the camera has both at the same point, as in
# renderer/camera.cpp.
_FROM = (0.62, -1.0, 0.44)


class Page:
    """A page with the surfaces of a frame, a choice of colours and a camera.

    title : label of the control panel
    topology : topology of the frames
    first : first frame; a camera with fit=True and no keyframes shows all of it except floors
    camera : camera at the start; the user turns it with the mouse
    host, port : address at which the server listens. If the port is taken, the next free one is
        used.

    Raises Unsupported if viser is not installed.
    """

    def __init__(
        self,
        title: str,
        topology: FrameTopology,
        first: Frame,
        *,
        camera: Camera,
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        self.server = _start(host, port)
        gui = self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        gui.set_panel_label(title)
        self.topology = topology
        self.surfaces = Surfaces(self.server, topology)
        self._lines: Any = None
        self._look_at(first, camera)
        self.frame = first
        with gui.add_folder("Colours"):
            self._field = gui.add_dropdown("of the cloth", FIELDS)
            self._limits = gui.add_vector2("range", (1.0, 1.1), step=0.01, visible=False)
        self._field.on_update(lambda _: self._choose_field())
        self._limits.on_update(lambda _: self.show(self.frame))
        self.show(first)

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def show(self, frame: Frame) -> None:
        """Shows a frame."""
        self.frame = frame
        self.surfaces.show(frame, self._field.value, tuple(self._limits.value))

    def show_lines(self, found: FieldLines | None) -> None:
        """Shows magnetic field lines; None removes them."""
        if self._lines is not None:
            self._lines.remove()
            self._lines = None
        if found is None or not found.lines:
            return
        segments = np.concatenate([np.stack([k[:-1], k[1:]], axis=1) for k in found.lines])
        self._lines = self.server.scene.add_line_segments(
            _LINES, segments, _LINE_COLOR, line_width=1.5
        )

    def stop(self) -> None:
        """Closes the page."""
        self.server.stop()

    def _choose_field(self) -> None:
        field = self._field.value
        self._limits.visible = field not in ("cloth", "contact")
        if field == "stretch":
            self._limits.value = (1.0, 1.1)
        elif field.startswith("strain"):
            self._limits.value = (-0.1, 0.1)
        else:
            self._limits.value = (0.0, 2.0)
        self.show(self.frame)

    def _look_at(self, first: Frame, camera: Camera) -> None:
        start_eye = camera.eyes[0] if camera.times else camera.eye
        start_target = camera.targets[0] if len(camera.targets) else camera.target
        eye, target, up = (np.array(v, float) for v in (start_eye, start_target, camera.up))
        angle = math.radians(camera.field_of_view_degrees)
        if camera.fit and not camera.times:
            centre, radius = _ball(self.topology, first)
            direction = eye - target if np.any(eye != target) else np.array(_FROM)
            direction = direction / np.linalg.norm(direction)
            target, eye = centre, centre + direction * radius / math.sin(0.5 * angle)
        start = self.server.initial_camera
        start.up, start.position, start.look_at, start.fov = up, eye, target, angle
        size = float(np.linalg.norm(eye - target))
        start.near, start.far = 1e-3 * size, 1e3 * size
        self.server.scene.set_up_direction(tuple(up))
        # The hemisphere light illuminates surfaces that the default lights leave dark.
        self.server.scene.configure_default_lights(enabled=True, cast_shadow=True)
        self.server.scene.add_light_hemisphere(
            "/sky", sky_color=(255, 255, 255), ground_color=(190, 185, 175), intensity=1.2
        )


def _ball(topology: FrameTopology, frame: Frame) -> tuple[NDArray[np.float64], float]:
    """Returns the centre and radius [m] of a ball around all surfaces except floors.

    If there are only floors, the ball encloses them.
    """
    seen = ~topology.body_is_floor.astype(bool)[topology.body_of_vertex]
    points = np.concatenate([frame.positions, frame.body_vertices[seen]])
    if not len(points):
        points = frame.body_vertices
    centre = 0.5 * (points.min(0) + points.max(0))
    return centre, max(float(np.linalg.norm(points - centre, axis=1).max()), 1e-6)


def _start(host: str, port: int) -> Any:
    try:
        import viser
    except ImportError:
        raise Unsupported(
            'the page needs viser, which is not installed; run: pip install "loomstone[view]"'
        ) from None
    return viser.ViserServer(host=host, port=port, verbose=False)
