"""The numbers that every environment returns in `info` beside the reward terms."""

from dataclasses import dataclass

LAST, SUMMED, AVERAGED = "last", "sum", "mean"
"""What a step over several control periods returns of their values."""


@dataclass(frozen=True)
class InfoField:
    """One number of `info`: its name, unit and meaning.

    Attributes:
        name: Name of the number.
        unit: Unit of the number.
        description: Meaning of the number.
        over_periods: What a step over several control periods returns of their values: `LAST`, `SUMMED` or
            `AVERAGED`.
    """

    name: str
    unit: str
    description: str
    over_periods: str = LAST


COMMON_INFO = (
    InfoField("cost_joint_stop", "joints", "number of joints beyond a stop", SUMMED),
    InfoField(
        "cost_saturation",
        "joints",
        "number of joints whose torque is at or beyond the actuator limit",
        SUMMED,
    ),
    InfoField("time", "s", "time since the start of the episode"),
)
CONTACT_INFO = (
    InfoField("contact_force", "N", "magnitude of the force by the tip on the surface"),
    InfoField("cost_force_bound", "1", "1 if that force exceeds the bound of the task, else 0", SUMMED),
)
