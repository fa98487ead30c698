"""Errors of force tasks: force along the surface normal, contact, and pose in the other directions."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.motion_errors import SCORED_ANGLES
from prp_gym.physics.surface import CONTACT_THRESHOLD
from prp_gym.robot.arrays import Array, dot, norm, sum_of_products, zeros
from prp_gym.symbolic.array import is_symbolic
from prp_gym.tasks.fields import FORCE_ERROR, Field, ObservationLayout
from prp_gym.tasks.parts import ErrorFunction
from prp_gym.tasks.setup import TaskSetup

_ESTABLISHED = 0.5  # relative force error below which a contact is established


class ForceErrors(ErrorFunction):
    """Force error, disturbance of the contact, deviation from the pose in other directions, and effort.

    With f = n·f_e along the desired force f_d n, the relative force error is 1 - f/f_d; where it is negative,
    the force exceeds the desired one, and its size counts `excess_factor` times. The disturbance of the
    contact keeps the worst moment: it is the largest of the relative excess f/f_d - 1, of 1 at every
    moment at which contact is lost that had been established by half the desired force, and of its former
    value, which decays with `disturbance_time`. Without contact it is at least 1. A short impact, which a
    mean error hardly shows, so costs score for as long as the decay takes, as do bounces.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
        layout: Layout of the observation.
    """

    unobserved_fields: ClassVar[tuple[Field, ...]] = (FORCE_ERROR,)
    state_arrays: ClassVar[Mapping[str, int]] = {"_disturbance": 0, "_established": 0}

    def __init__(self, setup: TaskSetup, layout: ObservationLayout) -> None:
        self._measured = layout.index("end_effector_pose")
        self._desired = layout.index("desired_pose")
        self._force = layout.index("contact_force")
        self._desired_force = layout.index("desired_force")
        self._own = slice(layout.size, layout.size + len(FORCE_ERROR.units))
        constants = setup.numbers.constants
        self._excess_factor = float(constants["excess_factor"])
        self._decay = math.exp(-setup.period / float(constants["disturbance_time"]))
        self._disturbance = np.zeros(0)
        self._established: NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)
        self._present: tuple[Array, NDArray[np.bool_]] | None = None  # what `advance` has measured

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:
        """See `ErrorFunction.begin`: no disturbance yet, and no contact that could be lost."""
        if not len(self._disturbance):
            self._disturbance = np.zeros(len(ids))
            self._established = np.zeros(len(ids), dtype=np.bool_)
        self._disturbance[ids] = 0.0
        self._established[ids] = False

    def _measure(self, ground_truth: Array) -> tuple[Array, NDArray[np.bool_]]:
        """The relative force error along the desired force (N), and whether the tip touches (N)."""
        force, desired = ground_truth[:, self._force], ground_truth[:, self._desired_force]
        if len(force) == 1 and not is_symbolic(
            force
        ):  # numbers are faster than small arrays, with the same bits
            f, f_d = force[0].tolist(), desired[0].tolist()
            error = 1.0 - sum_of_products(f, f_d) / sum_of_products(f_d, f_d)
            return np.array([error]), np.array([math.sqrt(sum_of_products(f, f)) > CONTACT_THRESHOLD])
        return 1.0 - dot(force, desired) / dot(desired, desired), norm(force) > CONTACT_THRESHOLD

    def advance(self, ground_truth: Array) -> None:
        """See `ErrorFunction.advance`."""
        error, touching = self._measure(ground_truth)
        event = np.where(self._established & ~touching, 1.0, -error)
        self._disturbance = np.maximum(self._disturbance * self._decay, event)
        self._established = touching & (self._established | (error < _ESTABLISHED))
        self._present = error, touching

    def complete(self, ground_truth: Array) -> None:
        """See `ErrorFunction.complete`; a reset measures anew, a step has just done so."""
        error, touching = self._present or self._measure(ground_truth)
        own = ground_truth[:, self._own]
        own[:, 0] = np.where(error < 0.0, self._excess_factor * error, error)
        own[:, 1] = np.where(touching, self._disturbance, np.maximum(self._disturbance, 1.0))
        self._present = None

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 5, 3): force, contact [1], tip along the surface [m], α and β [rad], torque [N m, N, N m]."""
        desired = ground_truth[..., self._desired_force]
        inward = desired / norm(desired)[..., None]
        pose_error = ground_truth[..., self._desired] - ground_truth[..., self._measured]
        deviation = pose_error[..., :3]
        errors = zeros((*torque.shape[:-1], 5, 3), torque)
        errors[..., :2, 0] = ground_truth[..., self._own]
        errors[..., 2, :] = deviation - dot(deviation, inward)[..., None] * inward
        errors[..., 3, :SCORED_ANGLES] = pose_error[..., 3 : 3 + SCORED_ANGLES]
        errors[..., 4, :] = torque
        return errors
