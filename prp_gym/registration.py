"""The environment ids, and their registration with Gymnasium."""

from dataclasses import dataclass

import gymnasium


@dataclass(frozen=True)
class EnvironmentEntry:
    """One registered environment.

    Attributes:
        id: for `gymnasium.make`.
        entry_point: `module:class` of the single environment, imported on first use.
        summary: one line for listings.
    """

    id: str
    entry_point: str
    summary: str

    @property
    def vector_entry_point(self) -> str:
        """`module:class` of many of them together."""
        return f"{self.entry_point.removesuffix('Env')}VectorEnv"


ENVIRONMENTS = (
    EnvironmentEntry(
        "PRP-JointRegulation-v0",
        "prp_gym.envs.tasks.joint_regulation:JointRegulationEnv",
        "bring the joints to a position and hold it",
    ),
    EnvironmentEntry(
        "PRP-JointTracking-v0",
        "prp_gym.envs.tasks.joint_tracking:JointTrackingEnv",
        "follow a joint-space trajectory",
    ),
    EnvironmentEntry(
        "PRP-Adaptive-v0",
        "prp_gym.envs.tasks.adaptive:AdaptiveEnv",
        "follow a trajectory with one link of unknown inertia, friction and weight",
    ),
    EnvironmentEntry(
        "PRP-PoseRegulation-v0",
        "prp_gym.envs.tasks.pose_regulation:PoseRegulationEnv",
        "bring the end effector to a pose and hold it",
    ),
    EnvironmentEntry(
        "PRP-PoseTracking-v0",
        "prp_gym.envs.tasks.pose_tracking:PoseTrackingEnv",
        "follow a trajectory of the end effector's pose",
    ),
    EnvironmentEntry(
        "PRP-Compliance-v0",
        "prp_gym.envs.tasks.compliance:ComplianceEnv",
        "give way to a surface as a spring does",
    ),
    EnvironmentEntry(
        "PRP-Impedance-v0",
        "prp_gym.envs.tasks.impedance:ImpedanceEnv",
        "behave towards a surface as a mass, damper and spring does",
    ),
    EnvironmentEntry(
        "PRP-Admittance-v0",
        "prp_gym.envs.tasks.admittance:AdmittanceEnv",
        "give way to a surface as a compliant frame does",
    ),
    EnvironmentEntry(
        "PRP-Force-v0",
        "prp_gym.envs.tasks.force:ForceEnv",
        "press on a surface with a given force, hold the rest",
    ),
    EnvironmentEntry(
        "PRP-ForcePosition-v0",
        "prp_gym.envs.tasks.force_position:ForcePositionEnv",
        "press on a surface with a given force while moving along it",
    ),
)


def list_envs() -> list[str]:
    """The ids of all environments of the suite."""
    return [entry.id for entry in ENVIRONMENTS]


def register_environments() -> None:
    """Make the ids known to Gymnasium; done by `import prp_gym`."""
    for entry in ENVIRONMENTS:
        if entry.id not in gymnasium.registry:
            gymnasium.register(
                entry.id,
                entry_point=entry.entry_point,
                vector_entry_point=entry.vector_entry_point,
                order_enforce=False,  # the environments do so themselves
            )
