"""Closed forms of the contact experiments, registered in `FORMULAS`."""

import numpy as np

from prp_gym.reproduction.predictions import formula


@formula
def spring_force(controller_stiffness: float, surface_stiffness: float, depth: float) -> float:
    """Force of two springs in series: f = K_P K/(K_P + K) (x_d - x_e).

    Args:
        controller_stiffness: K_P along the normal, of the controller or of the compliant frame [N/m].
        surface_stiffness: K [N/m].
        depth: depth of the goal behind the surface, x_d - x_e [m].

    Returns:
        steady contact force [N].

    Source: [S] 9.2, 9.3: two springs in series; [R] 11 to 13.
    """
    return controller_stiffness * surface_stiffness / (controller_stiffness + surface_stiffness) * depth


@formula
def spring_position(
    controller_stiffness: float, surface_stiffness: float, desired: float, surface: float
) -> float:
    """Position of two springs in series: x = (K_P x_d + K x_e)/(K_P + K).

    Args:
        controller_stiffness: K_P along the normal [N/m].
        surface_stiffness: K [N/m].
        desired: x_d, coordinate of the goal along the normal [m].
        surface: x_e, coordinate of the surface at rest [m].

    Returns:
        steady coordinate [m].

    Source: [S] 9.2, 9.3: two springs in series; [R] 11 to 13.
    """
    total = controller_stiffness + surface_stiffness
    return (controller_stiffness * desired + surface_stiffness * surface) / total


@formula
def force_without_integral(
    origin: float, desired_force: float, surface: float, surface_stiffness: float, force_gain: float
) -> float:
    """Equilibrium of the proportional force loop: f = K (x_0 + K_F f_d - x_e)/(1 + K K_F).

    Args:
        origin: x_0, to which the force loop adds its offset, along the normal [m].
        desired_force: f_d [N].
        surface: x_e [m].
        surface_stiffness: K [N/m].
        force_gain: K_F [m/N].

    Returns:
        steady force of the inner position loop without an integral [N].

    Source: [S] 9.4.1; [R] 14.
    """
    pressed = surface_stiffness * (origin + force_gain * desired_force - surface)
    return pressed / (1.0 + surface_stiffness * force_gain)


@formula
def slowest_force_mode(
    force_gain: float,
    integral_gain: float,
    proportional_gain: float,
    derivative_gain: float,
    mass: float,
    surface_stiffness: float,
) -> float:
    """Smallest |s| of M_d s³ + K_D s² + K_P (1 + K K_F) s + K_P K K_I = 0.

    Args:
        force_gain: K_F [m/N].
        integral_gain: K_I [m/(N s)].
        proportional_gain: K_P of the inner loop [N/m].
        derivative_gain: K_D of the inner loop [N s/m].
        mass: M_d along the normal [kg].
        surface_stiffness: K [N/m].

    Returns:
        rate at which the force error decays in the end [1/s].

    Source: [S] 9.4.1, characteristic polynomial along the normal; [R] 14.
    """
    linear = proportional_gain * (1.0 + surface_stiffness * force_gain)
    roots = np.roots([mass, derivative_gain, linear, proportional_gain * surface_stiffness * integral_gain])
    return float(np.abs(roots).min())


@formula
def pressed_position(surface: float, desired_force: float, surface_stiffness: float) -> float:
    """Position at which the surface exerts f_d: x = x_e + f_d/K.

    Args:
        surface: x_e [m].
        desired_force: f_d [N].
        surface_stiffness: K [N/m].

    Returns:
        coordinate along the normal at which the surface answers with f_d [m].

    Source: [S] 9.1, elastic surface; [R] 14, 15.
    """
    return surface + desired_force / surface_stiffness
