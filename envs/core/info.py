"""The numbers that every environment returns in `info` beside the reward terms."""

from dataclasses import dataclass


@dataclass(frozen=True)
class InfoField:
    """One number of `info`: its name, unit and meaning.

    Attributes:
        name: of the number.
        unit: of the number.
        description: what it is.
        summed: whether an action that holds over several periods returns their sum, and not the last one's.
    """

    name: str
    unit: str
    description: str
    summed: bool = False


COMMON_INFO = (
    InfoField("cost_joint_stop", "joints", "joints beyond a stop", summed=True),
    InfoField(
        "cost_saturation",
        "joints",
        "joints whose torque is at or beyond the actuator limit",
        summed=True,
    ),
    InfoField("time", "s", "since the start of the episode"),
)
CONTACT_INFO = (
    InfoField("contact_force", "N", "magnitude of the force by the tip on the surface"),
    InfoField("cost_force_bound", "1", "whether that force is beyond the task's bound", summed=True),
)
