"""Joint-space inverse dynamics control (computed torque)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from prp_gym.baselines.policy import ModelBaseline, ModelSettings
from prp_gym.robot.arrays import Array, apply


@dataclass(frozen=True, eq=False)
class JointInverseDynamicsSettings(ModelSettings):
    """Numbers of `JointInverseDynamics`.

    Attributes:
        proportional_gain: K_P (3), diagonal [1/s^2].
        derivative_gain: K_D (3), diagonal [1/s].
        model: of the arm; it may differ from the plant.
    """

    proportional_gain: Any
    derivative_gain: Any

    def __post_init__(self) -> None:
        super().__post_init__()
        self._make_vector("proportional_gain", "1/s²")
        self._make_vector("derivative_gain", "1/s")


class JointInverseDynamics(ModelBaseline[JointInverseDynamicsSettings]):
    """τ = B(q) y + n(q, q̇), y = q̈_d + K_D (q̇_d - q̇) + K_P (q_d - q), n = C q̇ + F_v q̇ + F_s sign(q̇) + g.

    With the exact model every joint obeys q̃¨ + K_D q̃˙ + K_P q̃ = 0 on its own: natural frequency √K_P,
    damping ratio K_D/(2√K_P), stable for any positive gains in continuous time. Under an exact zero-order
    hold with period dt the double integrator needs K_D dt < 2 and K_P dt² < 2 K_D dt; the compensation, held
    too, and a late torque lower these bounds. With a wrong model the error is bounded
    where the inertia estimate is near enough to the true one, but does not vanish.

    Source: [S] 8.5.2; [R] 7.
    """

    name = "joint_inverse_dynamics"
    summary = "joint-space inverse dynamics (computed torque)"
    required_fields = (
        "joint_position",
        "joint_velocity",
        "desired_joint_position",
        "desired_joint_velocity",
        "desired_joint_acceleration",
    )
    settings_class = JointInverseDynamicsSettings

    def torque(self, observed: Mapping[str, Array]) -> Array:
        """See the class."""
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        K_P, K_D = self.settings.proportional_gain, self.settings.derivative_gain
        acceleration = (
            observed["desired_joint_acceleration"]
            + K_D * (observed["desired_joint_velocity"] - velocity)
            + K_P * (observed["desired_joint_position"] - q)
        )
        return apply(self.arm.inertia_matrix(q), acceleration) + self.arm.bias_force(q, velocity)
