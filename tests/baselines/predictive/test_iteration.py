"""One iteration: dense least squares of a linear plant, optimality at bounds, descent, equal bits."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.predictive import iteration
from prp_gym.baselines.predictive.formulas import KNOTS
from prp_gym.baselines.predictive.iteration import (
    Improved,
    Problem,
    improve,
    improve_compiled,
    improve_with_numpy,
)
from prp_gym.errors import CompilerError
from prp_gym.robot import Link, PRPArm
from tests.baselines.predictive.problems import (
    ARM,
    LINK,
    WEIGHTLESS,
    limit_of,
    random_plan,
    random_problem,
    row_of,
)
from tests.support.compiler import needs_compiler

Array = NDArray[np.float64]

QUADRATIC = 1e30  # κ so large that the errors cost their quadratic
both_robots = pytest.mark.parametrize("model", [ARM, LINK], ids=["arm", "link"])


def least_squares(problem: Problem, row: int) -> tuple[Array, Array]:
    """A and b of ½|A u - b|² for the torques u (N) of a weightless link, from constant accelerations."""
    duration, inertia = problem.duration[:, 0], WEIGHTLESS.parameters.inertia
    rows, right = [], []
    for k in range(KNOTS):
        begins = np.cumsum(duration) - duration
        share = np.where(np.arange(KNOTS) <= k, duration / inertia, 0.0)
        after = duration[: k + 1].sum() - begins - 0.5 * duration  # from the middle of each interval on
        q, rate = problem.state[row]
        free = np.array([q + rate * duration[: k + 1].sum(), rate])
        W_p, W_m, W_v = problem.weight[row, k]
        root = np.linalg.cholesky([[W_p, W_m], [W_m, W_v]]).T
        rows += list(root @ np.array([share * after, share]))
        right += list(root @ (problem.desired[row, k] - free))
    effort = np.sqrt(problem.effort_weight[:, 0])
    return np.array([*rows, *np.diag(effort)]), np.array([*right, *(effort * problem.effort[row, :, 0])])


def unbounded(problem: Problem) -> Problem:
    return replace(problem, low=0.0 * problem.low - 1e9, high=0.0 * problem.high + 1e9)


def converged(model: PRPArm | Link, problem: Problem, plan: Array, count: int) -> Improved:
    for _ in range(count):
        found = improve(model, problem, plan)
        plan = found.torque
    return found


def test_linear_problem_is_solved_by_one_iteration_as_by_dense_least_squares() -> None:
    problem = random_problem(WEIGHTLESS, 6)
    problem = unbounded(replace(problem, threshold=QUADRATIC + 0.0 * problem.threshold))
    found = improve(WEIGHTLESS, problem, random_plan(WEIGHTLESS, 6))
    for row in range(6):
        A, b = least_squares(problem, row)
        expected = np.linalg.lstsq(A, b, rcond=None)[0]
        # rounding, times the condition of the problem
        np.testing.assert_allclose(
            found.torque[row, :, 0], expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max()
        )


def test_plan_with_torques_at_their_bounds_meets_the_conditions_of_optimality() -> None:
    problem = random_problem(WEIGHTLESS, 6)
    problem = replace(problem, threshold=QUADRATIC + 0.0 * problem.threshold)
    found, at_bound = converged(WEIGHTLESS, problem, random_plan(WEIGHTLESS, 6), 40), []
    for row in range(6):
        A, b = least_squares(problem, row)
        u, low, high = (part[row, :, 0] for part in (found.torque, problem.low, problem.high))
        slope = A.T @ (A @ u - b)
        # no step is taken that lowers the cost by less than its rounding
        scale = 1e-5 * np.abs(A.T @ b)
        # τ + (τ_max - τ) may be less than τ_max by its rounding
        at_low, at_high = u <= low + 1e-13, u >= high - 1e-13
        assert (np.abs(slope) <= scale)[~at_low & ~at_high].all()
        assert (slope >= -scale)[at_low].all()
        assert (slope <= scale)[at_high].all()
        at_bound.append((at_low | at_high).mean())
    assert 0.1 < np.mean(at_bound) < 0.9


@both_robots
def test_cost_falls_to_where_the_plan_stays(model: PRPArm | Link) -> None:
    problem, plan = random_problem(model, 8), random_plan(model, 8)
    costs = []
    for _ in range(60):
        found = improve(model, problem, plan)
        assert (found.cost[:, 1] <= found.cost[:, 0]).all()
        assert (found.torque >= problem.low).all()
        assert (found.torque <= problem.high).all()
        plan = found.torque
        costs.append(found.cost[:, 1])
    for earlier, later in itertools.pairwise(costs):
        np.testing.assert_allclose(
            np.minimum(later - earlier, 0.0), later - earlier, atol=1e-9 * earlier.max()
        )
    first = improve(model, problem, random_plan(model, 8)).cost[:, 0]
    assert (costs[-1] < 0.9 * first).all()
    assert (costs[-10] - costs[-1] < 1e-2 * first).all()


@both_robots
def test_no_plan_nearby_is_cheaper_than_a_converged_one(model: PRPArm | Link) -> None:
    """Without bounds, at which a step of the backward pass can fail to be one of descent."""
    problem = unbounded(random_problem(model, 4))
    found = converged(model, problem, random_plan(model, 4), 200)
    generator, limit = np.random.default_rng(3), limit_of(model)
    for _ in range(30):
        moved = found.torque + 1e-3 * limit * generator.normal(size=found.torque.shape)
        before = improve(model, problem, moved).cost[:, 0]
        # what a converged plan could still gain, by the test above far less in the last iterations
        assert (before >= found.cost[:, 1] * (1.0 - 1e-4)).all()


@needs_compiler
@both_robots
def test_compiled_code_and_numpy_have_the_same_bits(model: PRPArm | Link) -> None:
    problem, plan = random_problem(model, 5), random_plan(model, 5)
    for _ in range(3):
        compiled, found = improve_compiled(model, problem, plan), improve_with_numpy(model, problem, plan)
        for one, other in zip(compiled, found, strict=True):
            np.testing.assert_array_equal(one, other)
        plan = compiled.torque


@needs_compiler
def test_diverging_plans_have_the_same_bits_in_numpy() -> None:
    """From some of these speeds the model overflows along the plan."""
    problem, plan = random_problem(ARM, 8), random_plan(ARM, 8)
    speeds = np.array([1e2, 1e3, 1e4, 1e5, 1e6, 1e8, 1e12, 1e17])[:, None] * [-0.1, -0.2, 1.0]
    problem = replace(problem, state=np.concatenate([problem.state[:, :3], speeds], axis=-1))
    compiled, found = improve_compiled(ARM, problem, plan), improve_with_numpy(ARM, problem, plan)
    for one, other in zip(compiled, found, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not np.isfinite(found.cost).all()


@both_robots
@pytest.mark.parametrize("function", [improve_compiled, improve_with_numpy], ids=["compiled", "numpy"])
def test_plans_side_by_side_have_the_bits_of_each_alone(model: PRPArm | Link, function: object) -> None:
    if function is improve_compiled and needs_compiler.args[0]:
        pytest.skip("no C compiler on this machine")
    problem, plan = random_problem(model, 5), random_plan(model, 5)
    given = plan.copy()
    together = function(model, problem, plan)  # type: ignore[operator]
    np.testing.assert_array_equal(plan, given)
    for row in range(5):
        alone = function(model, row_of(problem, row), plan[row : row + 1])  # type: ignore[operator]
        for one, other in zip(alone, together, strict=True):
            np.testing.assert_array_equal(one[0], other[row])


def test_plan_that_cannot_be_improved_stays() -> None:
    problem = random_problem(ARM, 3)
    at_goal = np.concatenate([problem.desired[:, 0, :3], np.zeros((3, 3))], axis=-1)
    weightless = replace(
        problem,
        state=at_goal,
        stop_weight=0.0 * problem.stop_weight,
        low=problem.low - 1e3,
        high=problem.high + 1e3,
    )
    holding = np.repeat(ARM.gravity_vector(at_goal[:, :3])[:, None], KNOTS, axis=1)
    found = improve(ARM, replace(weightless, effort=holding), holding)
    np.testing.assert_allclose(found.torque, holding, atol=1e-9)
    np.testing.assert_allclose(found.expected, at_goal, atol=1e-12)
    np.testing.assert_allclose(found.cost, 0.0, atol=1e-15)


def test_model_without_compiled_code_is_left_to_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    """As one of a user's own is where a wheel has brought the libraries of the nominal model alone."""

    def missing(source: str) -> None:
        raise CompilerError("there is none.")

    problem, plan = random_problem(LINK, 3), random_plan(LINK, 3)
    expected = improve_with_numpy(LINK, problem, plan)
    iteration._library_of.cache_clear()
    monkeypatch.setattr(iteration, "compiles_by_default", lambda: True)
    monkeypatch.setattr(iteration, "load_library", missing)
    try:
        for one, other in zip(improve(LINK, problem, plan), expected, strict=True):
            np.testing.assert_array_equal(one, other)
    finally:
        iteration._library_of.cache_clear()
