"""The controllers of contact."""

import math

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


class Pursuit:
    """The target of a force loop: how far it is moved along the desired force.

    Args:
        force_gain: K_F [m/N].
        integral_gain: K_I [m/(N s)].
    """

    def __init__(self, force_gain: float, integral_gain: float) -> None:
        self._gains = force_gain, integral_gain
        self._sum = 0.0

    def move(self, desired: float, force: float, position: float, lag: float) -> float:
        """The displacement of this period [m].

        Args:
            desired: desired force [N].
            force: measured force along the desired one [N].
            position: position of the tip along the desired force [m].
            lag: distance of the moving tip behind its target [m].
        """
        K_F, K_I = self._gains
        before, error = self._sum, desired - force
        self._sum += PERIOD * K_I * error
        return before + K_F * error


class EstimatedPursuit:
    """A target that moves at ω e/K with an estimate of the stiffness K in contact, and at v before it.

    Args:
        bandwidth: ω [rad/s].
        approach_speed: v [m/s].
        threshold: force at which contact begins [N].
        initial_stiffness: stiffness at the start of a contact [N/m].
        forgetting_time: time constant of the measurements' weights [s].
    """

    def __init__(
        self,
        bandwidth: float,
        approach_speed: float,
        threshold: float,
        initial_stiffness: float,
        forgetting_time: float,
    ) -> None:
        self._bandwidth, self._speed, self._threshold = bandwidth, approach_speed, threshold
        self._stiffness, self._fading = initial_stiffness, math.exp(-PERIOD / forgetting_time)
        self._sum, self._touching = 0.0, False
        self._samples = np.zeros((3, 0))  # weights, positions, forces
        self._spread = 0.0

    def move(self, desired: float, force: float, position: float, lag: float) -> float:
        """See `Pursuit.move`."""
        level = min(0.5 * desired, self._threshold) * (0.5 if self._touching else 1.0)
        contact = force > level
        if contact and not self._touching:
            self._sum -= max(lag, 0.0)
        self._touching = contact
        displacement, error = self._sum, desired - force
        rate = self._speed if error > 0.0 else 0.0
        if contact:
            wanted = self._bandwidth * error / self._estimate(position, force)
            rate = min(max(wanted, -self._speed), self._speed)
        else:
            self._samples, self._spread = np.zeros((3, 0)), 0.0
        self._sum += PERIOD * rate
        return displacement

    def _estimate(self, position: float, force: float) -> float:
        """Weighted least squares over the whole contact, from all its samples anew."""
        samples = np.column_stack([self._samples, [1.0, position, force]])
        faded = samples.copy()
        faded[0, :-1] *= self._fading
        self._samples = samples if _moments(faded)[0] < self._spread else faded
        self._spread, together = _moments(self._samples)
        guess = (0.05 / 5000.0) ** 2
        slope = (together + guess * self._stiffness) / (self._spread + guess)
        return min(max(slope, 10.0), 2e4)


def _moments(samples: Array) -> tuple[float, float]:
    """Weighted second moments about the means: of the positions, and of positions and forces."""
    w, p, f = samples
    p, f = p - (w @ p) / w.sum(), f - (w @ f) / w.sum()
    return float(w @ (p * p)), float(w @ (p * f))


def force_loop(
    arm: ReportArm,
    base: Path,
    desired: Array,
    pursuit: Pursuit | EstimatedPursuit,
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
        move = pursuit.move(size, float(n @ now.force), float(n @ tip.pose[:3]), float(n @ behind[:3]))
        error = pose - tip.pose
        error[:3] += n * move
        wanted = acceleration + (K_D * (rate - tip.jacobian @ now.v) + K_P * error) / M_d
        return resolved(arm, now, tip, wanted) + tip.jacobian[:3].T @ now.force

    return torque
