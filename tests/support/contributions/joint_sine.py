"""PRP-JointSine-v0: follow a sine in every joint."""

from pathlib import Path

from prp_gym.envs.base.arm_world import ArmWorld
from prp_gym.envs.base.motion_errors import JointErrors
from prp_gym.envs.base.references import JointSpaceReference
from prp_gym.envs.base.scoring import JOINT_SCORING
from prp_gym.envs.base.tracking_starts import SineSampler, TrackingStarts
from prp_gym.tasks.parts import EpisodeStart, TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskScoring, TaskSpec


def compose(setup: TaskSetup) -> TaskParts:
    """Follow a sine in every joint.

    Scenario `report` starts at rest in the centre of the sine; the others draw centre, amplitude, frequency
    and phase, and start on the reference.
    """
    world: ArmWorld[EpisodeStart] = ArmWorld(setup)
    starts = TrackingStarts(world, SineSampler(setup, world.arm))
    reference = JointSpaceReference(world.arm)
    return TaskParts(world, starts, reference, JointErrors(observed_layout(world, reference)))


register_task(
    TaskSpec(
        id="PRP-JointSine-v0",
        summary="follow a sine in every joint",
        entry=TaskEntry(compose),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=TaskScoring(("joint_rmse", "peak_power"), JOINT_SCORING.criteria),
    )
)
