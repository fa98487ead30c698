"""`Physics`: simulations of the arm, with or without an elastic surface."""

from typing import ClassVar

import mujoco
import numpy as np
from mujoco.batch import Batch

from prp_gym.errors import InvalidValueError
from prp_gym.physics.abstract_simulation import ArmSimulation, PhysicsState
from prp_gym.physics.arm_fields import ArmFields
from prp_gym.physics.batch_simulation import BatchSimulation
from prp_gym.physics.mjcf import PhysicsSettings, compile_model
from prp_gym.physics.model_fields import Ids
from prp_gym.physics.sensor_layout import NO_COLUMNS, SensorLayout
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.robot.kinematics import Kinematics
from prp_gym.robot.parameters import NOMINAL, RobotParameters

__all__ = ["MEASUREMENT_SIZE", "Physics", "PhysicsState"]

# From the 18 sensor values to joint state, pose and pose rate: α = q_1, β = π/2 - q_3, γ = π/2.
_KINEMATIC_GAIN = np.array([1.0] * 6 + [1.0] * 4 + [-1.0, 0.0] + [1.0] * 4 + [-1.0, 0.0])
_KINEMATIC_OFFSET = np.array([0.0] * 10 + [np.pi / 2, np.pi / 2] + [0.0] * 6)

MEASUREMENT_SIZE = 18
"""Number of columns of the measurement in every world of the arm: joint state, pose and pose rate."""

_TIP_POSITION, _TIP_VELOCITY = slice(6, 9), slice(12, 15)
_AFTER_FORCE = MEASUREMENT_SIZE + 3


class Physics(BatchSimulation, ArmSimulation):
    """N simulations of the arm.

    `measurement` has the columns joint position (3), joint velocity (3), pose (6), pose rate (6), and in
    a world with a surface contact force (3); units are [rad, m, rad] for joints, [m] and [rad] for poses,
    each per second for rates, [N m, N, N m] for torques and [N] for forces.

    Args:
        parameters: Parameters of the simulated arm (the plant).
        settings: Settings of the world.
        num_simulations: Number of simulations N, at least 1.
        num_threads: Number of worker threads; 0 uses all cores.

    Raises:
        InvalidValueError: fewer than one simulation.
    """

    joint_count: ClassVar[int] = 3
    _constructor_attributes: ClassVar[tuple[str, ...]] = ("parameters", "settings")
    _fields: ArmFields

    def __init__(
        self,
        parameters: RobotParameters = NOMINAL,
        settings: PhysicsSettings | None = None,
        num_simulations: int = 1,
        num_threads: int = 1,
    ) -> None:
        self.parameters = parameters
        self.settings = PhysicsSettings() if settings is None else settings
        super().__init__(num_simulations, num_threads)

    def _build(self) -> None:
        super()._build()
        self._tip_velocity = self._sensors[:, _TIP_VELOCITY]
        self._home_tip = Kinematics(self.parameters).forward_kinematics(np.zeros(3))[:3]

    def _compile(self) -> mujoco.MjModel:
        return compile_model(self.parameters, self.settings)

    def _make_fields(self, batch: Batch) -> ArmFields:
        return ArmFields(batch)

    def _sensor_layout(self) -> SensorLayout:
        measured = _AFTER_FORCE if self.settings.surface else MEASUREMENT_SIZE
        extra = measured - MEASUREMENT_SIZE
        return SensorLayout(
            gain=np.concatenate([_KINEMATIC_GAIN, np.ones(extra)]),
            offset=np.concatenate([_KINEMATIC_OFFSET, np.zeros(extra)]),
            tip_position=_TIP_POSITION,
            contact_force=slice(MEASUREMENT_SIZE, _AFTER_FORCE) if self.settings.surface else NO_COLUMNS,
            stop_violation=slice(measured, measured + 3) if self.settings.joint_stops else NO_COLUMNS,
        )

    @property
    def tip_velocity(self) -> Array:
        """See `ArmSimulation.tip_velocity`."""
        return self._tip_velocity

    def set_surface(self, ids: Ids, surface: Surface, center: Array | None = None) -> None:
        """See `ArmSimulation.set_surface`."""
        if not self.settings.surface:
            raise InvalidValueError("surface", "given", "nothing: this world was built without a surface")
        self._fields.set_surface(ids, surface, self._home_tip if center is None else center)

    def set_springs(self, ids: Ids, stiffness: Array, damping: Array) -> None:
        """See `ArmSimulation.set_springs`."""
        self._fields.set_springs(ids, stiffness, damping)

    def surface(self, simulation: int = 0) -> Surface:
        """See `ArmSimulation.surface`."""
        return self._fields.surface(simulation)

    def set_dynamics(
        self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array
    ) -> None:
        """See `ArmSimulation.set_dynamics`."""
        self._fields.set_dynamics(ids, mass_factor, viscous_friction, coulomb_friction)

    def has_surface(self, simulation: int = 0) -> bool:
        """See `ArmSimulation.has_surface`."""
        return self._fields.has_surface(simulation)

    def dynamics(self, simulation: int = 0) -> tuple[Array, Array, Array]:
        """See `ArmSimulation.dynamics`."""
        return self._fields.dynamics(simulation)
