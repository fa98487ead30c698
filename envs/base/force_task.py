"""What the force tasks share: a force to press with, and a pose to keep in the other directions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.contact_task import ContactStart, ContactTask, SurfaceOptions
from prp_gym.envs.base.pose_task import SCORED_ANGLES
from prp_gym.envs.checks import within
from prp_gym.envs.config import describe
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import DESIRED_FORCE, POSE_REFERENCE_FIELDS
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.task import ResetOption, TaskNumbers

FORCE_BOUNDS = (1e-3, 1e3)  # [N]
_FORCE_OPTION = ResetOption((), "N", "force to press with, along the surface's inward normal")


def check_force(value: object) -> float:
    """A desired force as a number [N].

    Raises:
        InvalidValueError: not a number within `FORCE_BOUNDS`.
    """
    return within("desired_force", value, FORCE_BOUNDS, _FORCE_OPTION.unit)


@dataclass(frozen=True)
class ForceOptions(SurfaceOptions):
    """The surface, and the force to press with.

    Raises:
        InvalidValueError: a force outside `FORCE_BOUNDS`.
    """

    desired_force: float | None = field(
        default=None, metadata=describe(_FORCE_OPTION.unit, _FORCE_OPTION.description + "; None draws it")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.desired_force is not None:
            object.__setattr__(self, "desired_force", check_force(self.desired_force))


class ForceTask(ContactTask):
    """Press with f_d along the surface's normal, and keep the desired pose in the other directions."""

    reference_fields = (*POSE_REFERENCE_FIELDS, DESIRED_FORCE)
    reset_options: ClassVar = {**ContactTask.reset_options, "desired_force": _FORCE_OPTION}

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._desired_force = self.layout.index("desired_force")
        self._forces = np.zeros((0, 3))

    def desired_force(
        self, drawn: Mapping[str, Array], options: Mapping[str, Array], surface: Surface
    ) -> Array:
        """Along the inward normal; a drawn force presses no deeper than the greatest depth."""
        deepest = float(surface.stiffness[0]) * float(drawn["greatest_depth"][0])
        magnitude = min(float(drawn["desired_force"][0]), deepest)
        if self.options.desired_force is not None:
            magnitude = self.options.desired_force
        if "desired_force" in options:
            magnitude = check_force(options["desired_force"])
        return -magnitude * np.array(surface.normal[0])

    def begin(self, ids: NDArray[np.intp], starts: Sequence[ContactStart]) -> None:
        """See `Task.begin`."""
        super().begin(ids, starts)
        if len(self._forces) == 0:
            self._forces = np.zeros((len(ids), 3))
        self._forces[ids] = [start.desired_force for start in starts]

    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Task.reference`."""
        pose = super().reference(time, ids)
        forces = self._forces if ids is None else self._forces[ids]
        return np.concatenate([pose, np.broadcast_to(forces, (*pose.shape[:-1], 3))], axis=-1)

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 4, 3): force [N], tip position along the surface [m], α and β [rad], torque [N m, N, N m]."""
        desired, force = ground_truth[..., self._desired_force], ground_truth[..., self._force]
        magnitude = np.sqrt(np.vecdot(desired, desired))
        inward = desired / magnitude[..., None]
        pose_error = self.pose_error(ground_truth)
        deviation = pose_error[..., :3]
        errors = np.zeros((*torque.shape[:-1], 4, 3))
        errors[..., 0, 0] = magnitude - np.vecdot(force, inward)
        errors[..., 1, :] = deviation - np.vecdot(deviation, inward)[..., None] * inward
        errors[..., 2, :SCORED_ANGLES] = pose_error[..., 3 : 3 + SCORED_ANGLES]
        errors[..., 3, :] = torque
        return errors
