"""Example-JointRoundTrip-v0: go to a joint position and come back."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from prp_gym.envs.base.arm_world import ArmWorld, check_joint_limits
from prp_gym.envs.base.motion_errors import JointErrors
from prp_gym.envs.base.references import JointSpaceReference
from prp_gym.envs.base.scoring import JOINT_SCORING
from prp_gym.envs.base.tracking_starts import Made, ReferenceSampler, TrackingStarts, path_from
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import EpisodeStart, TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec
from prp_gym.tasks.trajectory import QuinticWaypoints


class RoundTripSampler(ReferenceSampler):
    """A quintic from the initial joint position to a goal, and another one back."""

    names = ("goal", "interval")

    def make(self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None) -> Made:
        """See `ReferenceSampler.make`."""
        target = drawn["goal"] if goal is None else goal
        check_joint_limits(self.arm, "goal", target)
        waypoints = np.stack([target, joint_position], axis=-2)
        return QuinticWaypoints(*path_from(joint_position, waypoints, drawn["interval"])), joint_position


def compose(setup: TaskSetup) -> TaskParts:
    """Go to a joint position and come back, at rest in both.

    Scenario `report` goes from home to one fixed position; the others draw the start and the goal over
    nearly the whole joint range.
    """
    world: ArmWorld[EpisodeStart] = ArmWorld(setup)
    starts = TrackingStarts(world, RoundTripSampler(setup, world.arm))
    reference = JointSpaceReference(world.arm)
    return TaskParts(world, starts, reference, JointErrors(observed_layout(world, reference)))


TASK = register_task(
    TaskSpec(
        id="Example-JointRoundTrip-v0",
        summary="go to a joint position and come back",
        entry=TaskEntry(compose),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=JOINT_SCORING,
    )
)
