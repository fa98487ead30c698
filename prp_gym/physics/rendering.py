"""Frame rendering of one simulation by MuJoCo's renderer and viewer, with an overlay that shows the task."""

import os
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import choice, whole
from prp_gym.errors import RenderingError
from prp_gym.physics.renderer_pool import RendererPool
from prp_gym.physics.scene import CAMERAS
from prp_gym.robot.arrays import Array

Color = tuple[float, float, float, float]

GOAL_COLOR: Color = (0.10, 0.65, 0.25, 0.75)
PATH_COLOR: Color = (0.15, 0.40, 0.85, 0.80)
FORCE_COLOR: Color = (0.90, 0.15, 0.10, 1.0)

NO_DISPLAY = (
    "render_mode 'human' opens a window and this machine has no display (DISPLAY and WAYLAND_DISPLAY are"
    " unset); use 'rgb_array', or start a virtual display."
)
_POOL = RendererPool()
_MOST_PIXELS = 8192  # along one side of a frame
_CLOSING_TIMEOUT = 5.0  # [s]


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball in the world frame, with its centre (3) [m] and radius [m]."""

    center: Array
    radius: float
    color: Color


@dataclass(frozen=True, eq=False)
class Path:
    """A line through points (k, 3) in the world frame [m], with its width in pixels."""

    points: Array
    width: float
    color: Color


@dataclass(frozen=True, eq=False)
class Arrow:
    """An arrow from a point along a vector, both (3) in the world frame [m]."""

    start: Array
    vector: Array
    width: float
    color: Color


OverlayItem = Ball | Path | Arrow

_METRES_PER_NEWTON = 0.02
_ABOVE_TIP = np.array([0.0, 0.0, 0.05])  # [m]: beside the tip, which may be hidden by a surface


def force_arrow(tip_position: Array, force: Array) -> Arrow:
    """Arrow for a force (3) [N] of the tip, drawn a little above the tip (3) [m] at 2 cm per newton."""
    return Arrow(tip_position + _ABOVE_TIP, force * _METRES_PER_NEWTON, 0.008, FORCE_COLOR)


def add_overlay(scene: mujoco.MjvScene, overlay: Sequence[OverlayItem]) -> None:
    """Append the items of an overlay to a scene; items that exceed its capacity are left out."""
    for item in overlay:
        match item:
            case Ball():
                size = np.full(3, item.radius)
                _add_geom(scene, mujoco.mjtGeom.mjGEOM_SPHERE, size, item.center, item.color)
            case Path():
                for start, end in zip(item.points[:-1], item.points[1:], strict=True):
                    _add_connector(scene, mujoco.mjtGeom.mjGEOM_LINE, item.width, start, end, item.color)
            case Arrow():
                end = item.start + item.vector
                _add_connector(scene, mujoco.mjtGeom.mjGEOM_ARROW, item.width, item.start, end, item.color)


def _add_geom(scene: mujoco.MjvScene, kind: Any, size: Array, position: Array, color: Color) -> Any:
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = scene.geoms[scene.ngeom]
    scene.ngeom += 1
    rgba = np.array(color, dtype=np.float32)
    mujoco.mjv_initGeom(geom, kind, size, np.asarray(position, dtype=np.float64), np.eye(3).ravel(), rgba)
    return geom


def _add_connector(
    scene: mujoco.MjvScene, kind: Any, width: float, start: Array, end: Array, color: Color
) -> None:
    geom = _add_geom(scene, kind, np.zeros(3), np.zeros(3), color)
    if geom is not None:
        mujoco.mjv_connector(geom, kind, width, np.asarray(start), np.asarray(end))


class OffscreenRenderer:
    """Renders colour and depth frames without a window.

    Renderers of the same size, world and thread share their OpenGL context; the last one that is closed
    frees its memory.

    Args:
        model: Model of the simulation to render; its offscreen buffer is made as large as the frame.
        width: Width of the frame [pixels].
        height: Height of the frame [pixels].
        camera: Name of the camera, `overview` or `top`.

    Raises:
        RenderingError: This machine provides no OpenGL context.
        UnknownNameError: There is no such camera.
        InvalidValueError: The size is not a whole number of pixels, or is out of bounds.
    """

    def __init__(self, model: mujoco.MjModel, width: int, height: int, camera: str) -> None:
        check_view(width, height, camera)
        self._camera = camera
        try:
            key, self._renderer = _POOL.borrow(model, width, height)
        except (RuntimeError, AttributeError, ImportError, mujoco.FatalError) as error:
            raise RenderingError(
                f"MuJoCo cannot create an OpenGL context on this machine ({error}). Without a display set"
                " MUJOCO_GL=egl (or osmesa) before mujoco is first imported, and install Mesa's EGL library"
                " (Debian: libegl1)."
            ) from error
        self._give_back = weakref.finalize(self, _POOL.give_back, key)
        self._give_back.atexit = False  # by then OpenGL itself may have ended

    def draw(
        self, data: mujoco.MjData, overlay: Sequence[OverlayItem], *, depth: bool = False
    ) -> NDArray[Any]:
        """Render one frame.

        Args:
            data: State to render.
            overlay: Items to draw in addition to the model.
            depth: Whether to return distances instead of colours; overlay items have no depth.

        Returns:
            (height, width, 3) uint8, or (height, width) float32 distance from the camera [m].
        """
        if depth:
            self._renderer.enable_depth_rendering()
        else:
            self._renderer.disable_depth_rendering()
        self._renderer.update_scene(data, camera=self._camera)
        if not depth:
            add_overlay(self._renderer.scene, overlay)
        frame: NDArray[Any] = self._renderer.render().copy()
        return frame

    def close(self) -> None:
        """Give the OpenGL context back; a second call has no effect."""
        self._give_back()


def has_display() -> bool:
    """Whether a window can be opened here."""
    return sys.platform != "linux" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _require_window_system() -> None:
    """Check that a window system answers at the display; otherwise MuJoCo's viewer would end the process."""
    import mujoco.viewer

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if not mujoco.viewer.glfw.init():
            raise RenderingError("render_mode 'human': no window system answers at the display that is set.")


