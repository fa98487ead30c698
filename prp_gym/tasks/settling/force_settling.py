"""`ForceSettling`: the contact force and the pose beside it have settled."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.tasks.settling.criterion import Fields, SettlingCriterion
from prp_gym.tasks.settling.directions import across_desired, along_desired


@dataclass(frozen=True)
class ForceSettling(SettlingCriterion):
    """Tolerances of the force along the desired one, of the tip across it, and of the angles α and β.

    Attributes:
        share: Tolerance of the force, as a share of the desired force [1].
        least: Least tolerance of the force [N].
        position: Tolerance of the tip's position across the desired force [m].
        angle: Tolerance of the norm over the errors of α and β [rad].
    """

    share: float
    least: float
    position: float
    angle: float

    _angles: ClassVar[slice] = slice(3, 5)

    @property
    def requires(self) -> tuple[str, ...]:
        """See `SettlingCriterion.requires`."""
        return ("contact_force", "desired_force", "end_effector_pose", "desired_pose")

    @property
    def definition(self) -> str:
        """See `SettlingCriterion.definition`."""
        return (
            f"force within {100 * self.share:g} % of the desired one (at least {self.least:g} N), tip within "
            f"{self.position:g} m across it, α and β within {self.angle:g} rad"
        )

    def deviations(self, fields: Fields) -> tuple[Array, ...]:
        """See `SettlingCriterion.deviations`: the force, the position across it, the angles."""
        desired = fields["desired_force"]
        force, magnitude = along_desired(fields["contact_force"], desired)
        pose_error = fields["desired_pose"] - fields["end_effector_pose"]
        return (
            (magnitude - force) / np.maximum(self.share * magnitude, self.least),
            across_desired(pose_error[..., :3], desired) / self.position,
            pose_error[..., self._angles] / self.angle,
        )

    def reference(self, fields: Fields) -> Array:
        """See `SettlingCriterion.reference`: the desired pose and the desired force."""
        return np.concatenate([fields["desired_pose"], fields["desired_force"]], axis=-1)
