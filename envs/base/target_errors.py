"""Errors of compliance, impedance and admittance tasks: deviations from a model that the contact drives."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.motion_errors import stack_errors
from prp_gym.robot.arrays import Array, zeros
from prp_gym.tasks.fields import MODEL_POSE, Field, ObservationLayout
from prp_gym.tasks.parts import ErrorFunction
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.target_model import TargetModel


class TargetErrors(ErrorFunction):
    """Deviation of the tip from the pose of a target model under the true contact force.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
        layout: Layout of the observation.

    Attributes:
        target: Target model M_d x̃¨ + K_D x̃˙ + K_P x̃ = h_e with x̃ = x_d - x.
    """

    unobserved_fields: ClassVar[tuple[Field, ...]] = (MODEL_POSE,)

    def __init__(self, setup: TaskSetup, layout: ObservationLayout) -> None:
        self._measured = layout.index("end_effector_pose")
        self._desired = layout.index("desired_pose")
        self._force = layout.index("contact_force")
        self._model_pose = slice(layout.size, layout.size + len(MODEL_POSE.units))
        own = setup.numbers.constants["target"]
        axes = [getattr(setup.options, f"target_{name}", None) or own[name] for name in own]
        self.target = TargetModel(**dict(zip(own, map(np.array, axes), strict=True)), period=setup.period)

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """See `ErrorFunction.target_impedance`."""
        return {name: getattr(self.target, name) for name in ("inertia", "damping", "stiffness")}

    def generalised_force(self, ground_truth: Array) -> Array:
        """The true contact force as a generalised force (..., 6) [N, N, N, N m, N m, N m]; no moments."""
        force = zeros((*ground_truth.shape[:-1], 6), ground_truth)
        force[..., :3] = ground_truth[..., self._force]
        return force

    def write_model_pose(self, ground_truth: Array, displacement: Array) -> None:
        """Write the desired pose minus a displacement (..., 6) as the model's pose, in place."""
        ground_truth[..., self._model_pose] = ground_truth[..., self._desired] - displacement

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 3, 3): deviation of the tip [m] and of α and β [rad] from the model, torque [N m, N, N m]."""
        error = ground_truth[..., self._model_pose] - ground_truth[..., self._measured]
        return stack_errors(error, torque)


class StaticTargetErrors(TargetErrors):
    """Deviations from a target with stiffness alone: K_P x̃ = h_e."""

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """See `ErrorFunction.target_impedance`: the stiffness alone."""
        return {"stiffness": self.target.stiffness}

    def complete(self, ground_truth: Array) -> None:
        """See `ErrorFunction.complete`."""
        force = self.generalised_force(ground_truth)
        self.write_model_pose(ground_truth, self.target.static_displacement(force))


class DynamicTargetErrors(TargetErrors):
    """Deviations from a target with inertia, damping and stiffness that moves under the contact force."""

    state_arrays: ClassVar[Mapping[str, int]] = {"_motion": 1}

    def __init__(self, setup: TaskSetup, layout: ObservationLayout) -> None:
        super().__init__(setup, layout)
        self._motion = np.zeros((4, 0, 6))  # displacement, its rate, force at start and end of a period

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:
        """See `ErrorFunction.begin`: the model starts at rest, on the reference."""
        if self._motion.shape[1] == 0:
            self._motion = np.zeros((4, len(ids), 6))
        self._motion[:, ids] = 0.0

    def advance(self, ground_truth: Array) -> None:
        """See `ErrorFunction.advance`."""
        self._motion[3, :, :3] = ground_truth[:, self._force]
        self.target.follow(self._motion)

    def complete(self, ground_truth: Array) -> None:
        """See `ErrorFunction.complete`; the present force, also after a reset, starts the next period."""
        self._motion[2, :, :3] = ground_truth[:, self._force]
        self.write_model_pose(ground_truth, self._motion[0])
