"""PRP-JointTracking-v0: follow a joint-space trajectory."""

from dataclasses import dataclass, field
from pathlib import Path

from prp_gym.checks import choice
from prp_gym.envs.base.arm_world import ArmWorld
from prp_gym.envs.base.motion_errors import JointErrors
from prp_gym.envs.base.references import JointSpaceReference
from prp_gym.envs.base.scoring import JOINT_SCORING
from prp_gym.envs.base.tracking_starts import (
    ConstantSampler,
    ReferenceSampler,
    SineSampler,
    StartOptions,
    TrackingStarts,
    WaypointSampler,
)
from prp_gym.envs.config import describe
from prp_gym.tasks.parts import EpisodeStart, TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec

_SAMPLERS: dict[str, type[ReferenceSampler]] = {
    "quintic": WaypointSampler,
    "sine": SineSampler,
    "constant": ConstantSampler,
}
REFERENCES = tuple(_SAMPLERS)


@dataclass(frozen=True)
class TrackingOptions(StartOptions):
    """The task's own keywords.

    Raises:
        UnknownNameError: a reference or start that does not exist.
    """

    reference: str = field(
        default="quintic",
        metadata=describe(
            "", "reference trajectory: `quintic` (through waypoints, at rest in each), `sine` or `constant`"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        choice("reference", self.reference, REFERENCES)


def compose(setup: TaskSetup) -> TaskParts:
    """Follow a joint-space trajectory.

    Scenario `report` has the report's waypoints (or its sine) and starts at home; the others draw waypoints
    over nearly the whole joint range and start at the arm's initial position.

    Source: [R] 6.4, 7.1.
    """
    world: ArmWorld[EpisodeStart] = ArmWorld(setup)
    sampler = _SAMPLERS[setup.options.reference](setup, world.arm)
    reference = JointSpaceReference(world.arm)
    errors = JointErrors(observed_layout(world, reference))
    return TaskParts(world, TrackingStarts(world, sampler), reference, errors)


TASK = register_task(
    TaskSpec(
        id="PRP-JointTracking-v0",
        summary="follow a joint-space trajectory",
        entry=TaskEntry(compose, TrackingOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=JOINT_SCORING,
        chapter=6.4,
        revision=2,
        released=True,
    )
)
