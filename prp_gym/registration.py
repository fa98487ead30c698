"""The environment ids, and their registration with Gymnasium."""

from dataclasses import dataclass

import gymnasium


@dataclass(frozen=True)
class EnvironmentEntry:
    """One registered environment.

    Attributes:
        id: for `gymnasium.make`.
        entry_point: `module:class`, imported on first use.
        summary: one line for listings.
    """

    id: str
    entry_point: str
    summary: str


ENVIRONMENTS = (
    EnvironmentEntry(
        "PRP-JointRegulation-v0",
        "prp_gym.envs.joint_regulation:JointRegulationEnv",
        "bring the joints to a position and hold it",
    ),
    EnvironmentEntry(
        "PRP-JointTracking-v0",
        "prp_gym.envs.joint_tracking:JointTrackingEnv",
        "follow a joint-space trajectory",
    ),
)


def list_envs() -> list[str]:
    """The ids of all environments of the suite."""
    return [entry.id for entry in ENVIRONMENTS]


def register_environments() -> None:
    """Make the ids known to Gymnasium; done by `import prp_gym`."""
    for entry in ENVIRONMENTS:
        if entry.id not in gymnasium.registry:
            gymnasium.register(entry.id, entry_point=entry.entry_point)
