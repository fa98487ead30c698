"""PRP-ForcePosition-v0: press on a surface while moving along it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from prp_gym.checks import choice
from prp_gym.envs.base.contact_starts import ContactStart, ContactStarts, ContactWorld
from prp_gym.envs.base.force_errors import ForceErrors
from prp_gym.envs.base.force_options import ForceOptions, NormalForce
from prp_gym.envs.base.references import ForceAndPoseReference
from prp_gym.envs.base.scoring import FORCE_SCORING
from prp_gym.envs.base.tracking_starts import path_from
from prp_gym.envs.config import describe
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec
from prp_gym.tasks.trajectory import QuinticWaypoints, Trajectory

STARTS = ("goal", "home")


@dataclass(frozen=True, eq=False)
class ReachWaypoints(QuinticWaypoints):
    """Quintic segments in q_1, the reach L = q_2 + d̄_2 + a_3 C_3 and q_3, as motions of the joints.

    While q_1 and L are constant and q_3 rotates, the tip moves along a plane perpendicular to the slide.

    Attributes:
        positions: Values of q_1 [rad], L [m] and q_3 [rad] at the waypoints (N, K, 3).
        slide_offset: Slide offset d̄_2 (N, 1) [m].
        third_link: Length a_3 of the third link (N, 1) [m].
    """

    slide_offset: Array
    third_link: Array

    @classmethod
    def through(cls, arm: PRPArm, times: Array, joints: Array) -> "ReachWaypoints":
        """Make n rows through joint positions (n, K, 3) [rad, m, rad] at given times (n, K) [s]."""
        geometry, shape = arm.parameters.geometry, (len(times), 1)
        positions = joints.copy()
        positions[..., 1] = arm.reach(joints)
        d_2, a_3 = np.full(shape, geometry.slide_offset), np.full(shape, geometry.third_link_length)
        return cls(times, positions, d_2, a_3)

    def sample(self, time: Array) -> Array:
        """See `Trajectory.sample`."""
        values = super().sample(time)
        d_2, a_3 = self.slide_offset[:, 0], self.third_link[:, 0]
        sine, cosine = a_3 * np.sin(values[..., 2]), a_3 * np.cos(values[..., 2])
        rate, acceleration = values[..., 5], values[..., 8]
        values[..., 1] -= d_2 + cosine
        values[..., 4] += sine * rate
        values[..., 7] += cosine * rate**2 + sine * acceleration
        return values

    @property
    def goal(self) -> Array:
        """The last waypoint as a joint position (N, 3) [rad, m, rad]."""
        goal = super().goal.copy()
        goal[:, 1] -= self.slide_offset[:, 0] + self.third_link[:, 0] * np.cos(goal[:, 2])
        return goal


@dataclass(frozen=True)
class ForcePositionOptions(ForceOptions):
    """The task's own keywords.

    Raises:
        UnknownNameError: a start that does not exist.
    """

    start: str = field(
        default="goal",
        metadata=describe(
            "",
            "initial position: `goal` is on the reference, `home` is q = 0, as the report's author ran it",
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        choice("start", self.start, STARTS)


class HomeStarts(ContactStarts):
    """Samples starts at home, unless a reset option gives another joint position."""

    def draw(self, rngs: Sequence[np.random.Generator], options: Mapping[str, Array]) -> ContactStart:
        """See `StartSampler.draw`."""
        drawn = super().draw(rngs, options)
        if "joint_position" in options:
            return drawn
        return replace(drawn, joint_position=np.zeros_like(drawn.joint_position))


def compose(setup: TaskSetup) -> TaskParts:
    """Press on a surface with a given force and follow a pose in the other directions.

    The reward measures the error of the force along the surface normal and the deviation from the desired
    pose in the other directions. Scenario `report` holds the pose of (-π/2 rad, -0.1 m, -π/6 rad), 0.1 m off
    a surface at x = -0.3078 m, with a desired force of 0.5 N along +x; the report's own experiment, with
    1 N/m and from home, needs q_2 = -0.7 m, far beyond the slide's limit, so that 50 N/m is the default. The
    other scenarios move the tip along the surface.

    Source: [R] 15; [S] 9.4.3.
    """
    start, world = setup.options.start, ContactWorld(setup)
    if start == "home" and not setup.scenario.deterministic:
        allowed = (
            "'goal' in this scenario: home may lie behind a drawn surface ('home' needs scenario 'report')"
        )
        raise InvalidValueError("start", start, allowed)
    sampler = HomeStarts if start == "home" else ContactStarts
    starts = sampler(setup, world, partial(_along_surface, world.arm), NormalForce(setup.options))
    reference = ForceAndPoseReference(world.arm)
    return TaskParts(world, starts, reference, ForceErrors(setup, observed_layout(world, reference)))


def _along_surface(arm: PRPArm, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """Segments along the surface from the start through the waypoints; see `ContactPath`."""
    return ReachWaypoints.through(arm, *path_from(start, waypoints, intervals))


TASK = register_task(
    TaskSpec(
        id="PRP-ForcePosition-v0",
        summary="press on a surface with a given force while moving along it",
        entry=TaskEntry(compose, ForcePositionOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=FORCE_SCORING,
        chapter=15,
        revision=2,
        released=True,
    )
)
