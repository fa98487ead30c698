"""PRP-PoseRegulation-v0: bring the end effector to a pose and hold it."""

from pathlib import Path

from prp_gym.envs.base.arm_world import ArmWorld
from prp_gym.envs.base.motion_errors import PoseErrors
from prp_gym.envs.base.references import PoseSpaceReference
from prp_gym.envs.base.scoring import POSE_SCORING
from prp_gym.envs.base.tracking_starts import ConstantSampler, TrackingStarts
from prp_gym.tasks.parts import EpisodeStart, TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec


def compose(setup: TaskSetup) -> TaskParts:
    """Bring the end effector to a pose and hold it.

    Scenario `report` starts at home, with the pose of (-π/3 rad, -0.1 m, π/2 rad) as its goal; the others
    draw start and goal over nearly the whole joint range.

    Source: [R] 9.1.
    """
    world: ArmWorld[EpisodeStart] = ArmWorld(setup)
    starts = TrackingStarts(world, ConstantSampler(setup, world.arm))
    reference = PoseSpaceReference(world.arm)
    return TaskParts(world, starts, reference, PoseErrors(observed_layout(world, reference)))


TASK = register_task(
    TaskSpec(
        id="PRP-PoseRegulation-v0",
        summary="bring the end effector to a pose and hold it",
        entry=TaskEntry(compose),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=POSE_SCORING,
        chapter=9.1,
        revision=2,
        released=True,
    )
)
