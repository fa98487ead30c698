"""prp_gym: Gymnasium environments and classical baselines for the three-joint PRP arm.

`import prp_gym` registers the environments, so that `gymnasium.make("PRP-JointTracking-v0")` works.
"""

import os
import sys

if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & set(os.environ):
    os.environ.setdefault("MUJOCO_GL", "egl")  # read once, when mujoco is first imported

from prp_gym.errors import PRPError
from prp_gym.registration import list_envs, register_environments
from prp_gym.robot import PRPArm, RobotParameters

__version__ = "0.1.0"

register_environments()

__all__ = [
    "PRPArm",
    "PRPError",
    "RobotParameters",
    "__version__",
    "list_envs",
]
