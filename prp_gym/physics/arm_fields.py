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
)
from prp_gym.physics.surface import Surface, friction_reference, solver_reference
from prp_gym.robot.arrays import Array, dot

_SPRINGS = "surface springs"


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
        self._links = [batch.model.body(f"link_{i}").id for i in (1, 2, 3)]
        self._springs = np.full(
            (batch.nsim, 2), np.nan
        )  # stiffness and damping of the surfaces that were set

    def set_surface(self, ids: Ids, surface: Surface, center: Array) -> None:
        """See `Physics.set_surface`; the patch is drawn where `center` (3) [m] projects onto the plane."""
        check_rows("surface", surface.normal, (len(ids), 3))
        self._springs[ids] = np.stack([surface.stiffness, surface.damping], axis=-1)
        self._calibrate(ids)
        gap = surface.offset - TIP_RADIUS - dot(surface.normal, center)
        body = self.batch.model.body("surface").id
        self.batch.expand("body_pos")[ids, body] = center + gap[:, None] * surface.normal
        self.batch.expand("body_quat")[ids, body] = surface.quaternions()

    def set_springs(self, ids: Ids, stiffness: Array, damping: Array) -> None:
        """See `Physics.set_springs`."""
        self._require_surface(ids)
        check_positive("surface stiffness", stiffness, (len(ids),), "N/m")
        check_not_negative("surface damping", damping, (len(ids),), "N·s/m")
        self._springs[ids] = np.stack([stiffness, damping], axis=-1)
        self._calibrate(ids)

    def surface(self, simulation: int) -> Surface:
        """See `Physics.surface`."""
        self._require_surface(np.array([simulation]))
        body = self.batch.model.body("surface").id
        center = self.batch.expand("body_pos")[simulation, body]
        w, x, y, z = self.batch.expand("body_quat")[simulation, body]
        normal = np.array([[2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]])
        stiffness, damping = self._springs[simulation : simulation + 1].T
        return Surface(stiffness, damping, normal, dot(normal, center) + TIP_RADIUS)

    def _require_surface(self, ids: Ids) -> None:
        """Refuse simulations whose surface was never set, or that have none."""
        if np.isnan(self._springs[ids]).any():
            raise InvalidValueError("surface", "none", "a simulation whose surface was set")

    def set_dynamics(
        self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array
    ) -> None:
        """See `Physics.set_dynamics`."""
        check_dynamics(ids, mass_factor, viscous_friction, coulomb_friction)
        model, rows = self.batch.model, np.asarray(ids)[:, None]
        inertia = mass_factor[:, :, None] * model.body_inertia[self._links]
        self.batch.expand("body_mass")[rows, self._links] = mass_factor * model.body_mass[self._links]
        self.batch.expand("body_inertia")[rows, self._links] = inertia
        self.batch.expand("dof_damping")[ids] = viscous_friction
        self.batch.expand("dof_frictionloss")[ids] = coulomb_friction
        self.batch.set_const(ids)
        self._calibrate(ids[~np.isnan(self._springs[ids, 0])])

    def _calibrate(self, ids: Ids) -> None:
        """Recompute the contact parameters, so that the springs keep their values when masses change."""
        if len(ids) == 0:
            return
        weight = self._inverse_weight(ids)
        stiffness, damping = self._springs[ids].T
        self.batch.expand("pair_solref")[ids, 0] = solver_reference(stiffness, damping, weight)
        self.batch.expand("pair_solreffriction")[ids, 0] = friction_reference(weight)

    def _inverse_weight(self, ids: Ids) -> Array:
        """(n) `body_invweight0` (translation) of the tip's body [1/kg]."""
        tip_body = self._links[-1]
        own = self.batch.expanded("body_invweight0")
        if own is None:
            return np.full(len(ids), self.batch.model.body_invweight0[tip_body, 0])
        return np.array(own[ids, tip_body, 0])

    def copy(self) -> dict[str, Array]:
        """Values of all fields that differ, by name, and of the springs."""
        return {**super().copy(), _SPRINGS: self._springs.copy()}

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Restore the values that `copy` returned."""
        self._springs[:] = kept[_SPRINGS]
        super().restore(kept)
