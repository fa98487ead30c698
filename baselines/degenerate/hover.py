"""The degenerate policy `hover`: close to the surface, without pressing on it."""

import numpy as np

from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.floors.hold import HoldFloor
from prp_gym.robot.arrays import Array, dot, norm, solve_least_squares

_APPROACH = 0.02  # m/s
_RETREAT = 0.002  # m
_TOUCH = 0.4  # N, well above bias and noise of the sensor in scenario `realistic`
_DAMPING = 0.05  # of the pseudoinverse, since the position part of J_A is singular at q_3 = ±π/2


class HoverPolicy(HoldFloor):
    """The control law of `HoldFloor` about a position that moves to the surface and back at the first touch.

    The tip approaches along the desired force at 2 cm/s; once a force is felt, it retreats by 2 mm and stays.
    """

    measured_fields = ("joint_position", "joint_velocity", "contact_force", "desired_force")

    def initial_state(self, observed: Observed) -> ControllerState:
        """The joint position at the start, and no touch yet."""
        (start,) = super().initial_state(observed)
        return start, np.zeros((*start.shape[:-1], 1))

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        target, touched = state
        torque, _ = super().control(observed, (target,))
        desired, force = observed["desired_force"], observed["contact_force"]
        inward = desired / norm(desired)[..., None]
        felt = (dot(force, inward)[..., None] > _TOUCH) | (touched > 0.0)
        first = felt & (touched == 0.0)
        distance = np.where(felt, np.where(first, -_RETREAT, 0.0), _APPROACH * self.interface.period)
        moved = target + self._joint_step(observed["joint_position"], inward * distance)
        return torque, (moved, felt.astype(np.float64))

    def _joint_step(self, q: Array, step: Array) -> Array:
        """The step of the joints (..., 3) that moves the tip by `step` (..., 3) [m]."""
        jacobian = self.model.analytical_jacobian(q)[..., :3, :]  # type: ignore[union-attr]
        return solve_least_squares(jacobian, step, _DAMPING)


HOVER = ControllerSpec(
    name="hover", summary="degenerate: close to the surface without pressing", policy=HoverPolicy
)