class WindowRenderer:
    """MuJoCo's interactive viewer in a window of its own.

    Args:
        model: Model of the simulation to show.
        data: The viewer's own copy of the state; `show` updates it.
        camera: Name of the camera, `overview` or `top`.
        on_key: Called with the code of every key that is pressed in the window, in the thread of the window.

    Raises:
        RenderingError: There is no display.
        UnknownNameError: There is no such camera.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        camera: str,
        on_key: Callable[[int], None] = lambda _: None,
    ) -> None:
        check_view(1, 1, camera)
        if not has_display():
            raise RenderingError(NO_DISPLAY)
        self._model, self._data = model, data
        _require_window_system()
        before = set(threading.enumerate())
        try:
            import mujoco.viewer

            self._viewer = mujoco.viewer.launch_passive(
                model, data, key_callback=on_key, show_left_ui=False, show_right_ui=False
            )
        except (RuntimeError, ImportError, mujoco.FatalError) as error:
            raise RenderingError(f"render_mode 'human' needs a display and OpenGL: {error}") from error
        self._threads = set(threading.enumerate()) - before
        with self._viewer.lock():
            self._viewer.cam.type = int(mujoco.mjtCamera.mjCAMERA_FIXED)
            self._viewer.cam.fixedcamid = model.camera(camera).id

    @property
    def is_open(self) -> bool:
        """Whether the user has not closed the window."""
        return bool(self._viewer.is_running())

    def show(self, model: mujoco.MjModel, data: mujoco.MjData, overlay: Sequence[OverlayItem]) -> None:
        """Update the window, including the position of the surface."""
        if not self._viewer.is_running():
            return
        with self._viewer.lock():
            self._model.body_pos[:], self._model.body_quat[:] = model.body_pos, model.body_quat
            self._data.time = data.time
            self._data.qpos[:] = data.qpos
            self._data.qvel[:] = data.qvel
            mujoco.mj_forward(self._model, self._data)
            self._viewer.user_scn.ngeom = 0
            add_overlay(self._viewer.user_scn, overlay)
        self._viewer.sync()

    def close(self) -> None:
        """Close the window and wait for its thread; a process that ends before its thread would crash."""
        self._viewer.close()
        for thread in self._threads:
            thread.join(_CLOSING_TIMEOUT)


def check_view(width: int, height: int, camera: str) -> None:
    """Check the size of a frame and the name of a camera.

    Raises:
        UnknownNameError: There is no such camera.
        InvalidValueError: The size is not a whole number of pixels, or is out of bounds.
    """
    choice("camera", camera, CAMERAS)
    for what, value in (("width", width), ("height", height)):
        whole(what, value, 1, _MOST_PIXELS, "pixels")
