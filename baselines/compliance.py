"""Compliance control: a spring and a damper between the end effector and its reference."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.operational import OperationalStaticBaseline
from prp_gym.baselines.base.policy import Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply, apply_transposed


@dataclass(frozen=True, eq=False)
class ComplianceSettings(Settings):
    """Settings of `ComplianceController`, along the axes of the desired frame and of its Euler angles.

    Attributes:
        stiffness: K_P (6), diagonal [N/m, ..., N m/rad, ...].
        damping: K_D (6), diagonal [N s/m, ..., N m s/rad, ...].
    """

    stiffness: Any
    damping: Any

    vectors: ClassVar = {
        "stiffness": Vector("pose", "N/m (3), N·m/rad (3)"),
        "damping": Vector("pose", "N·s/m (3), N·m·s/rad (3)"),
    }


class ComplianceController(OperationalStaticBaseline[ComplianceSettings]):
    """τ = g(q) + J_Adᵀ (K_P x̃ - K_D J_Ad q̇), J_Ad = T_d J_A, x̃ = T_d (x_d - x), T_d = blkdiag(R_dᵀ, I).

    R_d is the orientation of the desired frame, from the ZXZ angles of x_d: the position error and its rate
    are resolved along the axes of that frame, while errors of the Euler angles are taken as they are. The
    controller measures no force. At rest under a force h_e by the tip on the surface J_Adᵀ(K_P x̃ - T_d h_A)
    = 0, h_A = (h_e, 0): the tip gives way as springs K_P along the desired axes would, as far as three joints
    permit; a surface of stiffness K at a depth d before the reference is pressed with K K_P/(K + K_P) d.

    In continuous time, without torque limits, with a constant x_d that the arm can attain and a passive
    surface, the equilibrium is asymptotically stable for any positive K_P and K_D (Lyapunov function
    ½ q̇ᵀBq̇ + ½ x̃ᵀK_P x̃ + the surface's energy); K_D opposes a moving reference. The remarks at
    `OperationalPDController` on the direction of rotation and on the sampled loop apply here, too.

    Source: [S] 9.2.1; [R] 11.
    """

    settings_class = ComplianceSettings
    rendered = ("stiffness",)

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired, state = self.desired(observed), self.measured(observed)
        axes = _axes_of_pose(desired.pose)
        spring = self.settings.stiffness * _resolved(axes, desired.pose - state.pose)
        damper = self.settings.damping * _resolved(axes, state.velocity)
        force = spring - damper
        force[..., :3] = apply(axes, force[..., :3])
        return self.arm.gravity_vector(state.joint_position) + apply_transposed(state.jacobian, force)


def _resolved(axes: Array, vector: Array) -> Array:
    """T_d times a pose vector: its first three components along `axes`."""
    return np.concatenate([apply_transposed(axes, vector[..., :3]), vector[..., 3:]], axis=-1)


def _axes_of_pose(pose: Array) -> Array:
    """R_d (..., 3, 3) = R_z(α) R_x(β) R_z(γ) of a pose (..., 6).

    Source: [S] 2.4.
    """
    sine, cosine = np.sin(pose[..., 3:]), np.cos(pose[..., 3:])
    s_a, s_b, s_c = (sine[..., index] for index in range(3))
    c_a, c_b, c_c = (cosine[..., index] for index in range(3))
    rows = (
        (c_a * c_c - s_a * c_b * s_c, -c_a * s_c - s_a * c_b * c_c, s_a * s_b),
        (s_a * c_c + c_a * c_b * s_c, -s_a * s_c + c_a * c_b * c_c, -c_a * s_b),
        (s_b * s_c, s_b * c_c, c_b),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


register_controller(
    ControllerSpec(
        name="compliance",
        summary="compliance control: spring and damper in the desired frame, without force measurement",
        policy=ComplianceController,
        data=ControllerData.beside(__file__, target_impedance_sets=("tuned",)),
        command_inputs=("pose_offset",),
        chapter=11,
    )
)
