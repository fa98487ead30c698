"""Model fields of the arm that may differ between simulations: surfaces, masses, friction."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from mujoco.batch import Batch

from prp_gym.errors import InvalidValueError
from prp_gym.physics.mjcf import TIP_RADIUS
from prp_gym.physics.model_fields import (
    Ids,
    ModelFields,
    check_dynamics,
    check_not_negative,
    check_positive,
    check_rows,
    rows_of,
)
from prp_gym.physics.surface import Surface, friction_reference, quaternions, solver_reference
from prp_gym.robot.arrays import Array, dot
from prp_gym.symbolic.row_function import RowFunction

_SPRINGS = "surface springs"


def contact_fields(
    springs: Array, weight: Array, normal: Array, offset: Array, center: Array
) -> Mapping[str, Array]:
    """Fields of MuJoCo's model for n surfaces, by name.

    Args:
        springs: Stiffness [N/m] and damping [N s/m] (n, 2).
        weight: `body_invweight0` (translation) of the tip's body (n) [1/kg].
        normal: Unit normals (n, 3).
        offset: Offsets along the normals (n) [m].
        center: Points that are projected onto the surfaces (n, 3) or (3) [m].
    """
    gap = offset - TIP_RADIUS - dot(normal, center)
    return {
        "pair_solref": solver_reference(springs[:, 0], springs[:, 1], weight),
        "pair_solreffriction": friction_reference(weight),
        "body_pos": center + gap[:, None] * normal,
        "body_quat": quaternions(normal),
    }


class ArmFields(ModelFields):
    """Fields of the arm's model that have a value for each simulation.

    Args:
        batch: Batch of simulations whose fields these are.
    """

    names: ClassVar[tuple[str, ...]] = (
        "body_mass",
        "body_inertia",
        "dof_damping",
        "dof_frictionloss",
        "body_pos",
        "body_quat",
        "pair_solref",
        "pair_solreffriction",
    )

    def __init__(self, batch: Batch) -> None:
        super().__init__(batch)
        model = batch.model
        names = {model.body(index).name: index for index in range(model.nbody)}
        self._links, self._surface = slice(names["link_1"], names["link_3"] + 1), names.get("surface")
        self._mass, self._inertia = model.body_mass[self._links], model.body_inertia[self._links]
        self._tip_body = names["link_3"]
        self._nominal_weight = model.body_invweight0[self._tip_body, 0]
        self._springs = np.full((batch.nsim, 2), np.nan)  # stiffness and damping of the surfaces set
        shapes: dict[str, tuple[int, ...]] = {"springs": (2,), "weight": (), "normal": (3,), "offset": ()}
        self._contact = RowFunction("prp_contact_fields", contact_fields, {**shapes, "center": (3,)})

    def set_surface(self, ids: Ids, surface: Surface, center: Array) -> None:
        """See `Physics.set_surface`; the patch is drawn where `center` (3) [m] projects onto the plane."""
        check_rows("surface", surface.normal, (len(ids), 3))
        rows = rows_of(ids, len(self._springs))
        self._springs[rows, 0], self._springs[rows, 1] = surface.stiffness, surface.damping
        springs, weight, plane = self._springs[rows], self._weight(rows), (surface.normal, surface.offset)
        fields = self._contact(
            springs=springs, weight=weight, normal=plane[0], offset=plane[1], center=center
        )
        for name in ("pair_solref", "pair_solreffriction"):
            self.batch.expand(name)[rows, 0] = fields[name]
        for name in ("body_pos", "body_quat"):
            self.batch.expand(name)[rows, self._surface] = fields[name]

    def set_springs(self, ids: Ids, stiffness: Array, damping: Array) -> None:
        """See `Physics.set_springs`."""
        self._require_surface(ids)
        check_positive("surface stiffness", stiffness, (len(ids),), "N/m")
        check_not_negative("surface damping", damping, (len(ids),), "N·s/m")
        self._springs[ids, 0], self._springs[ids, 1] = stiffness, damping
        self._calibrate(ids)

    def surface(self, simulation: int) -> Surface:
        """See `Physics.surface`."""
        self._require_surface(np.array([simulation]))
        center = self.batch.expand("body_pos")[simulation, self._surface]
        w, x, y, z = self.batch.expand("body_quat")[simulation, self._surface]
        normal = np.array([[2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]])
        stiffness, damping = self._springs[simulation : simulation + 1].T
        return Surface(stiffness, damping, normal, dot(normal, center) + TIP_RADIUS)

    def has_surface(self, simulation: int) -> bool:
        """Whether the surface of one simulation was set."""
        return not np.isnan(self._springs[simulation]).any()

    def _require_surface(self, ids: Ids) -> None:
        """Refuse simulations whose surface was never set, or that have none."""
        if np.isnan(self._springs[ids]).any():
            raise InvalidValueError("surface", "none", "a simulation whose surface was set")

    def set_dynamics(
        self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array
    ) -> None:
        """See `Physics.set_dynamics`."""
        check_dynamics(ids, mass_factor, viscous_friction, coulomb_friction)
        rows = rows_of(ids, len(self._springs))
        self.batch.expand("body_mass")[rows, self._links] = mass_factor * self._mass
        self.batch.expand("body_inertia")[rows, self._links] = mass_factor[:, :, None] * self._inertia
        self.batch.expand("dof_damping")[rows] = viscous_friction
        self.batch.expand("dof_frictionloss")[rows] = coulomb_friction
        self.batch.set_const(None if isinstance(rows, slice) else rows)
        self._calibrate(rows)

    def dynamics(self, simulation: int) -> tuple[Array, Array, Array]:
        """See `ArmSimulation.dynamics`."""
        mass = self.value("body_mass", simulation)[self._links]
        viscous, coulomb = self.value("dof_damping", simulation), self.value("dof_frictionloss", simulation)
        return (mass / self._mass)[None], viscous[None], coulomb[None]

    def _calibrate(self, rows: Ids | slice) -> None:
        """Recompute the contact parameters, so that the springs keep their values when masses change."""
        if self._surface is None:
            return
        springs = self._springs[rows]
        if np.count_nonzero(np.isnan(springs)):  # some surfaces were never set
            rows = np.arange(len(self._springs))[rows][~np.isnan(springs[:, 0])]
            springs = self._springs[rows]
        weight = self._weight(rows)
        self.batch.expand("pair_solref")[rows, 0] = solver_reference(springs[:, 0], springs[:, 1], weight)
        self.batch.expand("pair_solreffriction")[rows, 0] = friction_reference(weight)

    def _weight(self, rows: Ids | slice) -> Array:
        """`body_invweight0` (translation) (n) of the tip's bodies [1/kg]."""
        own = self.batch.expanded("body_invweight0")
        if own is None:
            return np.full(len(self._springs[rows]), self._nominal_weight)
        weight: Array = own[rows, self._tip_body, 0]
        return weight

    def copy(self) -> dict[str, Array]:
        """Values of all fields that differ, by name, and of the springs."""
        return {**super().copy(), _SPRINGS: self._springs.copy()}

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Restore the values that `copy` returned."""
        self._springs[:] = kept[_SPRINGS]
        super().restore(kept)
