"""How finely a frame is drawn, and its light: a lamp with an extent, so that shadows have soft edges."""

import mujoco
import numpy as np

from prp_gym.drawing.canvas import FINE

_SPREAD = 0.018  # [rad] of the lamp, as seen from the robot
_LAMPS = 4
_OF_A_LAMP = (
    *("id", "pos", "dir", "type", "texid", "attenuation", "cutoff", "exponent", "ambient", "diffuse"),
    *("specular", "headlight", "castshadow", "bulbradius", "intensity", "range", "softness"),
)
_SOFT = 600  # height of a frame from which on shadows have soft edges [pixels]


def set_quality(model: mujoco.MjModel, height: int) -> None:
    """Set how finely a model's shapes and shadows are drawn; small frames have plain shapes and no shadows.

    Args:
        model: Model for a renderer of its own.
        height: Height of the frame [pixels].
    """
    quality = model.vis.quality
    slices, stacks, shadow = (32, 14, 2048) if height >= FINE else (10, 4, 0)
    quality.numslices, quality.numstacks, quality.shadowsize = slices, stacks, shadow


def set_light(scene: mujoco.MjvScene, height: int) -> None:
    """Replace the lamp that casts shadows by several beside each other in large frames.

    Small frames have no shadows, and those between have a lamp without extent.

    Args:
        scene: Scene of a frame, just updated.
        height: Height of the frame [pixels].
    """
    scene.flags[int(mujoco.mjtRndFlag.mjRND_SHADOW)] = height >= FINE
    lamps = [index for index in range(scene.nlight) if scene.lights[index].castshadow]
    if height < _SOFT or len(lamps) != 1:
        return
    lamp = scene.lights[lamps[0]]
    middle = np.array(lamp.dir, dtype=np.float64)
    across = np.cross(middle, (1.0, 0.0, 0.0))
    across /= np.sqrt(across @ across)
    diffuse, specular = np.array(lamp.diffuse) / _LAMPS, np.array(lamp.specular) / _LAMPS
    for number in range(_LAMPS):
        angle = 2.0 * np.pi * number / _LAMPS
        turned = np.cos(angle) * across + np.sin(angle) * np.cross(middle, across)
        own = lamp if number == 0 else _copy_of(scene, lamp)
        own.dir = middle + _SPREAD * turned
        own.diffuse, own.specular = diffuse, specular


def _copy_of(scene: mujoco.MjvScene, lamp: mujoco.MjvLight) -> mujoco.MjvLight:
    """A further lamp of a scene, like another."""
    own = scene.lights[scene.nlight]
    scene.nlight += 1
    for name in _OF_A_LAMP:
        setattr(own, name, getattr(lamp, name))
    return own
