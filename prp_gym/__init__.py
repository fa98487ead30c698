"""prp_gym: Gymnasium environments and classical baselines for the three-joint PRP arm.

`import prp_gym` registers the environments, so that `gymnasium.make("PRP-JointTracking-v0")` works.
"""

import os
import sys
from ctypes.util import find_library

if sys.platform == "linux" and not any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL"))):
    if find_library("EGL"):  # without it mujoco itself could not be imported
        os.environ["MUJOCO_GL"] = "egl"  # read once, when mujoco is first imported

from importlib import import_module
from typing import TYPE_CHECKING, Any

from prp_gym.errors import PRPError
from prp_gym.robot import PRPArm, RobotParameters
from prp_gym.tasks.registration import list_envs, register_environments, register_task

if TYPE_CHECKING:
    from prp_gym.agents.algorithms import register_algorithm
    from prp_gym.agents.policy.agent_file import list_agents, load_agent
    from prp_gym.agents.sb3.make_vec_env import make_sb3_vec_env
    from prp_gym.baselines.base.function_controller import controller
    from prp_gym.baselines.base.make import list_baselines, make_baseline
    from prp_gym.baselines.base.spec import ControllerSpec, register_controller
    from prp_gym.envs.action_mode import ActionModeSpec, register_action_mode
    from prp_gym.evaluation.evaluate import evaluate
    from prp_gym.evaluation.metrics import register_metric
    from prp_gym.gradients.score_gradient import score_gradient
    from prp_gym.linearization.linearize import linearize
    from prp_gym.plugins import load_plugins

__version__ = "0.1.0"

__all__ = [
    "ActionModeSpec",
    "ControllerSpec",
    "PRPArm",
    "PRPError",
    "RobotParameters",
    "__version__",
    "controller",
    "evaluate",
    "linearize",
    "list_agents",
    "list_baselines",
    "list_envs",
    "load_agent",
    "load_plugins",
    "make_baseline",
    "make_sb3_vec_env",
    "register_action_mode",
    "register_algorithm",
    "register_controller",
    "register_metric",
    "register_task",
    "score_gradient",
]

_IMPORTED_ON_USE = {
    "ActionModeSpec": "prp_gym.envs.action_mode",
    "ControllerSpec": "prp_gym.baselines.base.spec",
    "controller": "prp_gym.baselines.base.function_controller",
    "evaluate": "prp_gym.evaluation.evaluate",
    "linearize": "prp_gym.linearization.linearize",
    "list_agents": "prp_gym.agents.policy.agent_file",
    "list_baselines": "prp_gym.baselines.base.make",
    "load_agent": "prp_gym.agents.policy.agent_file",
    "load_plugins": "prp_gym.plugins",
    "make_baseline": "prp_gym.baselines.base.make",
    "make_sb3_vec_env": "prp_gym.agents.sb3.make_vec_env",
    "register_algorithm": "prp_gym.agents.algorithms",
    "register_metric": "prp_gym.evaluation.metrics",
    "register_action_mode": "prp_gym.envs.action_mode",
    "register_controller": "prp_gym.baselines.base.spec",
    "score_gradient": "prp_gym.gradients.score_gradient",
}

register_environments()


def __getattr__(name: str) -> Any:
    """Names whose modules are imported on first use, so that `import prp_gym` stays light."""
    if name in _IMPORTED_ON_USE:
        return getattr(import_module(_IMPORTED_ON_USE[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_IMPORTED_ON_USE})
