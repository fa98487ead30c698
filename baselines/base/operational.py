"""What the operational-space controllers share: the arm's model and the end effector's measured motion."""

from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.policy import Baseline, Observed, StaticBaseline
from prp_gym.baselines.base.references import PoseReference
from prp_gym.baselines.base.settings import Settings
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, anywhere, apply, apply_transposed, solve_least_squares

SettingsT = TypeVar("SettingsT", bound=Settings)

LIMIT_MARGIN = 0.01
"""Distance from a limit within which a joint counts as being at it [rad, m, rad]."""

_HELD = 1e-6  # damping that makes the pseudoinverse exist without a joint; its effect is 1e-12

MEASURED_MOTION = ("joint_position", "joint_velocity", "end_effector_pose", "end_effector_velocity")
"""The observation fields from which an `ArmState` is made."""


class ArmState(NamedTuple):
    """The measured motion of the arm, with its Jacobian.

    Attributes:
        joint_position: q (..., 3) [rad, m, rad].
        joint_velocity: q̇ (..., 3) [rad/s, m/s, rad/s].
        pose: x (..., 6) [m, m, m, rad, rad, rad].
        velocity: ẋ = J_A q̇ (..., 6) [m/s, m/s, m/s, rad/s, rad/s, rad/s].
        jacobian: J_A(q) (..., 6, 3).
    """

    joint_position: Array
    joint_velocity: Array
    pose: Array
    velocity: Array
    jacobian: Array


class OperationalBaseline(Baseline[SettingsT]):
    """A controller of the pose of the end effector, with a model of the arm.

    Args:
        interface: what the controller may know of the environment.
        settings: settings of the controller.

    Attributes:
        arm: arm model that the controller uses.
    """

    measured_fields: ClassVar[tuple[str, ...]] = MEASURED_MOTION

    def __init__(self, interface: ControlInterface, settings: SettingsT) -> None:
        super().__init__(interface, settings)
        if not isinstance(self.model, PRPArm):
            raise InvalidValueError("model", self.model, "the arm: a link has no pose")
        self.arm = self.model

    def desired(self, observed: Observed) -> PoseReference:
        """The reference as a motion of the end effector."""
        return self.references.pose(observed, self.arm)

    def measured(self, observed: Observed) -> ArmState:
        """The measured motion of the arm."""
        q = observed["joint_position"]
        return ArmState(
            q,
            observed["joint_velocity"],
            observed["end_effector_pose"],
            observed["end_effector_velocity"],
            self.arm.analytical_jacobian(q),
        )

    def resolved_torque(self, state: ArmState, acceleration: Array, damping: float = 0.0) -> Array:
        """τ = B y + n with y = J_A⁺(a - J̇_A q̇): the torque for an acceleration a of the end effector.

        J_A has full column rank everywhere (its smallest singular value over the workspace is above 0.7),
        so that the pseudoinverse needs no damping; q_3 = ±π/2 and L = 0, where the tip's position alone
        is singular, have no effect.

        Args:
            state: measured motion of the arm.
            acceleration: a (..., 6) per second squared.
            damping: λ of the pseudoinverse, in the units of J_A's singular values.

        Returns:
            (..., 3) [N m, N, N m].

        Source: [S] 3.5, 8.6.2.
        """
        joint_acceleration = solve_least_squares(state.jacobian, acceleration - self._drift(state), damping)
        return self._inverse_dynamics(state, joint_acceleration)

    def limited_torque(self, state: ArmState, acceleration: Array, damping: float = 0.0) -> Array:
        """Like `resolved_torque`, but no joint at its limit is commanded beyond it.

        A joint that lies within `LIMIT_MARGIN` of a limit, and that y would drive beyond it, is left out of
        J_A, so that the other joints realise a as well as they can without it. Otherwise its stop would
        absorb the acceleration y_i, and the inertial coupling would disturb the other joints.

        Args:
            state: measured motion of the arm.
            acceleration: a (..., 6) per second squared.
            damping: λ of the pseudoinverse, in the units of J_A's singular values.

        Returns:
            (..., 3) [N m, N, N m].

        Source: [S] 3.5.1, the constraint as an active set.
        """
        q, wanted = state.joint_position, acceleration - self._drift(state)
        at_lower = q <= np.array(self.arm.parameters.joint_lower) + LIMIT_MARGIN
        at_upper = q >= np.array(self.arm.parameters.joint_upper) - LIMIT_MARGIN
        joint_acceleration = solve_least_squares(state.jacobian, wanted, damping)
        blocked = np.zeros(q.shape, dtype=np.bool_)
        for _ in range(q.shape[-1]):  # every pass blocks at least one more joint, or ends the loop
            pressed = (at_lower & (joint_acceleration < 0.0)) | (at_upper & (joint_acceleration > 0.0))
            if not anywhere(pressed):
                break
            blocked = blocked | pressed
            free = np.where(blocked[..., None, :], 0.0, state.jacobian)
            held = solve_least_squares(free, wanted, max(damping, _HELD))
            joint_acceleration = np.where(
                blocked.any(axis=-1, keepdims=True), np.where(blocked, 0.0, held), joint_acceleration
            )
        return self._inverse_dynamics(state, joint_acceleration)

    def _drift(self, state: ArmState) -> Array:
        """J̇_A q̇ (..., 6)."""
        velocity = state.joint_velocity
        return apply(self.arm.analytical_jacobian_derivative(state.joint_position, velocity), velocity)

    def _inverse_dynamics(self, state: ArmState, joint_acceleration: Array) -> Array:
        q, velocity = state.joint_position, state.joint_velocity
        return apply(self.arm.inertia_matrix(q), joint_acceleration) + self.arm.bias_force(q, velocity)

    def contact_torque(self, state: ArmState, force: Any) -> Array:
        """Jᵀh_e: the torque that holds a force (..., 3) [N] by the tip on the surface."""
        return apply_transposed(state.jacobian[..., :3, :], force)


class OperationalStaticBaseline(OperationalBaseline[SettingsT], StaticBaseline[SettingsT]):
    """An operational-space controller without a state."""
