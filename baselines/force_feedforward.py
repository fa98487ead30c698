"""Feed-forward force control: the desired force is applied, and no force is measured."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.force_integral import ForceError
from prp_gym.baselines.base.operational import MEASURED_MOTION, OperationalStaticBaseline
from prp_gym.baselines.base.policy import Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceFeedforwardSettings(Settings):
    """Settings of `ForceFeedforwardController`.

    Attributes:
        derivative_gain: K_D (pose) of the motion control, diagonal [1/s].
        proportional_gain: K_P (pose) of the motion control, diagonal [1/s^2].
        approach_damping: damping d of the motion along the desired force [N s/m].
    """

    derivative_gain: Any
    proportional_gain: Any
    approach_damping: float = 30.0

    vectors: ClassVar = {
        "derivative_gain": Vector("pose", "1/s"),
        "proportional_gain": Vector("pose", "1/s²"),
    }
    numbers: ClassVar = {"approach_damping": "N·s/m"}


class ForceFeedforwardController(OperationalStaticBaseline[ForceFeedforwardSettings]):
    """τ = B J_A⁺(a - J̇_A q̇) + n + Jᵀ(f_d - d n nᵀ ṗ), a = P (ẍ_d + K_D (ẋ_d - ẋ) + K_P (x_d - x)).

    n = f_d/|f_d| points into the surface, P leaves out the component along n, p is the position of the tip.
    Off the surface the tip moves along n at the speed |f_d|/d at last; on a spring K and with the mass m of
    the arm along n it obeys m ẍ + d ẋ + K x = |f_d|: stable for any d > 0 and any passive surface, with the
    exact force at rest and the damping ratio d/(2 √(m K)). After the touch the force peaks below
    |f_d| (1 + √(1 + K m/d²)). Errors of the model's gravity, and friction, are errors of the force:
    nothing measures it. Held over a period dt the damping needs d dt < 2 m, with m down to 0.26 kg, and the
    motion control K_D dt < 2, K_P dt < 2 K_D.

    Source: [S] 9.4, without its force feedback; Whitney 1987, open-loop force.
    """

    measured_fields = (*MEASURED_MOTION, "desired_force")
    settings_class = ForceFeedforwardSettings

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired, state = self.desired(observed), self.measured(observed)
        force = observed["desired_force"] + observed.get("force_offset", 0.0)
        push = ForceError.of(force, np.zeros(force.shape))
        acceleration = (
            desired.acceleration
            + self.settings.derivative_gain * (desired.velocity - state.velocity)
            + self.settings.proportional_gain * (desired.pose - state.pose)
        )
        acceleration[..., :3] -= push.axis * push.along(acceleration[..., :3])
        damper = self.settings.approach_damping * push.axis * push.along(state.velocity[..., :3])
        return self.resolved_torque(state, acceleration) + self.contact_torque(state, force - damper)


register_controller(
    ControllerSpec(
        name="force_feedforward",
        summary="feed-forward of the desired force with damping, without force measurement",
        policy=ForceFeedforwardController,
        data=ControllerData.beside(__file__),
        command_inputs=("pose_offset", "force_offset"),
    )
)
