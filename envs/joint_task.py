"""What the joint-space tasks share: a reference trajectory of the joints, judged joint by joint."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import EpisodeError, InvalidValueError, JointLimitError
from prp_gym.physics.rendering import GOAL_COLOR, PATH_COLOR, Ball, Mark, Path
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import JOINT_UNITS
from prp_gym.tasks.fields import JOINT_REFERENCE_FIELDS, SPEED_BOUND
from prp_gym.tasks.scenario import Range, Scenario
from prp_gym.tasks.task import EpisodeStart, Task, TaskNumbers
from prp_gym.tasks.trajectory import Constant, Trajectory

Draw = tuple[Trajectory, Array]

_PATH_POINTS = 120
_ROUNDING = 1e-6  # [rad] or [m]: a limit written in single precision, or a sum that ends on it


@dataclass(frozen=True, eq=False)
class JointStart(EpisodeStart):
    """A start with its reference.

    Attributes:
        trajectory: one row.
    """

    trajectory: Trajectory


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


class JointTask(Task[JointStart]):
    """Follow a joint-space trajectory; the errors are those of the joints, and the effort."""

    reference_fields = JOINT_REFERENCE_FIELDS
    reset_options = ("joint_position", "joint_velocity", "goal")

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, arm: PRPArm, options: object) -> None:
        super().__init__(numbers, scenario, arm, options)
        self.ranges: Mapping[str, Range] = numbers.ranges[scenario.draws]
        self._measured = self.layout.index("joint_position")
        self._desired = self.layout.index("desired_joint_position")
        self._trajectory: Trajectory | None = None

    @property
    def trajectory(self) -> Trajectory:
        """The reference of every environment, N rows."""
        if self._trajectory is None:
            raise EpisodeError("no episode has begun yet: call reset() first.")
        return self._trajectory

    @abstractmethod
    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """Draw one reference.

        Args:
            rng: the environment's own generator.
            joint_position: (3) drawn for the start [rad, m, rad].
            goal: (3) that replaces the drawn one, or None [rad, m, rad].

        Returns:
            the reference, one row, and the start (3) that goes with it [rad, m, rad].

        Raises:
            JointLimitError: the reference would leave the joint limits.
        """

    def draw_constant(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """A constant reference, drawn or given; see `draw_trajectory`."""
        drawn = self.ranges["goal"].draw(rng)
        target = drawn if goal is None else goal
        check_joint_limits(self.arm, "goal", target)
        return Constant(target[None]), joint_position

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> JointStart:
        """See `Task.draw`."""
        drawn = self.ranges["joint_position"].draw(rng)
        start = options.get("joint_position", drawn)
        trajectory, position = self.draw_trajectory(rng, start, options.get("goal"))
        position = options.get("joint_position", position)
        check_joint_limits(self.arm, "initial joint position", position)
        velocity = options.get("joint_velocity", np.zeros(3))
        if (np.abs(velocity) > SPEED_BOUND).any():
            unit = "rad/s, m/s, rad/s"
            raise InvalidValueError(
                "initial joint velocity", velocity.tolist(), f"within ±{SPEED_BOUND}", unit
            )
        return JointStart(position, velocity, trajectory)

    def begin(self, ids: NDArray[np.intp], starts: Sequence[JointStart]) -> None:
        """See `Task.begin`."""
        rows = [start.trajectory for start in starts]
        stacked = type(rows[0]).concatenate(rows)
        if self._trajectory is None:
            self._trajectory = stacked
        else:
            self._trajectory.assign(ids, stacked)

    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Task.reference`."""
        trajectory = self.trajectory if ids is None else self.trajectory.rows(ids)
        return trajectory.sample(time)

    def errors(self, observation: Array, torque: Array) -> Array:
        """(..., 2, 3): joint tracking error [rad, m, rad] and torque [N m, N, N m]."""
        errors = np.empty((*torque.shape[:-1], 2, 3))
        desired, measured = observation[..., self._desired], observation[..., self._measured]
        np.subtract(desired, measured, out=errors[..., 0, :])
        errors[..., 1, :] = torque
        return errors

    def marks(self, index: int, duration: float) -> list[Mark]:
        """The goal of the tip, and its path where the reference moves."""
        trajectory = self.trajectory.rows(np.array([index]))
        goal = self.arm.forward_kinematics(trajectory.goal[0])[:3]
        marks: list[Mark] = [Ball(goal, 0.025, GOAL_COLOR)]
        if not trajectory.is_constant:
            time = np.linspace(0.0, duration, _PATH_POINTS)[:, None]
            points = self.arm.forward_kinematics(trajectory.sample(time)[:, 0, :3])[:, :3]
            marks.append(Path(points, 2.0, PATH_COLOR))
        return marks
