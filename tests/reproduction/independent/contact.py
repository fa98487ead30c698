"""The controllers of contact."""

from typing import NamedTuple, Protocol

import numpy as np
import pinocchio as pin

from tests.reproduction.independent.arm import Array, ReportArm
from tests.reproduction.independent.free_space import PERIOD, Controller, Observed, resolved
from tests.reproduction.independent.references import Path


def compliance(reference: Path, arm: ReportArm, K_P: Array, K_D: Array) -> Controller:
    """A spring and a damper along the axes of the desired frame."""

    def torque(now: Observed) -> Array:
        desired = reference(now.time)[0]
        tip = arm.tip(now.q, now.v)
        turn = np.eye(6)
        axes = [pin.utils.rotate(axis, angle) for axis, angle in zip("zxz", desired[3:], strict=True)]
        turn[:3, :3] = (axes[0] @ axes[1] @ axes[2]).T
        J_d = turn @ tip.jacobian
        pull = K_P * (turn @ (desired - tip.pose)) - K_D * (J_d @ now.v)
        return arm.gravity(now.q) + np.asarray(J_d.T @ pull)

    return torque


def impedance(reference: Path, arm: ReportArm, M_d: Array, K_D: Array, K_P: Array) -> Controller:
    """Mass, damper and spring, with the contact force compensated."""

    def torque(now: Observed) -> Array:
        desired, rate, acceleration = reference(now.time)
        tip = arm.tip(now.q, now.v)
        h = np.concatenate([now.force, np.zeros(3)])
        pull = K_D * (rate - tip.jacobian @ now.v) + K_P * (desired - tip.pose) - h
        total: Array = resolved(arm, now, tip, acceleration + pull / M_d) + tip.jacobian.T @ h
        return total

    return torque


def admittance(
    reference: Path, arm: ReportArm, frame: tuple[Array, Array, Array], K_P: float, K_D: float
) -> Controller:
    """A compliant frame M, D, K under the force, held over a period, and inverse dynamics that tracks it."""
    M_t, D_t, K_t = frame
    steps = [_held(m, d, k) for m, d, k in zip(M_t, D_t, K_t, strict=True)]
    z = np.zeros((6, 2))

    def torque(now: Observed) -> Array:
        desired, rate, acceleration = reference(now.time)
        tip = arm.tip(now.q, now.v)
        h = np.concatenate([now.force, np.zeros(3)])
        bend = (h - D_t * z[:, 1] - K_t * z[:, 0]) / M_t
        wanted = (
            acceleration
            - bend
            + K_D * (rate - z[:, 1] - tip.jacobian @ now.v)
            + K_P * (desired - z[:, 0] - tip.pose)
        )
        z[:] = [step @ [*state, load] for step, state, load in zip(steps, z, h, strict=True)]
        total: Array = resolved(arm, now, tip, wanted) + tip.jacobian.T @ h
        return total

    return torque


def _held(mass: float, damping: float, stiffness: float) -> Array:
    """Displacement, rate and constant force at the start of a period to the first two at its end."""
    rates = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]])
    term = result = np.eye(3)
    for order in range(1, 20):  # of the exponential; the matrix is small
        term = term @ rates * PERIOD / order
        result = result + term
    return np.asarray(result[:2])


class Tip(NamedTuple):
    """The tip along the desired force.

    Attributes:
        position: position [m].
        rate: velocity [m/s].
        lag: distance of the moving tip behind its target [m].
    """

    position: float
    rate: float
    lag: float


class Pursuit(Protocol):
    """The target of a force loop: how far it is moved along the desired force."""

    def move(self, desired: float, force: float, tip: Tip) -> float:
        """The displacement of this period [m].

        Args:
            desired: desired force [N].
            force: measured force along the desired one [N].
            tip: measured motion of the tip.
        """


class SteadyPursuit:
    """A target that moves by K_F e + K_I ∫e dt.

    Args:
        force_gain: K_F [m/N].
        integral_gain: K_I [m/(N s)].
    """

    def __init__(self, force_gain: float, integral_gain: float) -> None:
        self._gains = force_gain, integral_gain
        self._sum = 0.0

    def move(self, desired: float, force: float, tip: Tip) -> float:
        """See `Pursuit.move`."""
        K_F, K_I = self._gains
        before, error = self._sum, desired - force
        self._sum += PERIOD * K_I * error
        return before + K_F * error


def force_loop(
    arm: ReportArm,
    base: Path,
    desired: Array,
    pursuit: Pursuit,
    inner: tuple[Array, Array, Array],
) -> Controller:
    """An inner position loop M, D, K about a motion, moved by a pursuit along the desired force."""
    M_d, K_D, K_P = inner
    size = float(np.linalg.norm(desired))
    n = desired / size

    def torque(now: Observed) -> Array:
        pose, rate, acceleration = base(now.time)
        tip = arm.tip(now.q, now.v)
        behind = K_D * (tip.jacobian @ now.v - rate) / K_P
        along = Tip(*(float(n @ part) for part in (tip.pose[:3], tip.jacobian[:3] @ now.v, behind[:3])))
        move = pursuit.move(size, float(n @ now.force), along)
        error = pose - tip.pose
        error[:3] += n * move
        wanted = acceleration + (K_D * (rate - tip.jacobian @ now.v) + K_P * error) / M_d
        return resolved(arm, now, tip, wanted) + tip.jacobian[:3].T @ now.force

    return torque
