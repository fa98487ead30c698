"""PRP-Compliance-v0: yield to a surface like a spring."""

from pathlib import Path

from prp_gym.envs.base.contact_starts import ContactStarts, ContactWorld, hold_end
from prp_gym.envs.base.references import PoseSpaceReference
from prp_gym.envs.base.scoring import TARGET_SCORING
from prp_gym.envs.base.target_errors import StaticTargetErrors
from prp_gym.envs.base.target_options import StiffnessOptions
from prp_gym.tasks.parts import TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec


def compose(setup: TaskSetup) -> TaskParts:
    """Yield to a surface like a spring of given stiffness.

    The desired pose lies behind the surface. The reward measures the deviation of the tip from
    x_d - K_P⁻¹h_e, the equilibrium of a spring K_P between x_d and the tip under the present contact force
    h_e. Scenario `report` starts at home, has the pose of (0 rad, -0.2 m, 0 rad) as its goal, and has the
    surface at y = -0.44 m with its free side at y < -0.44 m.

    Source: [R] 11; [S] 9.2.1.
    """
    world = ContactWorld(setup)
    reference = PoseSpaceReference(world.arm)
    errors = StaticTargetErrors(setup, observed_layout(world, reference))
    return TaskParts(world, ContactStarts(setup, world, hold_end), reference, errors)


TASK = register_task(
    TaskSpec(
        id="PRP-Compliance-v0",
        summary="yield to a surface like a spring",
        entry=TaskEntry(compose, StiffnessOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=TARGET_SCORING,
        chapter=11,
        revision=2,
        released=True,
    )
)
