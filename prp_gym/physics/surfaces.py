"""`Surfaces`: the elastic surfaces of N simulations, as the closed form takes them."""

from collections.abc import Mapping

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.physics.compiled_arm_source import SURFACE, SURFACE_SIZE
from prp_gym.physics.model_fields import Ids, check_not_negative, check_positive, check_rows
from prp_gym.physics.surface import Surface
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, dot, zeros
from prp_gym.symbolic.row_function import RowFunction

_ROWS, _CENTERS, _OFFSETS = "surfaces", "surface centers", "surface offsets"


def surface_rows(
    stiffness: Array, damping: Array, normal: Array, offset: Array, center: Array
) -> Mapping[str, Array]:
    """The columns `SURFACE` of n surfaces that are at rest, as `rows` (n, `SURFACE_SIZE`).

    Args:
        stiffness: Stiffness (n) [N/m].
        damping: Damping (n) [N s/m].
        normal: Unit normals (n, 3).
        offset: Offsets along the normals (n) [m].
        center: Points that are projected onto the surfaces (n, 3) [m].
    """
    gap = offset - dot(normal, center)
    springs, point = np.stack([stiffness, damping], axis=-1), center + gap[:, None] * normal
    return {"rows": np.concatenate([springs, point, zeros(point.shape, point), normal], axis=-1)}


class Surfaces:
    """The surfaces of N simulations; one that was never set is far away.

    Args:
        count: Number of simulations N.

    Attributes:
        rows: Surfaces (N, `SURFACE_SIZE`), with the columns of `SURFACE`.
    """

    def __init__(self, count: int) -> None:
        self.rows = np.zeros((count, SURFACE_SIZE))
        self.rows[:, SURFACE["normal"]] = (0.0, 0.0, 1.0)
        self.rows[:, SURFACE["point"]] = (0.0, 0.0, -1e6)
        self._home_tip = PRPArm().forward_kinematics(np.zeros(3))[:3]
        self._centers = np.tile(self._home_tip, (count, 1))
        self._offsets = np.full(count, np.nan)
        shapes: dict[str, tuple[int, ...]] = {"stiffness": (), "damping": (), "normal": (3,), "offset": ()}
        self._make_rows = RowFunction("prp_surface_rows", surface_rows, {**shapes, "center": (3,)})

    def set(self, ids: Ids, surface: Surface, center: Array | None) -> None:
        """See `ArmSimulation.set_surface`."""
        check_rows("surface", surface.normal, (len(ids), 3))
        self._centers[ids] = self._home_tip if center is None else center
        self._offsets[ids] = surface.offset
        self.rows[ids] = self._make_rows(**vars(surface), center=self._centers[ids])["rows"]

    def set_springs(self, ids: Ids, stiffness: Array, damping: Array) -> None:
        """See `ArmSimulation.set_springs`."""
        if np.isnan(self._offsets[ids]).any():
            raise InvalidValueError("surface", "none", "a simulation whose surface was set")
        check_positive("surface stiffness", stiffness, (len(ids),), "N/m")
        check_not_negative("surface damping", damping, (len(ids),), "N·s/m")
        self.rows[ids, 0], self.rows[ids, 1] = stiffness, damping

    def is_set(self, simulation: int) -> bool:
        """Whether a simulation's surface was set."""
        return not np.isnan(self._offsets[simulation])

    def center(self, simulation: int) -> Array:
        """Where the patch of a surface is drawn (1, 3) [m]."""
        return self._centers[simulation : simulation + 1]

    def surface(self, simulation: int) -> Surface:
        """See `ArmSimulation.surface`."""
        if not self.is_set(simulation):
            raise InvalidValueError("surface", "none", "a simulation whose surface was set")
        row = self.rows[simulation : simulation + 1]
        offset = self._offsets[simulation : simulation + 1].copy()
        return Surface(row[:, 0].copy(), row[:, 1].copy(), row[:, SURFACE["normal"]].copy(), offset)

    def copy(self) -> dict[str, Array]:
        """The surfaces, by name."""
        return {
            _ROWS: self.rows.copy(),
            _CENTERS: self._centers.copy(),
            _OFFSETS: self._offsets.copy(),
        }

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Restore what `copy` returned."""
        self.rows[:], self._centers[:], self._offsets[:] = kept[_ROWS], kept[_CENTERS], kept[_OFFSETS]
