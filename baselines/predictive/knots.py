"""The formulas of one knot of a plan: motion, cost, and the steps of the backward and the forward pass.

A plan holds the torques τ_k of N intervals between knots, of duration h_k each. Symbols: x = (q, q̇);
w = q̇ at the end of an interval; W_p, W_m, W_v are the weights of V = ½(W_p e² + 2 W_m e ė + W_v ė²) with the
errors e = q_d - q, ė = q̇_d - q̇ of a joint at a knot. They cost κ(√(1 + 2V/κ) - 1), which is V while it is
small and grows as the errors beyond; torques cost ½ R (τ - τ_d)², a position beyond a joint stop ½ W_s of the
distance squared.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.base.control_interface import Model
from prp_gym.baselines.predictive.box_minimum import box_minimum
from prp_gym.robot.arrays import Array, apply, apply_transposed, multiply, solve_symmetric, total

WEIGHTS = 3
"""W_p, W_m and W_v of each joint, one after the other."""


class Knot(NamedTuple):
    """What the cost of an interval depends on.

    Attributes:
        desired: q_d and q̇_d (..., 2n) at its end.
        weight: W_p, W_m and W_v (..., 3n) at its end.
        threshold: κ (..., n), about which the cost of errors turns from quadratic to linear.
        effort: τ_d (..., n) [N m, N, N m].
        effort_weight: R (..., n).
        stops: least and greatest position (..., 2n), beyond which it costs.
        stop_weight: W_s (..., n) of the distance beyond.
    """

    desired: Array
    weight: Array
    threshold: Array
    effort: Array
    effort_weight: Array
    stops: Array
    stop_weight: Array


def knot_motion(
    model: Model, position: Array, velocity: Array, torque: Array, duration: Array
) -> tuple[Array, Array]:
    """Position and velocity at the end of an interval with a constant torque.

    The acceleration is constant, with the viscous friction of the velocity at the end:
    (B + h F_v) (w - q̇) = h (τ - n), q' = q + h (q̇ + w)/2.

    Args:
        model: nominal robot.
        position: q (..., n).
        velocity: q̇ (..., n).
        torque: τ (..., n) [N m, N, N m].
        duration: h (..., 1) [s].
    """
    viscous = np.diag(np.atleast_1d(model.parameters.viscous_friction))
    implicit = model.inertia_matrix(position) + duration[..., None] * viscous
    force = duration * (torque - model.bias_force(position, velocity))
    faster = velocity + solve(implicit, force)
    return position + 0.5 * duration * (velocity + faster), faster


def knot_cost(position: Array, velocity: Array, torque: Array, knot: Knot) -> Array:
    """Cost (..., 1) of an interval, from the state at its end and its torque.

    Args:
        position: q (..., n).
        velocity: q̇ (..., n).
        torque: τ (..., n) [N m, N, N m].
        knot: the rest.
    """
    twice = _twice_quadratic(position, velocity, knot)
    growth = np.sqrt(1.0 + twice / knot.threshold)
    beyond, over = _beyond(position, knot), torque - knot.effort
    own = 2.0 * twice / (1.0 + growth) + knot.stop_weight * beyond * beyond
    return 0.5 * total(own + knot.effort_weight * over * over)[..., None]


def cost_slope(position: Array, velocity: Array, knot: Knot) -> Array:
    """Derivatives (..., 2n) of `knot_cost` by the position and the velocity."""
    W_p, W_m, W_v = _thirds(knot.weight)
    e, e_dot = _errors(position, velocity, knot)
    growth, stop = _growth(position, velocity, knot), knot.stop_weight * _beyond(position, knot)
    of_position = stop - (W_p * e + W_m * e_dot) / growth
    return np.concatenate([of_position, -(W_m * e + W_v * e_dot) / growth], axis=-1)


def cost_curvature(position: Array, velocity: Array, knot: Knot) -> Array:
    """A bound (..., 2n, 2n) of the second derivatives of `knot_cost` by the position and the velocity.

    It belongs to the parabola that touches the cost here and is nowhere below it.

    Source: Huber 1981, 7.8.
    """
    growth = _growth(position, velocity, knot)
    W_p, W_m, W_v = (weight / growth for weight in _thirds(knot.weight))
    stop = np.where(_beyond(position, knot) == 0.0, 0.0, knot.stop_weight)
    return _blocks(_diagonal(W_p + stop), _diagonal(W_m), _diagonal(W_v))


def _errors(position: Array, velocity: Array, knot: Knot) -> tuple[Array, Array]:
    """Errors e and ė (..., n)."""
    desired, rate = _halves(knot.desired)
    return desired - position, rate - velocity


def _growth(position: Array, velocity: Array, knot: Knot) -> Array:
    """√(1 + 2V/κ) (..., n): how much less the cost of a joint's errors grows than V."""
    growth: Array = np.sqrt(1.0 + _twice_quadratic(position, velocity, knot) / knot.threshold)
    return growth


def _twice_quadratic(position: Array, velocity: Array, knot: Knot) -> Array:
    """2V (..., n) of each joint's errors."""
    W_p, W_m, W_v = _thirds(knot.weight)
    e, e_dot = _errors(position, velocity, knot)
    return W_p * e * e + 2.0 * W_m * e * e_dot + W_v * e_dot * e_dot


def _beyond(position: Array, knot: Knot) -> Array:
    """How far positions are beyond the joint stops (..., n), negative below the lower ones."""
    lowest, highest = _halves(knot.stops)
    return np.maximum(position - highest, 0.0) + np.minimum(position - lowest, 0.0)


