"""Joint-space PD control with gravity compensation."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from prp_gym.baselines.policy import ModelBaseline, ModelSettings
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array

GRAVITY_MODES = ("current", "desired", "none")


@dataclass(frozen=True, eq=False)
class JointPDSettings(ModelSettings):
    """Numbers of `JointPD`.

    Attributes:
        proportional_gain: K_P (3), diagonal [N m/rad, N/m, N m/rad].
        derivative_gain: K_D (3), diagonal [N m s/rad, N s/m, N m s/rad].
        gravity: `current` compensates g(q), `desired` g(q_d), `none` nothing.
        model: of the arm, for gravity.
    """

    proportional_gain: Any
    derivative_gain: Any
    gravity: str = "current"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._make_vector("proportional_gain", "N·m/rad, N/m, N·m/rad")
        self._make_vector("derivative_gain", "N·m·s/rad, N·s/m, N·m·s/rad")
        if self.gravity not in GRAVITY_MODES:
            raise UnknownNameError("gravity mode", self.gravity, GRAVITY_MODES)


class JointPD(ModelBaseline[JointPDSettings]):
    """τ = g + K_P q̃ + K_D (q̇_d - q̇), with q̃ = q_d - q.

    g is g(q), g(q_d) or left out. In continuous time, without torque limits, and for a constant reference:
    with g(q) the equilibrium q̃ = 0 is globally asymptotically stable for any positive K_P and K_D
    (Lyapunov function ½ q̇ᵀBq̇ + ½ q̃ᵀK_P q̃); with g(q_d) it is so if K_P exceeds the gravity gradient,
    0.96 N m/rad in joint 3; without g joint 3 sags to where K_P q̃ = g. A moving reference is followed with
    an error, since inertia and Coriolis forces are not compensated. Held over a control period dt, the gains
    must also keep the sampled loop stable: K_D dt must stay well below twice the inertia that a joint feels,
    down to 0.0096 kg m² in joint 3 (at q_3 = ±π/2, where the slide yields to it).

    Source: [S] 8.5.1; [R] 6.
    """

    name = "joint_pd"
    summary = "joint-space PD with gravity compensation"
    required_fields = (
        "joint_position",
        "joint_velocity",
        "desired_joint_position",
        "desired_joint_velocity",
    )
    settings_class = JointPDSettings

    def torque(self, observed: Mapping[str, Array]) -> Array:
        """See the class."""
        position_error = observed["desired_joint_position"] - observed["joint_position"]
        velocity_error = observed["desired_joint_velocity"] - observed["joint_velocity"]
        K_P, K_D = self.settings.proportional_gain, self.settings.derivative_gain
        torque: Array = self._gravity(observed) + K_P * position_error + K_D * velocity_error
        return torque

    def _gravity(self, observed: Mapping[str, Array]) -> Array:
        if self.settings.gravity == "current":
            return self.arm.gravity_vector(observed["joint_position"])
        if self.settings.gravity == "desired":
            return self.arm.gravity_vector(observed["desired_joint_position"])
        return np.zeros(observed["joint_position"].shape)
