"""Joint-space PD control with gravity compensation."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.policy import Observed, StaticBaseline
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array

GRAVITY_MODES = ("current", "desired", "none")


@dataclass(frozen=True, eq=False)
class JointPDSettings(Settings):
    """Settings of `JointPDController`.

    Attributes:
        proportional_gain: K_P (joints), diagonal [N m/rad, N/m, N m/rad].
        derivative_gain: K_D (joints), diagonal [N m s/rad, N s/m, N m s/rad].
        gravity: `current` compensates g(q), `desired` g(q_d), `none` nothing.
    """

    proportional_gain: Any
    derivative_gain: Any
    gravity: str = "current"

    vectors: ClassVar = {
        "proportional_gain": Vector("joint", "N·m/rad, N/m, N·m/rad"),
        "derivative_gain": Vector("joint", "N·m·s/rad, N·s/m, N·m·s/rad"),
    }
    choices: ClassVar = {"gravity": GRAVITY_MODES}


class JointPDController(StaticBaseline[JointPDSettings]):
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

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = JointPDSettings

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired = self.references.joint(observed)
        q = observed["joint_position"]
        position_error, velocity_error = desired.position - q, desired.velocity - observed["joint_velocity"]
        K_P, K_D = self.settings.proportional_gain, self.settings.derivative_gain
        torque: Array = self._gravity(q, desired.position) + K_P * position_error + K_D * velocity_error
        return torque

    def _gravity(self, q: Array, desired: Array) -> Array:
        if self.settings.gravity == "current":
            return self.model.gravity_vector(q)
        if self.settings.gravity == "desired":
            return self.model.gravity_vector(desired)
        return np.zeros(q.shape)


register_controller(
    ControllerSpec(
        name="joint_pd",
        summary="joint-space PD with gravity compensation",
        policy=JointPDController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
        chapter=6,
    )
)
