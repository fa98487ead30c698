"""Motion and cost of one interval: other formulas of the dynamics, finite differences, bounds."""

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.predictive.formulas import functions_of
from prp_gym.baselines.predictive.knots import Knot, cost_curvature, cost_slope, knot_cost, knot_motion
from prp_gym.robot import Link, LinkParameters, PRPArm
from tests.baselines.predictive.problems import ARM, LINK
from tests.support.pinocchio_model import PinocchioArm, per_row, random_states

Array = NDArray[np.float64]

DURATION = np.array([0.01])


def states(model: PRPArm | Link, count: int) -> tuple[Array, Array, Array]:
    generator, n = np.random.default_rng(5), model.joint_count
    q = generator.uniform(-1.0, 1.0, (count, n))
    return q, generator.uniform(-5.0, 5.0, (count, n)), generator.uniform(-10.0, 10.0, (count, n))


def test_acceleration_is_that_of_another_library() -> None:
    q, velocity, _, _ = random_states(3, 50)
    torque = np.random.default_rng(4).uniform(-10.0, 10.0, (50, 3))
    later, faster = knot_motion(ARM, q, velocity, torque, DURATION)
    expected = per_row(PinocchioArm().forward_dynamics, q, velocity, torque, np.zeros((50, 3)))
    np.testing.assert_allclose((faster - velocity) / DURATION, expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(later - q, 0.5 * DURATION * (velocity + faster), atol=1e-15)


def test_viscous_friction_is_that_of_the_velocity_at_the_end() -> None:
    link = Link(LinkParameters(inertia=0.5, viscous_friction=200.0, gravity_moment=0.0))
    _, faster = knot_motion(link, np.zeros(1), np.ones(1), np.array([3.0]), DURATION)
    # (I + h F) w = I q̇ + h τ, which decays whatever h F/I is: here 4
    assert faster[0] == pytest.approx((0.5 + 0.01 * 3.0) / (0.5 + 0.01 * 200.0), rel=1e-14)


@pytest.mark.parametrize("model", [ARM, LINK], ids=["arm", "link"])
def test_derivatives_of_the_motion_are_those_of_finite_differences(model: PRPArm | Link) -> None:
    given = dict(zip(("position", "velocity", "torque"), states(model, 20), strict=True))
    found = functions_of(model).derivatives.evaluate_rows({**given, "duration": np.full((20, 1), 0.01)})
    step = 1e-5
    for name, values in given.items():
        for index in range(model.joint_count):
            sides = []
            for sign in (1.0, -1.0):
                moved = values.copy()
                moved[:, index] += sign * step
                around = {**given, name: moved}
                at = around["position"], around["velocity"], around["torque"]
                sides.append(knot_motion(model, *at, DURATION)[1])
            # step² times third derivatives, and rounding over step
            expected = (sides[0] - sides[1]) / (2.0 * step)
            np.testing.assert_allclose(found[f"by_{name}"][..., index], expected, rtol=1e-7, atol=1e-8)


def knots(count: int) -> tuple[Array, Array, Array, Knot]:
    generator = np.random.default_rng(6)
    weight = np.abs(generator.normal(size=(count, 9))) + np.repeat([1.0, 0.0, 1.0], 3)
    weight[:, 3:6] *= 0.3  # less than the geometric mean of the others: positive definite
    position, velocity, torque = generator.normal(size=(3, count, 3))
    knot = Knot(
        desired=generator.normal(size=(count, 6)),
        weight=weight,
        threshold=10.0 ** generator.uniform(-2.0, 2.0, (count, 3)),
        effort=generator.normal(size=(count, 3)),
        effort_weight=np.abs(generator.normal(size=(count, 3))),
        stops=np.repeat([-1.0, -0.5, -2.0, 0.5, 1.0, 0.1], count).reshape(6, count).T,
        stop_weight=np.full((count, 3), 3.0),
    )
    return position, velocity, torque, knot


def test_slope_of_the_cost_is_that_of_finite_differences() -> None:
    position, velocity, torque, knot = knots(100)
    slope, step = cost_slope(position, velocity, knot), 1e-6
    for index in range(6):
        change = step * np.eye(6)[index]
        costs = [
            knot_cost(position + sign * change[:3], velocity + sign * change[3:], torque, knot)[:, 0]
            for sign in (1.0, -1.0)
        ]
        np.testing.assert_allclose(
            slope[:, index], (costs[0] - costs[1]) / (2.0 * step), rtol=1e-6, atol=1e-6
        )


def test_parabola_of_slope_and_curvature_is_nowhere_below_the_cost() -> None:
    """Of the errors; beyond a stop the parabola has that stop's curvature, and within it none."""
    position, velocity, torque, knot = knots(200)
    knot = knot._replace(stop_weight=np.zeros((200, 3)))
    here = knot_cost(position, velocity, torque, knot)[:, 0]
    slope, curvature = cost_slope(position, velocity, knot), cost_curvature(position, velocity, knot)
    generator = np.random.default_rng(7)
    near = []
    for size in (1e-2, 1.0, 10.0):
        move = size * generator.normal(size=(200, 6))
        parabola = here + (slope * move).sum(axis=1) + 0.5 * np.einsum("ni,nij,nj->n", move, curvature, move)
        there = knot_cost(position + move[:, :3], velocity + move[:, 3:], torque, knot)[:, 0]
        assert (there <= parabola * (1.0 + 1e-12)).all()
        near.append(np.median((parabola - there) / parabola))
    assert near[0] < 1e-4 < near[2]


def test_small_errors_cost_their_quadratic_and_large_ones_grow_linearly() -> None:
    _, _, torque, knot = knots(50)
    knot = knot._replace(effort=torque, threshold=np.ones((50, 3)), stop_weight=np.zeros((50, 3)))
    desired, rate = knot.desired[:, :3], knot.desired[:, 3:]
    W_p, W_v = knot.weight[:, :3], knot.weight[:, 6:]
    small = knot_cost(desired + 1e-4, rate, torque, knot)[:, 0]
    np.testing.assert_allclose(small, 0.5 * W_p.sum(axis=1) * 1e-8, rtol=1e-7)  # W e²/κ = 1e-8
    large = [knot_cost(desired, rate + error, torque, knot)[:, 0] for error in (1e6, 2e6)]
    np.testing.assert_allclose(large[1] - large[0], 1e6 * np.sqrt(W_v).sum(axis=1), rtol=1e-5)


def test_only_positions_beyond_a_stop_cost() -> None:
    position, velocity, torque, knot = knots(300)
    without = knot._replace(stop_weight=np.zeros((300, 3)))
    low, high = knot.stops[:, :3], knot.stops[:, 3:]
    distance = np.clip(position, low, high) - position
    assert 0.2 < (distance != 0.0).mean() < 0.8
    extra = knot_cost(position, velocity, torque, knot) - knot_cost(position, velocity, torque, without)
    np.testing.assert_allclose(extra[:, 0], 1.5 * (distance**2).sum(axis=1), rtol=1e-9, atol=1e-10)
    stiffer = cost_curvature(position, velocity, knot) - cost_curvature(position, velocity, without)
    expected = np.where(distance != 0.0, 3.0, 0.0)
    np.testing.assert_allclose(np.diagonal(stiffer, axis1=1, axis2=2)[:, :3], expected, atol=1e-12)
