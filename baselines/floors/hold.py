"""The floor `hold`: the start pose is held, whatever the task asks for."""

from dataclasses import dataclass
from typing import ClassVar

from prp_gym.baselines.base.policy import Baseline, ControllerState, Observed
from prp_gym.baselines.base.settings import Settings
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.robot.arrays import Array, apply
from prp_gym.tasks.fields import ObservationLayout

_FASTEST = 0.1  # of bandwidth times control period, a quarter of what is stable with a one-step delay


@dataclass(frozen=True, eq=False)
class HoldSettings(Settings):
    """Settings of `HoldFloor`.

    Attributes:
        bandwidth: natural frequency ω of the position loop [rad/s].
    """

    bandwidth: float = 40.0

    numbers: ClassVar = {"bandwidth": "rad/s"}


class HoldFloor(Baseline[HoldSettings]):
    """τ = B(q) (ω² (q_0 - q) - 2 ω q̇) + n(q, q̇), with q_0 the first observed joint position.

    Inverse dynamics on the nominal model, critically damped, about the position in which an episode starts.
    The bandwidth ω is lowered to 0.1/dt at low control frequencies: under a zero-order hold with period dt
    and a one-step actuation delay the double integrator with these gains is stable for ω dt below about 0.4.

    Source: [S] 8.5.2.
    """

    measured_fields: ClassVar[tuple[str, ...]] = ("joint_position", "joint_velocity")
    settings_class = HoldSettings

    @classmethod
    def missing_fields(cls, layout: ObservationLayout) -> list[str]:
        """See `Baseline.missing_fields`; no reference is read."""
        return [name for name in cls.measured_fields if name not in layout.names]

    def initial_state(self, observed: Observed) -> ControllerState:
        """See `Baseline.initial_state`: the joint position at the start (..., joints)."""
        return (observed["joint_position"].copy(),)

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        bandwidth = min(self.settings.bandwidth, _FASTEST / self.interface.period)
        acceleration = bandwidth**2 * (state[0] - q) - 2 * bandwidth * velocity
        torque = apply(self.model.inertia_matrix(q), acceleration) + self.model.bias_force(q, velocity)
        return torque, state


HOLD = ControllerSpec(name="hold", summary="floor: the start pose is held", policy=HoldFloor)
