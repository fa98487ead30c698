"""`Ghost`: the robot at the joint positions of the reference."""

from dataclasses import dataclass

from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.palette import SKY_BLUE, rgba
from prp_gym.robot.arrays import Array

_COLOR = rgba(SKY_BLUE, 0.17)
_GROWTH = 0.005  # [m]: so that it encloses an arm that follows it exactly


@dataclass(frozen=True, eq=False)
class Ghost(OverlayItem):
    """The robot, translucent, at other joint positions.

    Attributes:
        joint_position: Joint positions of the reference (joints) [rad, m, rad].
    """

    joint_position: Array

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        canvas.ghost(self.joint_position, _GROWTH, _COLOR)
