"""What the closed form takes of an arm's masses and friction, as formulas over leading axes."""

from dataclasses import fields

import numpy as np

from prp_gym.physics.closed_form import PlantArm
from prp_gym.robot.arrays import Array, dot, solve_symmetric, zeros
from prp_gym.robot.dynamics import BaseParameters
from prp_gym.robot.parameters import NOMINAL, RobotParameters


def plant_row(mass_factor: Array, viscous_friction: Array, coulomb_friction: Array) -> Array:
    """The columns `PLANT` of nominal arms with other masses and friction (..., `PLANT_SIZE`).

    Args:
        mass_factor: Factors (..., 3) of each link's mass and inertia.
        viscous_friction: F_v (..., 3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: F_s (..., 3) [N m, N, N m].
    """
    base = base_parameters(NOMINAL, mass_factor)
    weights = inverse_weights(PlantArm(base, viscous_friction), zeros(mass_factor.shape, mass_factor))
    columns = np.stack([getattr(base, entry.name) for entry in fields(BaseParameters)], axis=-1)
    return np.concatenate([columns, viscous_friction, *weights, coulomb_friction], axis=-1)


def base_parameters(parameters: RobotParameters, mass_factor: Array) -> BaseParameters:
    """The base parameters of arms whose links are heavier by factors (..., 3), arrays (...) each."""
    factors = [mass_factor[..., index] for index in range(3)]
    links = list(zip(factors, parameters.link_mass, parameters.link_inertia, strict=True))
    masses = [factor * mass for factor, mass, _ in links]
    inertias = [[factor * moment for moment in moments] for factor, _, moments in links]
    return BaseParameters.of_links(parameters.geometry, masses, inertias)


def inverse_weights(arm: PlantArm, home: Array) -> tuple[Array, Array]:
    """MuJoCo's `dof_invweight0` (..., 3) and that of the third link's translation (..., 1).

    Args:
        arm: Arms.
        home: q = 0 (..., 3).

    Source: [M] Computation, Solver parameters: diag B⁻¹, and the mean of diag J B⁻¹Jᵀ with the Jacobian J of
        the link's centre of mass, at q = 0.
    """
    geometry = arm.parameters.geometry
    B = arm.inertia_matrix(home)
    inverse = np.stack([solve_symmetric(B, column + home) for column in np.eye(3)], axis=-1)
    reach, a_1 = geometry.slide_offset + geometry.third_link_center_of_mass, geometry.first_link_offset
    J = np.array([[reach, 0.0, 0.0], [a_1, -1.0, 0.0], [0.0, 0.0, geometry.third_link_center_of_mass]])
    spread = [dot(row, np.stack([dot(inverse[..., i, :], row) for i in range(3)], axis=-1)) for row in J]
    mean = (spread[0] + spread[1] + spread[2]) / 3.0
    return np.stack([inverse[..., i, i] for i in range(3)], axis=-1), mean[..., None]
