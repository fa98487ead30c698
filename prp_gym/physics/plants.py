"""`Plants`: masses and friction of N arms, as the closed form takes them."""

from collections.abc import Mapping
from dataclasses import astuple

import numpy as np

from prp_gym.physics.closed_form import PlantArm
from prp_gym.physics.compiled_arm_source import PLANT, PLANT_SIZE
from prp_gym.physics.model_fields import Ids, check_dynamics
from prp_gym.robot.arrays import Array, dot, solve_symmetric
from prp_gym.robot.dynamics import BaseParameters
from prp_gym.robot.parameters import NOMINAL, RobotParameters

_DYNAMICS = "dynamics"


class Plants:
    """The plants of N simulations of the nominal arm with other masses and friction.

    Args:
        count: Number of simulations N.

    Attributes:
        rows: Plants (N, `PLANT_SIZE`), with the columns of `PLANT`.
    """

    def __init__(self, count: int) -> None:
        self.rows = np.zeros((count, PLANT_SIZE))
        self._dynamics = np.zeros((count, 9))  # mass factors, viscous and Coulomb friction
        nominal = np.ones(3), np.array(NOMINAL.viscous_friction), np.array(NOMINAL.coulomb_friction)
        self.set(np.arange(count), *(np.tile(value, (count, 1)) for value in nominal))

    @property
    def have_coulomb_friction(self) -> bool:
        """Whether a joint of any simulation has Coulomb friction."""
        return bool(np.count_nonzero(self.rows[:, PLANT["coulomb_friction"]]))

    def set(self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array) -> None:
        """See `ArmSimulation.set_dynamics`."""
        check_dynamics(ids, mass_factor, viscous_friction, coulomb_friction)
        self._dynamics[ids] = np.concatenate([mass_factor, viscous_friction, coulomb_friction], axis=-1)
        base = base_parameters(NOMINAL, mass_factor)
        weights = inverse_weights(PlantArm(base, viscous_friction))
        columns = (np.stack(astuple(base), axis=-1), viscous_friction, *weights, coulomb_friction)
        self.rows[ids] = np.concatenate(columns, axis=-1)

    def dynamics(self, simulation: int) -> tuple[Array, Array, Array]:
        """Mass factors, viscous and Coulomb friction (1, 3) of one simulation."""
        factor, viscous, coulomb = np.split(self._dynamics[simulation : simulation + 1], 3, axis=-1)
        return factor, viscous, coulomb

    def copy(self) -> dict[str, Array]:
        """The plants, by name."""
        return {_DYNAMICS: self._dynamics.copy()}

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Restore what `copy` returned."""
        self.set(np.arange(len(self.rows)), *np.split(kept[_DYNAMICS], 3, axis=-1))


def base_parameters(parameters: RobotParameters, mass_factor: Array) -> BaseParameters:
    """The base parameters of arms whose links are heavier by factors (n, 3), arrays (n) each."""
    links = list(zip(mass_factor.T, parameters.link_mass, parameters.link_inertia, strict=True))
    masses = [factor * mass for factor, mass, _ in links]
    inertias = [[factor * moment for moment in moments] for factor, _, moments in links]
    return BaseParameters.of_links(parameters.geometry, masses, inertias)


def inverse_weights(arm: PlantArm) -> tuple[Array, Array]:
    """MuJoCo's `dof_invweight0` (n, 3) and that of the third link's translation (n, 1).

    Source: [M] Computation, Solver parameters: diag B⁻¹, and the mean of diag J B⁻¹Jᵀ with the Jacobian J of
        the link's centre of mass, at q = 0.
    """
    geometry = arm.parameters.geometry
    B = arm.inertia_matrix(np.zeros((np.size(arm.base_parameters.first_axis), 3)))
    inverse = np.stack([solve_symmetric(B, column + np.zeros(B.shape[:-1])) for column in np.eye(3)], axis=-1)
    reach, a_1 = geometry.slide_offset + geometry.third_link_center_of_mass, geometry.first_link_offset
    J = np.array([[reach, 0.0, 0.0], [a_1, -1.0, 0.0], [0.0, 0.0, geometry.third_link_center_of_mass]])
    spread = [dot(row, np.stack([dot(inverse[..., i, :], row) for i in range(3)], axis=-1)) for row in J]
    mean = (spread[0] + spread[1] + spread[2]) / 3.0
    return np.stack([inverse[..., i, i] for i in range(3)], axis=-1), mean[..., None]
