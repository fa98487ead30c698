"""PRP-ForcePosition-v0: press on a surface while moving along it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from prp_gym.envs.base.contact_starts import ContactStart, ContactStarts, ContactWorld
from prp_gym.envs.base.force_errors import ForceErrors
from prp_gym.envs.base.force_options import ForceOptions, NormalForce
from prp_gym.envs.base.references import ForceAndPoseReference
from prp_gym.envs.base.scoring import FORCE_SCORING
from prp_gym.envs.base.tracking_starts import path_from
from prp_gym.envs.config import describe
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.spec import TaskEntry, TaskSpec
from prp_gym.tasks.task import TaskParts, TaskSetup, observed_layout
from prp_gym.tasks.trajectory import QuinticWaypoints, Trajectory

STARTS = ("goal", "home")


@dataclass(frozen=True, eq=False)
class ReachWaypoints(QuinticWaypoints):
    """Quintic segments in q_1, the reach L = q_2 + d̄_2 + a_3 C_3 and q_3, as motions of the joints.

    While q_1 and L rest and q_3 turns, the tip moves along a plane across the slide.

    Attributes:
        positions: (N, K, 3) q_1 [rad], L [m], q_3 [rad].
        slide_offset: d̄_2 (N, 1) [m].
        third_link: a_3 (N, 1) [m].
    """

    slide_offset: Array
    third_link: Array

    @classmethod
    def through(cls, arm: PRPArm, times: Array, joints: Array) -> "ReachWaypoints":
        """One row, at given times (K) [s] at given joint positions (K, 3) [rad, m, rad]."""
        geometry = arm.parameters.geometry
        d_2, a_3 = geometry.slide_offset, geometry.third_link_length
        positions = joints.copy()
        positions[:, 1] = arm.reach(joints)
        return cls(times[None], positions[None], np.full((1, 1), d_2), np.full((1, 1), a_3))

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
        """The last waypoint, (N, 3) [rad, m, rad]."""
        goal = super().goal.copy()
        goal[:, 1] -= self.slide_offset[:, 0] + self.third_link[:, 0] * np.cos(goal[:, 2])
        return goal


@dataclass(frozen=True)
class ForcePositionOptions(ForceOptions):
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a start that does not exist.
    """

    start: str = field(
        default="goal",
        metadata=describe(
            "", "`goal` begins on the reference, `home` at q = 0 as the report's author ran it"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.start not in STARTS:
            raise UnknownNameError("start", self.start, STARTS)


class HomeStarts(ContactStarts):
    """Starts at home, whatever was drawn, unless a reset option says otherwise."""

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> ContactStart:
        """See `StartSampler.draw`."""
        drawn = super().draw(rng, options)
        return drawn if "joint_position" in options else replace(drawn, joint_position=np.zeros(3))


def compose(setup: TaskSetup) -> TaskParts:
    """Press on a surface with a given force and follow a pose in the other directions.

    Scored are the force along the surface's normal, and the deviation from the desired pose in the other
    directions. Scenario `report` holds the pose of (-π/2 rad, -0.1 m, -π/6 rad), 0.1 m off a surface at
    x = -0.3078 m, and asks for 0.5 N along +x; its own run, with 1 N/m and from home, needs q_2 = -0.7 m,
    far beyond the slide's limit, so that 50 N/m is the default. The others move the tip along the surface.

    Source: [R] 15; [S] 9.4.3.
    """
    start, world = setup.options.start, ContactWorld(setup)
    if start == "home" and not setup.scenario.deterministic:
        allowed = "'goal': home may lie behind a surface that is drawn (scenario 'report' draws none)"
        raise InvalidValueError("start", start, allowed)
    sampler = HomeStarts if start == "home" else ContactStarts
    starts = sampler(setup, world, partial(_along_surface, world.arm), NormalForce(setup.options))
    reference = ForceAndPoseReference(world.arm)
    return TaskParts(world, starts, reference, ForceErrors(observed_layout(world, reference)))


def _along_surface(arm: PRPArm, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
    """Along the surface, from the start through the waypoints; see `ContactPath`."""
    return ReachWaypoints.through(arm, *path_from(start, waypoints, intervals))


TASK = register_task(
    TaskSpec(
        id="PRP-ForcePosition-v0",
        summary="press on a surface with a given force while moving along it",
        entry=TaskEntry(compose, ForcePositionOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=FORCE_SCORING,
        chapter=15,
        released=True,
    )
)
