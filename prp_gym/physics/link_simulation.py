"""`LinkPhysics`: simulations of the one-joint link."""

from typing import ClassVar

import mujoco
import numpy as np
from mujoco.batch import Batch

from prp_gym.physics.abstract_simulation import LinkSimulation
from prp_gym.physics.batch_simulation import BatchSimulation
from prp_gym.physics.link_fields import LinkFields
from prp_gym.physics.link_mjcf import link_to_mjcf
from prp_gym.physics.model_fields import Ids
from prp_gym.physics.scene import check_timestep, compile_mjcf
from prp_gym.physics.sensor_layout import NO_COLUMNS, SensorLayout
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import NOMINAL_LINK, LinkParameters


class LinkPhysics(BatchSimulation, LinkSimulation):
    """N simulations of the link I q̈ + F q̇ + G sin q = τ, without joint stops.

    `measurement` has the columns joint position [rad] and joint velocity [rad/s]; torques are in [N m].
    The integrator is semi-implicit Euler, implicit in the friction. With the time step h,
    (I + h F) q̇' = I q̇ + h (τ - G sin q) and then q' = q + h q̇'.

    Args:
        parameters: Parameters of the simulated link (the plant).
        timestep: Time step of the integration [s].
        num_simulations: Number of simulations N, at least 1.
        num_threads: Number of worker threads; 0 uses all cores.

    Raises:
        InvalidValueError: a timestep that is not positive, fewer than one simulation.

    Source: [R] 8.1; [M] Computation, Numerical integration.
    """

    joint_count: ClassVar[int] = 1
    _constructor_attributes: ClassVar[tuple[str, ...]] = ("parameters", "_timestep")
    _fields: LinkFields

    def __init__(
        self,
        parameters: LinkParameters = NOMINAL_LINK,
        timestep: float = 0.001,
        num_simulations: int = 1,
        num_threads: int = 1,
    ) -> None:
        self.parameters = parameters
        self._timestep = check_timestep(timestep)
        super().__init__(num_simulations, num_threads)

    def _compile(self) -> mujoco.MjModel:
        return compile_mjcf(link_to_mjcf(self.parameters, self._timestep))

    def _make_fields(self, batch: Batch) -> LinkFields:
        return LinkFields(batch)

    def _sensor_layout(self) -> SensorLayout:
        return SensorLayout(
            gain=np.ones(2),
            offset=np.zeros(2),
            tip_position=slice(2, 5),
            contact_force=NO_COLUMNS,
            stop_violation=NO_COLUMNS,
        )

    def set_parameters(
        self, ids: Ids, inertia: Array, viscous_friction: Array, gravity_moment: Array
    ) -> None:
        """See `LinkSimulation.set_parameters`."""
        self._fields.set_parameters(ids, inertia, viscous_friction, gravity_moment)

    def parameters_of(self, simulation: int) -> tuple[Array, Array, Array]:
        """See `LinkSimulation.parameters_of`."""
        return self._fields.parameters_of(simulation)
