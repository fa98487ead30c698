"""The cameras of the page, which also show the arm above the controls of a narrow screen."""

from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array

CAMERAS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "overview": ((1.35, -1.4, 1.05), (0.0, 0.0, 0.15)),
    "top": ((0.0, -0.01, 2.3), (0.0, 0.0, 0.1)),
    "side": ((0.0, -2.1, 0.35), (0.0, 0.0, 0.2)),
    "tip": ((0.45, -0.45, 0.35), (0.0, 0.0, 0.0)),
}
"""Position of the camera and the point at which it looks [m]; those of `tip` are relative to the tip."""

FIELD_OF_VIEW = 0.8
"""Vertical angle of the camera [rad]."""

_FARTHER = 1.3  # ratio of distances on a narrow screen
_LOWER = 0.18  # share of the distance by which the camera looks below the point there


def look(client: Any, name: str, tip: Array) -> None:
    """Move the camera of one browser.

    Args:
        client: viser's handle of the browser.
        name: one of `CAMERAS`.
        tip: tip position in the world frame (3) [m].
    """
    origin = tip if name == "tip" else np.zeros(3)
    position, point = (np.array(values) + origin for values in CAMERAS[name])
    if client.camera.aspect < 1.0:  # a phone: the controls cover the lower half of the screen
        position = point + _FARTHER * (position - point)
        sight = point - position
        up = (
            np.array([0.0, 0.0, 1.0])
            if abs(sight[2]) < np.hypot(sight[0], sight[1])
            else np.array([0.0, 1.0, 0.0])
        )
        point = point - _LOWER * float(np.linalg.norm(sight)) * up
    client.camera.position, client.camera.look_at = position, point
