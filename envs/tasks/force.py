"""PRP-Force-v0: press on a surface with a given force."""

from pathlib import Path

from prp_gym.envs.base.contact_starts import ContactStarts, ContactWorld, hold_start
from prp_gym.envs.base.force_errors import ForceErrors
from prp_gym.envs.base.force_options import ForceOptions, NormalForce
from prp_gym.envs.base.references import ForceAndPoseReference
from prp_gym.envs.base.scoring import FORCE_SCORING
from prp_gym.tasks.parts import TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec


def compose(setup: TaskSetup) -> TaskParts:
    """Press on a surface with a given force and hold the rest of the pose.

    The tip starts off the surface. The reward measures the error of the force along the surface normal and
    the deviation from the initial pose in the other directions. Scenario `report` starts at home, has a
    desired force of 1 N along +y, and a surface of 5 N/m at y = -0.44 m; that force brings the slide
    to its limit, q_2 = -0.3 m.

    Source: [R] 14; [S] 9.4.2.
    """
    world = ContactWorld(setup)
    starts = ContactStarts(setup, world, hold_start, NormalForce(setup.options))
    starts.reset_options = {k: v for k, v in starts.reset_options.items() if k != "goal"}
    reference = ForceAndPoseReference(world.arm)
    return TaskParts(world, starts, reference, ForceErrors(setup, observed_layout(world, reference)))


TASK = register_task(
    TaskSpec(
        id="PRP-Force-v0",
        summary="press on a surface with a given force and hold the rest of the pose",
        entry=TaskEntry(compose, ForceOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=FORCE_SCORING,
        chapter=14,
        released=True,
    )
)
