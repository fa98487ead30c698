"""Operational-space PD control with gravity compensation."""

from dataclasses import dataclass
from typing import Any, ClassVar

from prp_gym.baselines.base.operational import OperationalStaticBaseline
from prp_gym.baselines.base.policy import Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply_transposed


@dataclass(frozen=True, eq=False)
class OperationalPDSettings(Settings):
    """Settings of `OperationalPDController`.

    Attributes:
        proportional_gain: K_P (6), diagonal [N/m, ..., N m/rad, ...].
        derivative_gain: K_D (6), diagonal [N s/m, ..., N m s/rad, ...].
    """

    proportional_gain: Any
    derivative_gain: Any

    vectors: ClassVar = {
        "proportional_gain": Vector("pose", "N/m (3), N·m/rad (3)"),
        "derivative_gain": Vector("pose", "N·s/m (3), N·m·s/rad (3)"),
    }


class OperationalPDController(OperationalStaticBaseline[OperationalPDSettings]):
    """τ = g(q) + J_Aᵀ (K_P x̃ + K_D (ẋ_d - ẋ)), with x̃ = x_d - x and ẋ = J_A q̇.

    In continuous time, without torque limits, and for a constant x_d that the arm can attain, x̃ = 0 is
    asymptotically stable for any positive K_P and K_D (Lyapunov function ½ q̇ᵀBq̇ + ½ x̃ᵀK_P x̃; J_A has full
    column rank). It need not be the only equilibrium: angles are not wrapped, so that joint 1 is turned the
    way of its angle, while the spring at the tip pulls it the short way round. With the other joints at
    their goals there is no second one if the stiffness of α exceeds 0.22 R² times that of the tip; R, the
    tip's distance from joint 1's axis, is at most 0.67 m (for β and joint 3, a_3 in place of R). A moving
    reference is followed with an error, since inertia and Coriolis forces are not compensated.

    Held over a control period dt, the loop also needs the eigenvalues of B⁻¹J_AᵀK_D J_A dt well below 2. The
    critical joint is 3, which feels K_D of β and a_3² cos²q_3 times that of the tip, against an inertia of
    down to 0.0096 kg m² (at q_3 = ±π/2).

    Source: [S] 8.6.1; [R] 9, whose x_d is constant.
    """

    settings_class = OperationalPDSettings

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired, state = self.desired(observed), self.measured(observed)
        spring = self.settings.proportional_gain * (desired.pose - state.pose)
        damper = self.settings.derivative_gain * (desired.velocity - state.velocity)
        return self.arm.gravity_vector(state.joint_position) + apply_transposed(
            state.jacobian, spring + damper
        )


register_controller(
    ControllerSpec(
        name="operational_pd",
        summary="operational-space PD with gravity compensation",
        policy=OperationalPDController,
        data=ControllerData.beside(__file__),
        command_inputs=("pose_offset",),
        chapter=9,
    )
)
