"""`RendererPool`: one OpenGL context for all frames of the same size, world and thread."""

import copy
import ctypes
import hashlib
import threading
from collections.abc import Hashable
from dataclasses import dataclass

import mujoco
import numpy as np

from prp_gym.drawing.light import set_quality

MOST_GEOMS = 2500
"""Number of shapes that a scene holds, those of the model included."""

_NOT_DRAWN = ("body_", "dof_", "pair_sol", "actuator_acc0", "cam_poscom0", "light_poscom0")
# masses and what MuJoCo computes from them, friction, and poses, which come from the data


@dataclass
class SharedRenderer:
    """A renderer and the number of those who use it.

    Attributes:
        renderer: MuJoCo's renderer, with a context that takes about 40 MB where the CPU draws.
        users: number of users who have not given it back.
    """

    renderer: mujoco.Renderer
    users: int = 0


_LARGE_FONT = 480  # height of a frame from which on its labels are large [pixels]
_SMALL = mujoco.mjtFontScale.mjFONTSCALE_100


class RendererPool:
    """Renderers that are shared by all who draw frames of the same size, of equal worlds, in one thread."""

    def __init__(self) -> None:
        self._open: dict[Hashable, SharedRenderer] = {}

    def borrow(self, model: mujoco.MjModel, width: int, height: int) -> tuple[Hashable, mujoco.Renderer]:
        """A renderer, and the key under which it is given back.

        Args:
            model: model of the world; its quality and its offscreen buffer are set for the frames.
            width: width of the frames [pixels].
            height: height of the frames [pixels].
        """
        set_quality(model, height)
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        key = (threading.current_thread(), width, height, _digest(model))
        if key not in self._open:
            font = mujoco.mjtFontScale.mjFONTSCALE_150 if height >= _LARGE_FONT else _SMALL
            renderer = mujoco.Renderer(model, height, width, max_geom=MOST_GEOMS, font_scale=font)
            self._open[key] = SharedRenderer(renderer)
        self._open[key].users += 1
        return key, self._open[key].renderer

    def give_back(self, key: Hashable) -> None:
        """End a use of the renderer under a key; the last one frees its memory."""
        shared = self._open[key]
        shared.users -= 1
        if not shared.users:
            del self._open[key]
            shared.renderer.close()
            _return_memory()


def _digest(model: mujoco.MjModel) -> bytes:
    """Digest of everything in a model that frames depend on."""
    drawn = copy.copy(model)
    for name in dir(drawn):
        if name.startswith(_NOT_DRAWN) and isinstance(getattr(drawn, name), np.ndarray):
            getattr(drawn, name)[...] = 0
    drawn.stat.meanmass = drawn.stat.meaninertia = 0.0
    content = np.empty(mujoco.mj_sizeModel(drawn), dtype=np.uint8)
    mujoco.mj_saveModel(drawn, None, content)
    return hashlib.sha256(content.tobytes()).digest()


def _return_memory() -> None:
    """Return freed memory to the system, of which glibc would keep what software rendering has used."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
