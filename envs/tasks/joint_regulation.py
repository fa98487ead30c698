"""PRP-JointRegulation-v0: bring the joints to a position and hold it."""

from pathlib import Path

from prp_gym.envs.base.arm_world import ArmWorld
from prp_gym.envs.base.motion_errors import JointErrors
from prp_gym.envs.base.references import JointSpaceReference
from prp_gym.envs.base.scoring import JOINT_SCORING
from prp_gym.envs.base.tracking_starts import ConstantSampler, TrackingStarts
from prp_gym.tasks.parts import EpisodeStart, TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec


def compose(setup: TaskSetup) -> TaskParts:
    """Bring the joints to a position and hold it.

    Scenario `report` starts at home with the goal (π/2 rad, -0.2 m, π rad); the others draw start and
    goal over nearly the whole joint range.

    Source: [R] 6.1-6.3, 7.1.
    """
    world: ArmWorld[EpisodeStart] = ArmWorld(setup)
    starts = TrackingStarts(world, ConstantSampler(setup, world.arm))
    reference = JointSpaceReference(world.arm)
    return TaskParts(world, starts, reference, JointErrors(observed_layout(world, reference)))


TASK = register_task(
    TaskSpec(
        id="PRP-JointRegulation-v0",
        summary="bring the joints to a position and hold it",
        entry=TaskEntry(compose),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=JOINT_SCORING,
        chapter=6.1,
        revision=2,
        released=True,
    )
)
