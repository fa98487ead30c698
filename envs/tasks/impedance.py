"""PRP-Impedance-v0: behave towards a surface like a mass, damper and spring."""

from pathlib import Path

from prp_gym.envs.base.contact_starts import ContactStarts, ContactWorld, quintic_path
from prp_gym.envs.base.references import PoseSpaceReference
from prp_gym.envs.base.scoring import TARGET_SCORING
from prp_gym.envs.base.target_errors import DynamicTargetErrors
from prp_gym.envs.base.target_options import TargetOptions
from prp_gym.tasks.parts import TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec


def compose(setup: TaskSetup) -> TaskParts:
    """Behave towards a surface like a mass, damper and spring.

    The reference moves to a pose behind the surface. The reward measures the deviation of the tip from a
    target model, which the contact force displaces from the same reference. Scenario `report` moves from home
    to the pose of (0 rad, -0.2 m, 0 rad) in 1 s, with the surface at y = -0.44 m.

    Source: M_d x̃¨ + K_D x̃˙ + K_P x̃ = h_e in [R] 12; [S] 9.3.1.
    """
    world = ContactWorld(setup)
    reference = PoseSpaceReference(world.arm)
    errors = DynamicTargetErrors(setup, observed_layout(world, reference))
    return TaskParts(world, ContactStarts(setup, world, quintic_path), reference, errors)


TASK = register_task(
    TaskSpec(
        id="PRP-Impedance-v0",
        summary="behave towards a surface like a mass, damper and spring",
        entry=TaskEntry(compose, TargetOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=TARGET_SCORING,
        chapter=12,
        revision=2,
        released=True,
    )
)
