"""What the tasks of the arm share: its world, its start, and a reference trajectory."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, JointLimitError
from prp_gym.physics.batch_simulation import Simulation
from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.physics.rendering import GOAL_COLOR, PATH_COLOR, Ball, OverlayItem, Path
from prp_gym.physics.simulation import Physics
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import JOINT_UNITS, NOMINAL
from prp_gym.tasks.fields import SPEED_BOUND
from prp_gym.tasks.scenario import PlantDraw, Scenario
from prp_gym.tasks.task import ResetOption, TaskNumbers
from prp_gym.tasks.trajectory import Trajectory
from prp_gym.tasks.trajectory_task import StartT, TrajectoryTask

_PATH_POINTS = 120
_ROUNDING = 1e-6  # [rad] or [m]: a limit written in single precision, or a sum that ends on it

ARM_OPTIONS = {
    "joint_position": ResetOption((3,), "rad, m, rad", "initial joint position"),
    "joint_velocity": ResetOption((3,), "rad/s, m/s, rad/s", "initial joint velocity"),
    "goal": ResetOption((3,), "rad, m, rad", "joint position at the goal"),
}


def check_joint_limits(arm: PRPArm, what: str, joint_position: Array) -> None:
    """Refuse joint positions (..., 3) [rad, m, rad] outside the joint limits.

    Raises:
        JointLimitError: names the first joint that is outside.
    """
    low, high = np.array(arm.parameters.joint_lower), np.array(arm.parameters.joint_upper)
    outside = (joint_position < low - _ROUNDING) | (joint_position > high + _ROUNDING)
    if outside.any():
        place = tuple(np.argwhere(outside)[0].tolist())
        joint = place[-1]
        limits = (float(low[joint]), float(high[joint]))
        raise JointLimitError(what, joint + 1, float(joint_position[place]), limits, JOINT_UNITS[joint])


def path_from(start: Array, waypoints: Array, intervals: Array) -> tuple[Array, Array]:
    """Times (K + 1) [s] and positions (K + 1, d) of a path that leaves a start (d) at t = 0.

    Args:
        start: (d) any unit.
        waypoints: (K, d) that follow.
        intervals: (K) between them [s].
    """
    return np.concatenate([[0.0], np.cumsum(intervals)]), np.concatenate([start[None], waypoints])


def arm_world(physics: Simulation) -> Physics:
    """A world as one of the arm.

    Raises:
        InvalidValueError: a world of another robot.
    """
    if not isinstance(physics, Physics):
        raise InvalidValueError("physics", type(physics).__name__, "the arm's, a Physics")
    return physics


class ArmTask(TrajectoryTask[StartT]):
    """A task of the arm with a reference trajectory."""

    reset_options = ARM_OPTIONS
    surface = False

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self.arm = self.model = PRPArm(NOMINAL)

    @abstractmethod
    def tip_path(self, trajectory: Trajectory, time: Array) -> Array:
        """Tip positions (..., N, 3) [m] of N reference trajectories at times (..., N) [s]."""

    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> Simulation:
        """See `Task.make_physics`."""
        settings = PhysicsSettings(timestep, self.scenario.joint_stops, self.surface)
        return Physics(self.arm.parameters, settings, num_envs, num_threads)

    def draw_plant(self, rng: np.random.Generator) -> PlantDraw:
        """See `Task.draw_plant`; nothing is drawn where the plant is the nominal arm."""
        if self.scenario.ideal_plant:
            return PlantDraw(np.ones(3), np.zeros(3), np.zeros(3))
        return self.scenario.draw_plant(rng)

    def place(
        self,
        physics: Simulation,
        ids: NDArray[np.intp],
        starts: Sequence[StartT],
        plants: Sequence[PlantDraw],
    ) -> None:
        """See `Task.place`: masses and friction."""
        if self.scenario.ideal_plant:
            return
        arm_world(physics).set_dynamics(
            ids,
            np.stack([plant.mass_factor for plant in plants]),
            np.stack([plant.viscous_friction for plant in plants]),
            np.stack([plant.coulomb_friction for plant in plants]),
        )

    def checked_start(self, position: Array, options: Mapping[str, Array]) -> tuple[Array, Array]:
        """The initial joint position and velocity (3), after the reset options had their say.

        Raises:
            JointLimitError: a position outside the joint limits.
            InvalidValueError: a velocity beyond the declared bounds.
        """
        position = options.get("joint_position", position)
        check_joint_limits(self.arm, "initial joint position", position)
        velocity = options.get("joint_velocity", np.zeros(3))
        if (np.abs(velocity) > SPEED_BOUND).any():
            unit = "rad/s, m/s, rad/s"
            raise InvalidValueError(
                "initial joint velocity", velocity.tolist(), f"within ±{SPEED_BOUND}", unit
            )
        return position, velocity

    def overlay(self, index: int, duration: float) -> list[OverlayItem]:
        """The goal of the tip, and its path where the reference moves."""
        trajectory = self.trajectory.rows(np.array([index]))
        if trajectory.is_constant:
            return [Ball(self.tip_path(trajectory, np.zeros(1))[0], 0.025, GOAL_COLOR)]
        time = np.linspace(0.0, duration, _PATH_POINTS)[:, None]
        path = Path(self.tip_path(trajectory, time)[:, 0], 2.0, PATH_COLOR)
        return [Ball(self._goal_point(trajectory), 0.025, GOAL_COLOR), path]

    def _goal_point(self, trajectory: Trajectory) -> Array:
        goal = trajectory.goal[0]
        return goal[:3] if len(goal) == 6 else self.arm.forward_kinematics(goal)[:3]
