"""The arm as the world of a task, and the checks of its initial states."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, JointLimitError
from prp_gym.physics.abstract_simulation import ArmSimulation, Simulation
from prp_gym.physics.engines import make_arm
from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import JOINT_UNITS, NOMINAL
from prp_gym.tasks.fields import SPEED_BOUND
from prp_gym.tasks.parts import ResetOption, StartT, World
from prp_gym.tasks.scenario import PlantDraw
from prp_gym.tasks.setup import TaskSetup

_ROUNDING = 1e-6  # [rad] or [m]: spares limits in single precision and sums that end on a limit

ARM_OPTIONS = {
    "joint_position": ResetOption((3,), "rad, m, rad", "initial joint position"),
    "joint_velocity": ResetOption((3,), "rad/s, m/s, rad/s", "initial joint velocity"),
    "goal": ResetOption((3,), "rad, m, rad", "joint position at the goal"),
}


def check_joint_limits(arm: PRPArm, what: str, joint_position: Array) -> None:
    """Refuse joint positions (..., 3) [rad, m, rad] outside the joint limits.

    Raises:
        JointLimitError: a joint is outside its limits; the first such joint is named.
    """
    low, high = arm.joint_limits
    outside = (joint_position < low - _ROUNDING) | (joint_position > high + _ROUNDING)
    if np.count_nonzero(outside):
        index = tuple(np.argwhere(outside)[0].tolist())
        joint = index[-1]
        limits = (float(low[joint]), float(high[joint]))
        raise JointLimitError(what, joint + 1, float(joint_position[index]), limits, JOINT_UNITS[joint])


def checked_start(arm: PRPArm, position: Array, options: Mapping[str, Array]) -> tuple[Array, Array]:
    """The initial joint positions and velocities (n, 3), where reset options replace drawn values.

    Args:
        arm: Nominal arm.
        position: Drawn joint positions (n, 3) [rad, m, rad].
        options: Validated reset options (n, 3) by name.

    Raises:
        JointLimitError: a position outside the joint limits.
        InvalidValueError: a velocity beyond the declared bounds.
    """
    position = options.get("joint_position", position)
    check_joint_limits(arm, "initial joint position", position)
    if "joint_velocity" not in options:
        return position, np.zeros(position.shape)
    velocity = options["joint_velocity"]
    beyond = (np.abs(velocity) > SPEED_BOUND).any(axis=-1)
    if beyond.any():
        first, unit = velocity[beyond][0].tolist(), "rad/s, m/s, rad/s"
        raise InvalidValueError("initial joint velocity", first, f"within ±{SPEED_BOUND}", unit)
    return position, velocity


def arm_physics(physics: Simulation) -> ArmSimulation:
    """Narrow a simulation to one of the arm.

    Raises:
        InvalidValueError: a simulation of another robot.
    """
    if not isinstance(physics, ArmSimulation):
        raise InvalidValueError("physics", type(physics).__name__, "an ArmSimulation")
    return physics


class ArmWorld(World[StartT]):
    """The arm in free space; the scenario may give the plant link-mass errors and joint friction.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
        surface: Whether the world has an elastic surface.

    Attributes:
        arm: Nominal arm.
    """

    def __init__(self, setup: TaskSetup, surface: bool = False) -> None:
        self.arm = self.model = PRPArm(NOMINAL)
        self._scenario, self._engine = setup.scenario, setup.engine
        self._surface = surface

    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> Simulation:
        """See `World.make_physics`."""
        settings = PhysicsSettings(timestep, self._scenario.joint_stops, self._surface)
        return make_arm(self._engine, settings, num_envs, num_threads)

    def draw_plants(self, rngs: Sequence[np.random.Generator]) -> PlantDraw | None:
        """See `World.draw_plants`; nothing is drawn where the plants are the nominal arm."""
        return None if self._scenario.ideal_plant else self._scenario.draw_plants(rngs)

    def configure(
        self, physics: Simulation, ids: NDArray[np.intp], start: StartT, plants: PlantDraw | None
    ) -> None:
        """See `World.configure`: sets link masses and joint friction."""
        if plants is None:
            return
        arm_physics(physics).set_dynamics(
            ids, plants.mass_factor, plants.viscous_friction, plants.coulomb_friction
        )
