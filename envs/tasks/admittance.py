"""PRP-Admittance-v0: give way to a surface as a compliant frame does."""

from dataclasses import dataclass, field

from prp_gym.envs.base.rendering_task import DynamicRenderingTask, TargetOptions
from prp_gym.envs.config import describe
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array

REFERENCES = ("return", "hold")


@dataclass(frozen=True)
class AdmittanceOptions(TargetOptions):
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a reference that does not exist.
    """

    reference: str = field(
        default="return",
        metadata=describe("", "`return` goes behind the surface and back off it, `hold` stays behind it"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.reference not in REFERENCES:
            raise UnknownNameError("reference", self.reference, REFERENCES)


class Admittance(DynamicRenderingTask):
    """M_t z̈ + K_Dt ż + K_Pt z = h_e, x = x_d - z. Source: [R] 13; [S] 9.3.2."""

    environment_id = "PRP-Admittance-v0"

    def way(self, waypoints: Array, intervals: Array) -> tuple[Array, Array]:
        """Behind the surface, and back where that is asked for."""
        if self.options.reference == "hold":
            return waypoints[:-1], intervals[:-1]
        return waypoints, intervals


class AdmittanceEnv(PRPEnv):
    """Give way to a surface as a compliant frame of given inertia, damping and stiffness does.

    The reference moves behind the surface and back. Scored is the distance of the tip from the reference,
    displaced as the contact force displaces the frame. Scenario `report` moves from home to the
    pose of (0 rad, -0.25 m, 0 rad) in 1.5 s and to that of (0 rad, -0.1 m, 0 rad) in another 1.5 s, with the
    surface at y = -0.34 m.
    """

    task_class = Admittance
    options_class = AdmittanceOptions


class AdmittanceVectorEnv(PRPVectorEnv):
    """Many of `AdmittanceEnv`, stepped together."""

    environment_class = AdmittanceEnv
