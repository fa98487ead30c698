"""PRP-Compliance-v0: give way to a surface as a spring does."""

from prp_gym.envs.base.rendering_task import StaticRenderingTask, StiffnessOptions
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv


class Compliance(StaticRenderingTask):
    """Statically K_P x̃ = h_e. Source: [R] 11; [S] 9.2.1."""

    environment_id = "PRP-Compliance-v0"


class ComplianceEnv(PRPEnv):
    """Give way to a surface as a spring of given stiffness does.

    The desired pose lies behind the surface. Scored is the distance of the tip from x_d - K_P⁻¹h_e, where a
    spring K_P that holds the tip at x_d would leave it under the contact force h_e of now. Scenario
    `report` starts at home, asks for the pose of (0 rad, -0.2 m, 0 rad), and puts the surface at
    y = -0.44 m with its free side at y < -0.44 m.
    """

    task_class = Compliance
    options_class = StiffnessOptions


class ComplianceVectorEnv(PRPVectorEnv):
    """Many of `ComplianceEnv`, stepped together."""

    environment_class = ComplianceEnv
