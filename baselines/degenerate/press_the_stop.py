"""The degenerate policy `press_the_stop`: the slide is driven to its inner stop with full force."""

from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.floors.hold import HoldFloor
from prp_gym.robot.arrays import Array

_SLIDE = 1


class PressTheStopPolicy(HoldFloor):
    """The control law of `HoldFloor` for the rotations, and -τ_max for the slide."""

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        torque, state = super().control(observed, state)
        if torque.shape[-1] > _SLIDE:
            torque[..., _SLIDE] = -self.interface.torque_limit[_SLIDE]
        return torque, state


PRESS_THE_STOP = ControllerSpec(
    name="press_the_stop", summary="degenerate: the slide presses on its stop", policy=PressTheStopPolicy
)
