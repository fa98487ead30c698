"""PRP-Admittance-v0: yield to a surface like a compliant frame."""

from dataclasses import dataclass, field
from pathlib import Path

from prp_gym.checks import choice
from prp_gym.envs.base.contact_starts import ContactStarts, ContactWorld, quintic_path
from prp_gym.envs.base.references import PoseSpaceReference
from prp_gym.envs.base.scoring import TARGET_SCORING
from prp_gym.envs.base.target_errors import DynamicTargetErrors
from prp_gym.envs.base.target_options import TargetOptions
from prp_gym.envs.config import describe
from prp_gym.tasks.parts import TaskParts, observed_layout
from prp_gym.tasks.registration import register_task
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskEntry, TaskSpec

REFERENCES = ("return", "hold")


@dataclass(frozen=True)
class AdmittanceOptions(TargetOptions):
    """The task's own keywords.

    Raises:
        UnknownNameError: a reference that does not exist.
    """

    reference: str = field(
        default="return",
        metadata=describe("", "`return` moves behind the surface and back, `hold` stays behind the surface"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        choice("reference", self.reference, REFERENCES)


def compose(setup: TaskSetup) -> TaskParts:
    """Yield to a surface like a compliant frame with given inertia, damping and stiffness.

    The reference moves behind the surface and back. The reward measures the deviation of the tip from the
    compliant frame, which the contact force displaces from the reference. Scenario `report` moves from home
    to the pose of (0 rad, -0.25 m, 0 rad) in 1.5 s and to that of (0 rad, -0.1 m, 0 rad) in another 1.5 s,
    with the surface at y = -0.34 m.

    Source: M_t z̈ + K_Dt ż + K_Pt z = h_e, x = x_d - z in [R] 13; [S] 9.3.2.
    """
    world = ContactWorld(setup)
    kept = slice(-1) if setup.options.reference == "hold" else slice(None)
    reference = PoseSpaceReference(world.arm)
    errors = DynamicTargetErrors(setup, observed_layout(world, reference))
    return TaskParts(world, ContactStarts(setup, world, quintic_path, kept=kept), reference, errors)


TASK = register_task(
    TaskSpec(
        id="PRP-Admittance-v0",
        summary="yield to a surface like a compliant frame",
        entry=TaskEntry(compose, AdmittanceOptions),
        numbers=Path(__file__).with_suffix(".toml"),
        scoring=TARGET_SCORING,
        chapter=13,
        revision=2,
        released=True,
    )
)
