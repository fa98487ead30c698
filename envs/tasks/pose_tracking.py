"""PRP-PoseTracking-v0: follow a trajectory of the end effector's pose."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from prp_gym.checks import choice
from prp_gym.envs.base.arm_world import ArmWorld
from prp_gym.envs.base.motion_errors import PoseErrors
from prp_gym.envs.base.references import PoseSpaceReference
from prp_gym.envs.base.scoring import POSE_SCORING
from prp_gym.envs.base.tracking_starts import Made, StartOptions, TrackingStarts, WaypointSampler
from prp_gym.envs.config import describe
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import EpisodeStart, TaskParts, observed_layout
from prp_gym.tasks.ranges import Range
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec
from prp_gym.tasks.trajectory import QuinticWaypoints

REFERENCES = ("joint", "pose")
WAYPOINTS = ("printed", "as_run")


@dataclass(frozen=True)
class PoseTrackingOptions(StartOptions):
    """The task's own keywords.

    Raises:
        UnknownNameError: a reference, start or set of waypoints that does not exist.
    """

    reference: str = field(
        default="joint",
        metadata=describe(
            "",
            "space in which the quintic connects the waypoints: `joint` (the arm can follow), or `pose` as in"
            " the report (between waypoints, three joints cannot attain every such pose)",
        ),
    )

    waypoints: str = field(
        default="printed",
        metadata=describe(
            "",
            "waypoints of scenario `report`: `printed` has π/3 in the first one's first joint, as the text of"
            " the report, and `as_run` π/4, as its author's last script",
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        choice("reference", self.reference, REFERENCES)
        choice("waypoints", self.waypoints, WAYPOINTS)


class PoseWaypointSampler(WaypointSampler):
    """Draws quintic segments of the pose through the poses of joint waypoints."""

    def make(self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None) -> Made:
        """See `ReferenceSampler.make`; a goal replaces the last waypoint."""
        times, joints = self.path(drawn, joint_position, goal)
        return QuinticWaypoints(times, self.arm.forward_kinematics(joints)), joint_position


def compose(setup: TaskSetup) -> TaskParts:
    """Follow a trajectory of the end effector's pose.

    Scenario `report` starts at home and moves through the poses of the report's waypoints; the others draw
    waypoints over nearly the whole joint range and start at the arm's initial pose.

    Source: [R] 10.1.
    """
    world: ArmWorld[EpisodeStart] = ArmWorld(setup)
    if setup.options.waypoints == "as_run":
        setup = _as_run(setup)
    sampler = WaypointSampler if setup.options.reference == "joint" else PoseWaypointSampler
    reference = PoseSpaceReference(world.arm)
    errors = PoseErrors(observed_layout(world, reference))
    return TaskParts(world, TrackingStarts(world, sampler(setup, world.arm)), reference, errors)


def _as_run(setup: TaskSetup) -> TaskSetup:
    """The setup with the first waypoint of the author's last script."""
    numbers, kind = setup.numbers, setup.scenario.draws
    if not setup.scenario.deterministic:
        allowed = "'printed' in this scenario, which draws its waypoints ('as_run' needs scenario 'report')"
        raise InvalidValueError("waypoints", "as_run", allowed)
    first = tuple(numbers.constants["first_waypoint_as_run"])
    waypoints = first + setup.ranges["waypoints"].low[len(first) :]
    drawn = {**setup.ranges, "waypoints": Range(waypoints, waypoints)}
    return replace(setup, numbers=replace(numbers, ranges={**numbers.ranges, kind: drawn}))


TASK = register_task(
    TaskSpec(
        id="PRP-PoseTracking-v0",
        summary="follow a trajectory of the end effector's pose",
        entry=TaskEntry(compose, PoseTrackingOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=POSE_SCORING,
        chapter=10.1,
        revision=2,
        released=True,
    )
)
