"""Frame rendering of one simulation by MuJoCo's renderer and viewer, with an overlay that shows the task."""

import os
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
from numpy.typing import NDArray

from prp_gym.checks import choice, whole
from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.floor_scale import FloorScale
from prp_gym.drawing.light import set_light
from prp_gym.drawing.overlay import Arrow, Ball, OverlayItem, Path
from prp_gym.drawing.surface_patch import SurfacePatch
from prp_gym.drawing.viewpoint import Viewpoint
from prp_gym.errors import RenderingError
from prp_gym.physics.renderer_pool import RendererPool
from prp_gym.physics.scene import CAMERAS, FIXED_CAMERAS, FLOOR_HEIGHT, SURFACE_GROUP

__all__ = ["Arrow", "Ball", "OffscreenRenderer", "OverlayItem", "Path", "WindowRenderer", "check_view"]

NO_DISPLAY = (
    "render_mode 'human' opens a window and this machine has no display (DISPLAY and WAYLAND_DISPLAY are"
    " unset); use 'rgb_array', or start a virtual display."
)
_POOL = RendererPool()
_MOST_PIXELS = 8192  # along one side of a frame
_CLOSING_TIMEOUT = 5.0  # [s]
_WINDOW_HEIGHT = 720  # [pixels], about: the fineness of what is drawn
_WINDOW_ASPECT = 1.5


def add_overlay(canvas: Canvas, patch: SurfacePatch | None, overlay: Sequence[OverlayItem]) -> None:
    """Add the items of an overlay to a scene, the scale on the floor, and the surface if there is one."""
    for item in overlay:
        item.draw(canvas)
    FloorScale(FLOOR_HEIGHT).draw(canvas)
    if patch is not None:
        patch.draw(canvas)


def view(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    name: str,
    patch: SurfacePatch | None,
    overlay: Sequence[OverlayItem],
    aspect: float,
) -> mujoco.MjvCamera:
    """The camera of a name, as it stands for a state.

    Args:
        model: Model of the simulation.
        data: State to look at.
        name: Name of the camera, one of `CAMERAS`.
        patch: Elastic surface; None in a world without one.
        overlay: Overlay of the frame, whose paths the camera `task` includes.
        aspect: Width of the frame in parts of its height.
    """
    camera = mujoco.MjvCamera()
    if name in FIXED_CAMERAS:
        camera.type = int(mujoco.mjtCamera.mjCAMERA_FIXED)
        camera.fixedcamid = model.camera(name).id
    elif name == "task":
        Viewpoint.of_task(patch, overlay, aspect).set_camera(camera)
    elif patch is not None:
        Viewpoint.of_contact(patch, aspect).set_camera(camera)
    else:
        Viewpoint.of_tip(data.site("tip").xpos, aspect).set_camera(camera)
    return camera


def _without_plane() -> mujoco.MjvOption:
    """Options that hide the plane of the surface, of which a patch with an edge is drawn instead."""
    options = mujoco.MjvOption()
    options.geomgroup[SURFACE_GROUP] = 0
    return options


class OffscreenRenderer:
    """Renders colour and depth frames without a window.

    Renderers of the same size, world and thread share their OpenGL context; the last one that is closed
    frees its memory.

    Args:
        model: Model of the simulation to render; its offscreen buffer is made as large as the frame.
        width: Width of the frame [pixels].
        height: Height of the frame [pixels].
        camera: Name of the camera, one of `CAMERAS`.

    Raises:
        RenderingError: This machine provides no OpenGL context.
        UnknownNameError: There is no such camera.
        InvalidValueError: The size is not a whole number of pixels, or is out of bounds.
    """

    def __init__(self, model: mujoco.MjModel, width: int, height: int, camera: str) -> None:
        check_view(width, height, camera)
        self._camera, self._height, self._aspect = camera, height, width / height
        try:
            key, self._renderer = _POOL.borrow(model, width, height)
        except (RuntimeError, AttributeError, ImportError, mujoco.FatalError) as error:
            raise RenderingError(
                f"MuJoCo cannot create an OpenGL context on this machine ({error}). Without a display set"
                " MUJOCO_GL=egl (or osmesa) before mujoco is first imported, and install Mesa's EGL library"
                " (Debian: libegl1)."
            ) from error
        self._canvas = Canvas(self._renderer.model, self._renderer.scene, height)
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
        patch = SurfacePatch.of(self._renderer.model, data)
        camera = view(self._renderer.model, data, self._camera, patch, overlay, self._aspect)
        if depth:
            self._renderer.enable_depth_rendering()
            self._renderer.update_scene(data, camera)
        else:
            self._renderer.disable_depth_rendering()
            self._renderer.update_scene(data, camera, _without_plane())
            set_light(self._renderer.scene, self._height)
            add_overlay(self._canvas, patch, overlay)
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
        camera: Name of the camera, one of `CAMERAS`.
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
        self._camera: str | None = camera
        self._canvas = Canvas(model, self._viewer.user_scn, _WINDOW_HEIGHT)
        with self._viewer.lock():
            self._viewer.opt.geomgroup[SURFACE_GROUP] = 0

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
            patch = SurfacePatch.of(self._model, self._data)
            self._set_camera(patch, overlay)
            add_overlay(self._canvas, patch, overlay)
        self._viewer.sync()

    def _set_camera(self, patch: SurfacePatch | None, overlay: Sequence[OverlayItem]) -> None:
        """Set the camera in the first frame; afterwards the user moves it."""
        if self._camera is not None:
            set_to = view(self._model, self._data, self._camera, patch, overlay, _WINDOW_ASPECT)
            for name in ("type", "fixedcamid", "distance", "azimuth", "elevation"):
                setattr(self._viewer.cam, name, getattr(set_to, name))
            self._viewer.cam.lookat[:] = set_to.lookat
            self._camera = None

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
