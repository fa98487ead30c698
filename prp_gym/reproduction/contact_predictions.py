"""Closed forms of the contact experiments, registered in `FORMULAS`."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.reproduction.predictions import formula
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import NOMINAL
from prp_gym.tasks.trajectory import QuinticWaypoints

_STEP = 2e-4  # s; half of it changes no force by more than 1e-5 of itself
_HORIZON = 3.0  # s


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
def compliance_peak_force(
    proportional_gain: float,
    derivative_gain: float,
    surface_stiffness: float,
    surface: float,
    start: float,
    desired: float,
) -> float:
    """Largest force of m ÿ + K_D ẏ + K_P (y - y_d) + K max(y - y_e, 0) = 0, m = m_2 + m_3.

    At q_1 = q_3 = 0 the arm is this one mass along y, and nothing couples it to the other joints.

    Args:
        proportional_gain: K_P along y [N/m].
        derivative_gain: K_D along y [N s/m].
        surface_stiffness: K [N/m].
        surface: y_e; the free side is below it [m].
        start: y(0), at rest [m].
        desired: y_d [m].

    Returns:
        largest contact force [N].

    Source: [S] 9.2.1; [R] 11.
    """
    mass = NOMINAL.link_mass[1] + NOMINAL.link_mass[2]
    target = (mass, derivative_gain, proportional_gain)
    return max(_model_forces(target, surface_stiffness, surface, (0.0, 1.0), (desired, desired), start))


@formula
def model_peak_force(
    target: Sequence[float],
    surface_stiffness: float,
    surface: float,
    times: Sequence[float],
    positions: Sequence[float],
) -> float:
    """Largest force of M (ÿ_d - ÿ) + K_D (ẏ_d - ẏ) + K_P (y_d - y) = K max(y - y_e, 0).

    Args:
        target: M [kg], K_D [N s/m] and K_P [N/m] along y.
        surface_stiffness: K [N/m].
        surface: y_e; the free side is below it [m].
        times: times of the reference's waypoints; quintic segments between them [s].
        positions: positions of the waypoints along y; at rest on the first one at t = 0 [m].

    Returns:
        largest contact force [N].

    Source: [S] 9.3.1, 9.3.2, integrated to fourth order; [R] 12, 13.
    """
    return max(
        _model_forces(tuple(target), surface_stiffness, surface, tuple(times), tuple(positions), positions[0])
    )


@formula
def model_force_at(
    time: float,
    target: Sequence[float],
    surface_stiffness: float,
    surface: float,
    times: Sequence[float],
    positions: Sequence[float],
) -> float:
    """Force at t of M (ÿ_d - ÿ) + K_D (ẏ_d - ẏ) + K_P (y_d - y) = K max(y - y_e, 0).

    Args:
        time: t [s].
        target: M [kg], K_D [N s/m] and K_P [N/m] along y.
        surface_stiffness: K [N/m].
        surface: y_e; the free side is below it [m].
        times: times of the reference's waypoints; quintic segments between them [s].
        positions: positions of the waypoints along y; at rest on the first one at t = 0 [m].

    Returns:
        contact force [N].

    Raises:
        InvalidValueError: a time outside the 3 s that are integrated.

    Source: [S] 9.3.1, 9.3.2, integrated to fourth order; [R] 12, 13.
    """
    if not 0.0 <= time <= _HORIZON:
        raise InvalidValueError("time", time, f"from 0 to {_HORIZON:g}", "s")
    forces = _model_forces(
        tuple(target), surface_stiffness, surface, tuple(times), tuple(positions), positions[0]
    )
    return forces[round(time / _STEP)]


Scalars = tuple[float, ...]


@cache
def _model_forces(
    target: Scalars, stiffness: float, surface: float, times: Scalars, positions: Scalars, start: float
) -> list[float]:
    """Contact forces every `_STEP` from 0 to `_HORIZON`, both included, of a mass that starts at rest."""
    mass, damping, spring = target
    rows = QuinticWaypoints(np.array([times]), np.array([[[value] for value in positions]]))
    half_steps: Array = np.arange(2 * round(_HORIZON / _STEP) + 1, dtype=np.float64) * (_STEP / 2)
    reference: list[list[float]] = rows.sample(half_steps[:, None])[:, 0].tolist()

    def acceleration(index: int, position: float, velocity: float) -> float:
        desired, rate, feedforward = reference[index]
        force = stiffness * max(position - surface, 0.0)
        return feedforward + (damping * (rate - velocity) + spring * (desired - position) - force) / mass

    y, v, forces = start, 0.0, []
    for index in range(0, len(reference) - 2, 2):
        forces.append(stiffness * max(y - surface, 0.0))
        a_1, v_2 = acceleration(index, y, v), v + _STEP / 2 * acceleration(index, y, v)
        a_2 = acceleration(index + 1, y + _STEP / 2 * v, v_2)
        v_3 = v + _STEP / 2 * a_2
        a_3 = acceleration(index + 1, y + _STEP / 2 * v_2, v_3)
        v_4 = v + _STEP * a_3
        a_4 = acceleration(index + 2, y + _STEP * v_3, v_4)
        y += _STEP / 6 * (v + 2 * v_2 + 2 * v_3 + v_4)
        v += _STEP / 6 * (a_1 + 2 * a_2 + 2 * a_3 + a_4)
    return [*forces, stiffness * max(y - surface, 0.0)]


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