class Backward(NamedTuple):
    """The results of `backward_step`.

    Attributes:
        change: k (..., n), change of the torque for an unchanged state.
        gain: K (..., n, 2n), change of the torque per change of the state.
        slope: derivative (..., 2n) of the cost to go by the state at the start of the interval.
        curvature: second derivative (..., 2n, 2n).
    """

    change: Array
    gain: Array
    slope: Array
    curvature: Array


def backward_step(
    derivatives: tuple[Array, Array, Array],
    duration: Array,
    cost_to_go: tuple[Array, Array],
    effort: tuple[Array, Array],
    bounds: tuple[Array, Array],
) -> Backward:
    """The Riccati recursion over one interval, with bounds of the torque.

    A torque at a bound stays there: its row of K is zero.

    Args:
        derivatives: of w by q, by q̇ and by τ (..., n, n) each.
        duration: h (..., 1) [s].
        cost_to_go: derivative (..., 2n) and second derivative (..., 2n, 2n) of the cost after the interval by
            the state at its end, with the cost of that state.
        effort: τ - τ_d and R (..., n) each.
        bounds: least and greatest change of the torque (..., n) each.

    Source: Tassa 2014, III; Li 2004.
    """
    D_q, D_v, D_u = derivatives
    slope, curvature = cost_to_go
    half = 0.5 * duration
    S = half[..., None]
    g_q, g_v = _halves(slope)
    H_qq, H_qv, H_vv = _parts(curvature)
    # the cost to go as a function of c = q + h q̇/2 and of w, at the end q' = c + h w/2
    g_w = g_v + half * g_q
    H_cw = H_qv + S * H_qq
    H_ww = H_vv + S * (H_qv.mT + H_cw)
    w_x = np.concatenate([D_q, D_v], axis=-1)
    into_w = multiply(H_ww, w_x) + _after(H_cw.mT, S)
    into_c = multiply(H_cw, w_x) + _after(H_qq, S)
    over, R = effort
    Q_x = apply_transposed(w_x, g_w) + np.concatenate([g_q, half * g_q], axis=-1)
    Q_u = apply_transposed(D_u, g_w) + R * over
    Q_xx = multiply(w_x.mT, into_w) + np.concatenate([into_c, S * into_c], axis=-2)
    Q_ux = multiply(D_u.mT, into_w)
    Q_uu = multiply(D_u.mT, multiply(H_ww, D_u)) + _diagonal(R)
    change = box_minimum(Q_uu, Q_u, *bounds)
    gain = _free_gain(Q_uu, Q_ux, (change > bounds[0]) & (change < bounds[1]))
    return Backward(
        change,
        gain,
        Q_x + apply_transposed(Q_ux, change),
        _symmetric(Q_xx + multiply(Q_ux.mT, gain)),
    )


def followed_torque(
    torque: Array, step: tuple[Array, Array], deviation: Array, bounds: tuple[Array, Array]
) -> Array:
    """The torque (..., n) of the forward pass, within its bounds.

    Args:
        torque: τ (..., n) of the plan.
        step: α k (..., n) and K (..., n, 2n).
        deviation: state less that of the plan (..., 2n).
        bounds: least and greatest torque (..., n) each.
    """
    change, gain = step
    return np.minimum(np.maximum(torque + change + apply(gain, deviation), bounds[0]), bounds[1])


def solve(matrix: Array, vector: Array) -> Array:
    """A⁻¹b of a symmetric, positive definite A for one joint or three: (..., n, n), (..., n) -> (..., n)."""
    if vector.shape[-1] == 1:
        quotient: Array = vector / matrix[..., 0]
        return quotient
    return solve_symmetric(matrix, vector)


def _free_gain(Q_uu: Array, Q_ux: Array, free: NDArray[np.bool_]) -> Array:
    """K = -Q_uu⁻¹Q_ux over the free torques (..., n); zero in the rows of the others."""
    both = free[..., :, None] & free[..., None, :]
    matrix = np.where(both, Q_uu, np.eye(free.shape[-1]))
    right = np.where(free[..., None], -Q_ux, 0.0)
    return solve(matrix[..., None, :, :], right.mT).mT


def _after(matrix: Array, S: Array) -> Array:
    """A matrix (..., n, n) times the derivative (I, h/2 I) of c by the state."""
    return np.concatenate([matrix, S * matrix], axis=-1)


def _halves(vector: Array) -> tuple[Array, Array]:
    size = vector.shape[-1] // 2
    return vector[..., :size], vector[..., size:]


def _thirds(vector: Array) -> tuple[Array, Array, Array]:
    size = vector.shape[-1] // WEIGHTS
    return vector[..., :size], vector[..., size : 2 * size], vector[..., 2 * size :]


def _parts(matrix: Array) -> tuple[Array, Array, Array]:
    """The blocks of position, mixed, and velocity (..., n, n) of a symmetric matrix (..., 2n, 2n)."""
    size = matrix.shape[-1] // 2
    return matrix[..., :size, :size], matrix[..., :size, size:], matrix[..., size:, size:]


def _blocks(of_position: Array, mixed: Array, of_velocity: Array) -> Array:
    """The symmetric matrix (..., 2n, 2n) of these blocks."""
    above = np.concatenate([of_position, mixed], axis=-1)
    return np.concatenate([above, np.concatenate([mixed.mT, of_velocity], axis=-1)], axis=-2)


def _symmetric(matrix: Array) -> Array:
    """The mean of a matrix and its transpose, which differ by rounding."""
    return 0.5 * (matrix + matrix.mT)


def _diagonal(values: Array) -> Array:
    """Diagonal matrices (..., n, n) of their diagonals (..., n)."""
    return values[..., None] * np.eye(values.shape[-1])
