"""The numbers that a video shows beside the frames: contact force, desired force, and the task's error."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import norm

_MILLI = 1e3


class Sample(NamedTuple):
    """The numbers of one moment of an episode.

    Attributes:
        time: Time since the start of the episode [s].
        force: Contact force [N]; NaN in tasks without contact.
        desired_force: Desired force [N]; NaN in tasks without one.
        error: Error of the task, in the unit of its `ErrorSignal`.
    """

    time: float
    force: float
    desired_force: float
    error: float


@dataclass(frozen=True)
class ErrorSignal:
    """The error of a task that a video shows.

    Attributes:
        name: Name of the error.
        unit: Unit of the error.
        term: Position of the reward term whose error it is; None for the distance of the tip from the
            reference.
    """

    name: str
    unit: str
    term: int | None

    @classmethod
    def of(cls, loop: EpisodeLoop) -> Self:
        """The error of a task: of the tip's position where the reward measures it, else of the tracking."""
        terms = [term.name for term in loop.task.numbers.reward]
        if "position" in terms:
            return cls("position error", "mm", terms.index("position"))
        if isinstance(loop.task.model, PRPArm):
            return cls("tip error", "mm", None)
        return cls("tracking error", "mrad", 0)

    def measure(self, loop: EpisodeLoop) -> float:
        """The error of the first environment of a loop, in `unit`."""
        if self.term is not None:
            errors = loop.task.errors(loop.ground_truth, loop.commanded_torque)
            return _MILLI * float(norm(errors[0, self.term]))
        arm, layout = loop.task.model, loop.task.ground_truth_layout
        desired = loop.ground_truth[0, layout.index("desired_joint_position")]
        if not isinstance(arm, PRPArm):
            return float("nan")
        distance = arm.forward_kinematics(desired)[:3] - loop.physics.tip_position[0]
        return _MILLI * float(norm(distance))


def sample(loop: EpisodeLoop, error: ErrorSignal) -> Sample:
    """The numbers of the present moment of the first environment of a loop."""
    layout = loop.task.ground_truth_layout
    desired = np.nan
    if "desired_force" in layout.names:
        desired = float(norm(loop.ground_truth[0, layout.index("desired_force")]))
    force = float(norm(loop.physics.contact_force[0])) if "contact_force" in layout.names else np.nan
    return Sample(float(loop.time[0]), force, desired, error.measure(loop))
