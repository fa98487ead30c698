"""PRP-Force-v0: press on a surface with a given force."""

from typing import ClassVar

from prp_gym.envs.base.force_task import ForceOptions, ForceTask
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.robot.arrays import Array
from prp_gym.tasks.trajectory import Constant, Trajectory


class Force(ForceTask):
    """Press with f_d and hold the rest. Source: [R] 14; [S] 9.4.2."""

    environment_id = "PRP-Force-v0"
    reset_options: ClassVar = {k: v for k, v in ForceTask.reset_options.items() if k != "goal"}

    def draw_reference(self, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
        """The start, held."""
        return Constant(start[None])


class ForceEnv(PRPEnv):
    """Press on a surface with a given force and hold the rest of the pose.

    The tip starts off the surface. Scored are the force along the surface's normal, and the deviation from
    the initial pose in the other directions. Scenario `report` starts at home, asks for 1 N along +y, and
    puts the surface, of 5 N/m, at y = -0.44 m; with that force the slide ends on its limit, q_2 = -0.3 m.
    """

    task_class = Force
    options_class = ForceOptions


class ForceVectorEnv(PRPVectorEnv):
    """Many of `ForceEnv`, stepped together."""

    environment_class = ForceEnv
