"""The constraint solver against the conditions of the minimum, written down independently."""

import ctypes
from pathlib import Path

import numpy as np
import pytest

import prp_gym.physics
from prp_gym.physics.compiled_arm_source import solver_functions
from prp_gym.symbolic.c_source import PREAMBLE
from prp_gym.symbolic.compiler import load_library
from tests.support.compiler import needs_compiler
from tests.support.pinocchio_model import Array

pytestmark = needs_compiler

ROWS, CASES = 7, 400
ENTRY = """
void solve(int count, const double *J, const double *r, const double *w, const double *loss,
    const double *B, const double *b, double *a, double *f)
{
    prp_constraints c;
    c.count = count;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < 3; j++)
            c.jacobian[i][j] = J[3 * i + j];
        c.reference[i] = r[i], c.weight[i] = w[i], c.loss[i] = loss[i];
    }
    prp_minimise(&c, B, b, a);
    for (int i = 0; i < count; i++)
        f[i] = c.force[i];
}
"""


def solve(J: Array, r: Array, w: Array, loss: Array, B: Array, b: Array, guess: Array) -> tuple[Array, Array]:
    text = (Path(prp_gym.physics.__file__).parent / "constraint_solver.c").read_text(encoding="utf-8")
    function = load_library(f"#include <string.h>\n{PREAMBLE}\n{solver_functions()}\n{text}\n{ENTRY}").solve
    a, f = guess.copy(), np.zeros(len(r))
    arrays = [np.ascontiguousarray(value) for value in (J, r, w, loss, B, b)]
    function(len(r), *(ctypes.c_void_p(value.ctypes.data) for value in (*arrays, a, f)))
    return a, f


def random_problem(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array, Array, Array, Array]:
    root = rng.normal(size=(3, 3))
    B = root @ root.T + 0.05 * np.eye(3)
    J, r = rng.normal(size=(count, 3)), rng.normal(size=count) * 10.0 ** rng.uniform(-1, 3)
    w = 10.0 ** rng.uniform(-3, 4, count)
    loss = np.where(rng.random(count) < 0.5, -1.0, 10.0 ** rng.uniform(-2, 2, count))
    return J, r, w, loss, B, rng.normal(size=3) * 10.0


@pytest.mark.parametrize("count", [1, 3, 4, ROWS])
def test_the_result_is_the_minimum(count: int) -> None:
    """Stationary, and every force is that of its constraint's own cost: with convexity, the minimum."""
    rng = np.random.default_rng(count)
    for _ in range(CASES):
        J, r, w, loss, B, b = problem = random_problem(rng, count)
        a, f = solve(*problem, rng.normal(size=3) * 10.0)
        scale = np.abs(b).max() + np.abs(J.T).max() * np.abs(f).max() + np.abs(B @ a).max()
        assert np.abs(B @ a - b - J.T @ f).max() < 1e-9 * scale  # rounding of weights up to 1e4
        z = J @ a - r
        one_sided = loss < 0.0
        expected = np.where(one_sided, np.maximum(-w * z, 0.0), np.clip(-w * z, -loss, loss))
        rounding = 1e-14 * w * (np.abs(r) + np.abs(J) @ np.abs(a))  # of z, in another order of summation
        assert (np.abs(f - expected) <= rounding).all()


@pytest.mark.parametrize("count", [1, 3, 4, ROWS])
def test_the_bits_do_not_depend_on_the_first_guess(count: int) -> None:
    """So that a simulation which goes on from a saved state has the bits of one that was not stopped."""
    rng = np.random.default_rng(count)
    for _ in range(CASES):
        problem = random_problem(rng, count)
        first, second = (np.concatenate(solve(*problem, rng.normal(size=3) * 10.0)) for _ in range(2))
        assert np.array_equal(first, second)


def test_a_start_at_the_minimum_stays_there() -> None:
    rng = np.random.default_rng(0)
    B, J = np.eye(3), rng.normal(size=(3, 3))
    r, w, loss = rng.normal(size=3), np.ones(3), np.array([-1.0, 0.5, 0.1])
    b = rng.normal(size=3)
    first, _ = solve(J, r, w, loss, B, b, np.zeros(3))
    second, _ = solve(J, r, w, loss, B, b, first)
    assert second == pytest.approx(first, rel=1e-12)
