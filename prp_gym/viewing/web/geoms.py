"""The geoms of a MuJoCo model as nodes of a scene, each under the frame of its body."""

from typing import Any

import mujoco
import numpy as np

from prp_gym.robot.arrays import Array

_LARGEST_GROUP = 2  # of the geoms that MuJoCo's own viewers draw
_THIN = 0.004  # m, thickness of a plane that is drawn as a plate
_GHOST_OPACITY = 0.25
_LARGE = 1.0  # m, half side from which a plane counts as the floor

_Type = mujoco.mjtGeom


def add_geoms(
    scene: Any, model: mujoco.MjModel, folder: str = "/bodies", ghost: tuple[int, int, int] | None = None
) -> dict[str, Any]:
    """Add the geoms of a model to a scene.

    Args:
        scene: viser's scene.
        model: model of the simulation.
        folder: node of the scene to which the bodies are added.
        ghost: colour of a ghost: the moving bodies alone, translucent; None for all as they are.

    Returns:
        frames that are to be moved with the bodies, by the names of the bodies.
    """
    frames: dict[str, Any] = {}
    for index in range(model.ngeom):
        color, opacity = _colour(model, index)
        number = model.geom_bodyid[index]
        left_out = ghost is not None and model.body_weldid[number] == 0  # what does not move is there already
        if model.geom_group[index] > _LARGEST_GROUP or opacity == 0.0 or left_out:
            continue
        body = str(model.body(number).name)
        if body not in frames:
            frames[body] = scene.add_frame(f"{folder}/{body}", show_axes=False)
        look = (color, opacity) if ghost is None else (ghost, _GHOST_OPACITY)
        _add(scene, model, index, f"{folder}/{body}/{index}", *look)
    return frames


def _add(
    scene: Any, model: mujoco.MjModel, index: int, name: str, color: tuple[int, int, int], opacity: float
) -> None:
    """Add one geom under its body; kinds that the arm does not have are left out."""
    kind, size = int(model.geom_type[index]), np.array(model.geom_size[index], dtype=float)
    pose = {"position": np.array(model.geom_pos[index]), "wxyz": np.array(model.geom_quat[index])}
    look = {"opacity": None if opacity == 1.0 else opacity, **pose}
    if kind == int(_Type.mjGEOM_PLANE):
        _add_plane(scene, name, size, color, look)
    elif kind == int(_Type.mjGEOM_BOX):
        scene.add_box(name, color, dimensions=tuple(2.0 * size), **look)
    elif kind == int(_Type.mjGEOM_SPHERE):
        scene.add_icosphere(name, float(size[0]), color, **look)
    elif kind == int(_Type.mjGEOM_ELLIPSOID):
        scene.add_icosphere(name, 1.0, color, scale=tuple(size.tolist()), **look)
    elif kind in (int(_Type.mjGEOM_CYLINDER), int(_Type.mjGEOM_CAPSULE)):
        scene.add_cylinder(name, float(size[0]), 2.0 * float(size[1]), color, **look)


def _add_plane(scene: Any, name: str, size: Array, color: tuple[int, int, int], look: dict[str, Any]) -> None:
    """A small plane as a plate below its front, and a large one as a floor with a scale of 10 cm."""
    if size[0] >= _LARGE or size[0] == 0.0:
        scene.add_grid(
            name,
            width=3.0,
            height=3.0,
            cell_size=0.1,
            section_size=0.5,
            plane_color=(235, 235, 235),
            plane_opacity=1.0,
            position=look["position"],
            wxyz=look["wxyz"],
        )
        return
    scene.add_box(name, color, dimensions=(2.0 * size[0], 2.0 * size[1], _THIN), **look)


def _colour(model: mujoco.MjModel, index: int) -> tuple[tuple[int, int, int], float]:
    """Colour and opacity of a geom, those of its material if it has one."""
    material = int(model.geom_matid[index])
    rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[index]
    red, green, blue = (round(255 * float(value)) for value in rgba[:3])
    return (red, green, blue), float(rgba[3])
