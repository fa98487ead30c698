"""The numbers that every environment returns in `info` beside the reward terms."""

from dataclasses import dataclass


@dataclass(frozen=True)
class InfoField:
    """One number of `info`: its name, unit and meaning.

    Attributes:
        name: Name of the number.
        unit: Unit of the number.
        description: Meaning of the number.
        summed: Whether a step over several control periods returns their sum instead of the last value.
    """

    name: str
    unit: str
    description: str
    summed: bool = False


COMMON_INFO = (
    InfoField("cost_joint_stop", "joints", "number of joints beyond a stop", summed=True),
    InfoField(
        "cost_saturation",
        "joints",
        "number of joints whose torque is at or beyond the actuator limit",
        summed=True,
    ),
    InfoField("time", "s", "time since the start of the episode"),
)
CONTACT_INFO = (
    InfoField("contact_force", "N", "magnitude of the force by the tip on the surface"),
    InfoField("cost_force_bound", "1", "1 if that force exceeds the bound of the task, else 0", summed=True),
)
