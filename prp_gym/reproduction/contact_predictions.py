"""Closed forms of the contact experiments, entered among `FORMULAS`."""

import math

import numpy as np

from prp_gym.reproduction.predictions import formula
from prp_gym.robot.parameters import NOMINAL


@formula
def spring_force(controller_stiffness: float, surface_stiffness: float, depth: float) -> float:
    """Force of two springs in series: f = K_P K/(K_P + K) (x_d - x_e).

    Args:
        controller_stiffness: K_P along the normal, of the law or of the compliant frame [N/m].
        surface_stiffness: K [N/m].
        depth: of the goal behind the surface, x_d - x_e [m].

    Returns:
        steady contact force [N].

    Source: [S] 9.2, 9.3: two springs in series; [R] 11 to 13.
    """
    return controller_stiffness * surface_stiffness / (controller_stiffness + surface_stiffness) * depth


@formula
def spring_position(
    controller_stiffness: float, surface_stiffness: float, desired: float, surface: float
) -> float:
    """Place of two springs in series: x = (K_P x_d + K x_e)/(K_P + K).

    Args:
        controller_stiffness: K_P along the normal [N/m].
        surface_stiffness: K [N/m].
        desired: x_d, coordinate of the goal along the normal [m].
        surface: x_e, that of the surface at rest [m].

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
    start: float,
    desired: float,
    surface: float,
) -> float:
    """First peak of K (y - y_e), where m ÿ + K_D ẏ + K_P (y - y_d) + K max(y - y_e, 0) = 0, m = m_2 + m_3.

    At q_1 = q_3 = 0 the arm is this one mass along y, and nothing couples it to the other joints: free from
    rest until it touches the surface, then with the surface's spring.

    Args:
        proportional_gain: K_P along y [N/m].
        derivative_gain: K_D along y [N s/m].
        surface_stiffness: K [N/m].
        start: y(0), at rest, on the free side [m].
        desired: y_d, beyond the surface [m].
        surface: y_e [m].

    Returns:
        peak force [N].

    Source: [S] 9.2.1, its one-degree-of-freedom example; [R] 11.
    """
    mass = NOMINAL.link_mass[1] + NOMINAL.link_mass[2]
    free = _Oscillator(mass, derivative_gain, proportional_gain, desired, start, 0.0)
    touch = _first_crossing(free, surface)
    rest = spring_position(proportional_gain, surface_stiffness, desired, surface)
    stiffness = proportional_gain + surface_stiffness
    pressed = _Oscillator(mass, derivative_gain, stiffness, rest, surface, free.velocity(touch))
    return surface_stiffness * (pressed.position(pressed.first_rest()) - surface)


class _Oscillator:
    """m ẍ + c ẋ + k (x - x_s) = 0, underdamped, from a position and a velocity."""

    def __init__(
        self, mass: float, damping: float, stiffness: float, rest: float, position: float, velocity: float
    ) -> None:
        self.rest = rest
        self.decay = damping / (2.0 * mass)
        self.rate = math.sqrt(stiffness / mass - self.decay**2)
        self.cosine = position - rest
        self.sine = (velocity + self.decay * self.cosine) / self.rate

    def position(self, time: float) -> float:
        angle = self.rate * time
        swing = self.cosine * math.cos(angle) + self.sine * math.sin(angle)
        return self.rest + math.exp(-self.decay * time) * swing

    def velocity(self, time: float) -> float:
        angle = self.rate * time
        cosine = self.rate * self.sine - self.decay * self.cosine
        sine = -self.rate * self.cosine - self.decay * self.sine
        return math.exp(-self.decay * time) * (cosine * math.cos(angle) + sine * math.sin(angle))

    def first_rest(self) -> float:
        """The first time after the start at which the velocity is zero."""
        cosine = self.rate * self.sine - self.decay * self.cosine
        sine = -self.rate * self.cosine - self.decay * self.sine
        angle = math.atan2(-cosine, sine) % math.pi
        return (angle or math.pi) / self.rate


def _first_crossing(motion: _Oscillator, level: float) -> float:
    """When a motion that rises from rest first passes a level, by bisection."""
    low, high = 0.0, math.pi / motion.rate
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if motion.position(middle) < level else (low, middle)
    return high


@formula
def force_without_integral(
    origin: float, desired_force: float, surface: float, surface_stiffness: float, force_gain: float
) -> float:
    """Rest of the proportional force loop: f = K (x_0 + K_F f_d - x_e)/(1 + K K_F).

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
    """Where the surface answers with f_d: x = x_e + f_d/K.

    Args:
        surface: x_e [m].
        desired_force: f_d [N].
        surface_stiffness: K [N/m].

    Returns:
        coordinate along the normal at which the surface answers with f_d [m].

    Source: [S] 9.1, elastic surface; [R] 14, 15.
    """
    return surface + desired_force / surface_stiffness
