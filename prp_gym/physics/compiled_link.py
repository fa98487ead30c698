"""`CompiledLink`: simulations of the one-joint link in closed form, in code compiled from the formulas."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from prp_gym.physics.abstract_simulation import LinkSimulation
from prp_gym.physics.compiled_link_source import link_source
from prp_gym.physics.compiled_simulation import CompiledSimulation
from prp_gym.physics.derivatives_source import link_derivatives_source
from prp_gym.physics.link_mjcf import HINGE_HEIGHT, LINK_LENGTH
from prp_gym.physics.link_simulation import LinkPhysics
from prp_gym.physics.model_fields import Ids, check_link
from prp_gym.physics.scene import check_timestep
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import NOMINAL_LINK

_PLANTS = "plants"


class CompiledLink(CompiledSimulation, LinkSimulation):
    """N simulations of the link in closed form, with the columns and units of `LinkPhysics`.

    Args:
        timestep: Time step of the integration [s].
        num_simulations: Number of simulations N, at least 1.
        num_threads: Number of worker threads; 0 uses all cores.

    Raises:
        InvalidValueError: a timestep that is not positive, fewer than one simulation.
        CompilerError: this machine has neither the compiled code nor a compiler.
    """

    joint_count: ClassVar[int] = 1

    def __init__(self, timestep: float = 0.001, num_simulations: int = 1, num_threads: int = 1) -> None:
        self._timestep = check_timestep(timestep)
        super().__init__(link_source(self._timestep), 2, num_simulations, num_threads)
        nominal = NOMINAL_LINK.inertia, NOMINAL_LINK.viscous_friction, NOMINAL_LINK.gravity_moment
        self._plants = np.tile(np.array(nominal), (num_simulations, 1))
        self._begin(self._plants, np.zeros((num_simulations, 1)))

    @property
    def timestep(self) -> float:
        """See `Simulation.timestep`."""
        return self._timestep

    @property
    def tip_position(self) -> Array:
        """See `Simulation.tip_position`; the link swings in the plane y = 0 and hangs down at q = 0."""
        q = self._position[:, 0]
        across, down = LINK_LENGTH * np.sin(q), LINK_LENGTH * np.cos(q)
        return np.stack([across, np.zeros_like(q), HINGE_HEIGHT - down], axis=-1)

    @property
    def contact_force(self) -> Array:
        """See `Simulation.contact_force`: there is none."""
        return self._no_force

    def set_parameters(
        self, ids: Ids, inertia: Array, viscous_friction: Array, gravity_moment: Array
    ) -> None:
        """See `LinkSimulation.set_parameters`."""
        check_link(ids, inertia, viscous_friction, gravity_moment)
        self._plants[ids] = np.stack([inertia, viscous_friction, gravity_moment], axis=-1)

    def parameters_of(self, simulation: int) -> tuple[Array, Array, Array]:
        """See `LinkSimulation.parameters_of`."""
        inertia, viscous_friction, gravity_moment = self._plants[simulation : simulation + 1].T.copy()
        return inertia, viscous_friction, gravity_moment

    @property
    def derivatives_source(self) -> str:
        """See `CompiledSimulation.derivatives_source`."""
        return link_derivatives_source(self._timestep)

    def in_mujoco(self, simulation: int) -> LinkPhysics:
        """See `CompiledSimulation.in_mujoco`."""
        physics, row = LinkPhysics(timestep=self._timestep), np.zeros(1, dtype=np.intp)
        one = slice(simulation, simulation + 1)
        physics.set_parameters(row, *self._plants[one].T)
        physics.reset(row, self._position[one], self._velocity[one])
        physics.set_torque(self._torque[one])
        return physics

    def _fields(self) -> dict[str, Array]:
        return {_PLANTS: self._plants.copy()}

    def _restore_fields(self, kept: Mapping[str, Array]) -> None:
        self._plants[:] = kept[_PLANTS]

    def _arguments(self) -> tuple[Any, ...]:
        return self._timestep, self.num_simulations, self.num_threads
