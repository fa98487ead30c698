"""The numbers that every environment returns in `info` beside the reward terms."""

from dataclasses import dataclass


@dataclass(frozen=True)
class InfoField:
    """One number of `info`: its name, unit and meaning."""

    name: str
    unit: str
    description: str


COMMON_INFO = (
    InfoField("cost_joint_stop", "joints", "joints beyond a stop"),
    InfoField("cost_saturation", "joints", "joints whose action is at or beyond the actuator limit"),
    InfoField("time", "s", "since the start of the episode"),
)
CONTACT_INFO = (
    InfoField("contact_force", "N", "magnitude of the force by the tip on the surface"),
    InfoField("cost_force_bound", "1", "whether that force is beyond the task's bound"),
)
