"""PRP-Impedance-v0: behave as a mass, damper and spring towards a surface."""

from prp_gym.envs.base.rendering_task import DynamicRenderingTask, TargetOptions
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv


class Impedance(DynamicRenderingTask):
    """M_d x̃¨ + K_D x̃˙ + K_P x̃ = h_e. Source: [R] 12; [S] 9.3.1."""

    environment_id = "PRP-Impedance-v0"


class ImpedanceEnv(PRPEnv):
    """Behave towards a surface as a mass, damper and spring does.

    The reference moves to a pose behind the surface. Scored is the distance of the tip from the target model,
    which the contact force drives along the same reference. Scenario `report` moves from home to the
    pose of (0 rad, -0.2 m, 0 rad) in 1 s, with the surface at y = -0.44 m.
    """

    task_class = Impedance
    options_class = TargetOptions


class ImpedanceVectorEnv(PRPVectorEnv):
    """Many of `ImpedanceEnv`, stepped together."""

    environment_class = ImpedanceEnv
