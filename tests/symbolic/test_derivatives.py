"""Derivatives by reverse accumulation, against central differences and the arm's own Jacobians."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import norm, solve_symmetric
from prp_gym.symbolic.array import SymbolicArray, elementwise
from prp_gym.symbolic.derivatives import adjoints, jacobian, transposed, unrounded
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.operations import OPERATIONS, SINGLE, Operation
from tests.symbolic.compilation import Array, arity, compile_together

ARM = PRPArm()
STEP = 1e-5  # of central differences ...
# ... whose truncation is 1e-10 / 6 times third derivatives up to 1e3, and whose rounding is 1e-16 / 1e-5
# times values up to 10
DIFFERENCE = 1e-7
ROUNDING = 1e-12  # some dozen operations of 1e-16 each
APART = 0.05  # the least distance of an argument from a switch
ROWS = 40


def away_from_switches(x: Array) -> bool:
    """Whether signs, comparisons and roundings of the numbers and of their ratios are the same nearby."""
    differences = np.subtract.outer(x, x)[~np.eye(x.size, dtype=bool)]
    doubled = 2.0 * np.concatenate([x, np.divide.outer(x, x)[~np.eye(x.size, dtype=bool)]])
    steady = np.abs(doubled - np.rint(doubled)).min() > APART
    return bool(steady and np.abs(x).min() > 0.3 and np.abs(differences).min(initial=1.0) > APART)


def points(size: int, count: int = ROWS) -> Array:
    """Random points away from switches (count, size)."""
    generator = np.random.default_rng(size)
    drawn = (generator.uniform(-3.0, 3.0, size=size) for _ in range(100 * count))
    kept = [x for x, _ in zip(filter(away_from_switches, drawn), range(count), strict=False)]
    assert len(kept) == count
    return np.array(kept)


def of_one(name: str, formula: Callable[[Any], Any], shape: tuple[int, ...]) -> SymbolicFunction:
    """A function y(x) with its Jacobian."""

    def both(x: SymbolicArray) -> dict[str, SymbolicArray]:
        y = formula(x)
        return {"y": y, "jacobian": jacobian(y, x)}

    return trace(name, both, {"x": shape})


def differences(function: SymbolicFunction, x: Array) -> Array:
    """Central differences of y by x (y.size, x.size)."""
    columns = []
    for step in STEP * np.eye(x.size):
        ahead, behind = (
            function.evaluate({"x": x + sign * step.reshape(x.shape)})["y"].ravel() for sign in (1.0, -1.0)
        )
        columns.append((ahead - behind) / (2.0 * STEP))
    return np.stack(columns, axis=-1)


def assert_derivatives_are_differences(function: SymbolicFunction, rows: Array) -> None:
    compared = 0
    for x in rows:
        result = function.evaluate({"x": x})
        if np.isfinite(result["y"]).all():
            expected = differences(function, x)
            np.testing.assert_allclose(result["jacobian"], expected, rtol=DIFFERENCE, atol=DIFFERENCE)
            compared += 1
    assert compared > len(rows) / 4


@pytest.mark.parametrize(
    "operation",
    [operation for operation in OPERATIONS if operation is not SINGLE],
    ids=lambda operation: operation.name,
)
def test_derivatives_of_operations_are_central_differences(operation: Operation) -> None:
    """An operation without adjoint is constant between its switches."""

    def formula(x: SymbolicArray) -> SymbolicArray:
        return SymbolicArray(x.graph, elementwise(x.graph, operation, *x).reshape(1))

    size = arity(operation)
    assert_derivatives_are_differences(of_one(operation.name, formula, (size,)), points(size))


def test_derivative_of_a_rounded_number_is_that_of_the_number() -> None:
    """Rounding is too coarse for differences, and has no slope that is of use."""

    def rounded(x: Any) -> Any:
        return np.sin(x.astype(np.float32).astype(np.float64))

    function = of_one("rounded", rounded, (3,))
    for x in points(3, 10):
        expected = np.diag(np.cos(x.astype(np.float32).astype(np.float64)))
        np.testing.assert_array_equal(function.evaluate({"x": x})["jacobian"], expected)


def written_into(x: Any) -> Any:
    """A formula with assignments to elements and operators that assign."""
    y = np.zeros_like(x)
    y[1:] = x[:2] * x[1:]
    y[:1] += np.sin(x[2:])
    y *= x[::-1]
    return y


COMPOSITIONS: dict[str, Callable[[Any], Any]] = {
    "length": lambda x: norm(x),
    "direction": lambda x: x / norm(x)[..., None],
    "nearest_turn": lambda x: (2.0 * x + np.pi) % (2.0 * np.pi) - np.pi,
    "saturation": lambda x: np.clip(x, -1.0, 2.0) * np.maximum(x, x[::-1]),
    "branches": lambda x: np.where(x > 0.0, np.exp(-x), x**2 * np.abs(x[::-1])),
    "angle": lambda x: np.arctan2(np.sin(x) * x[0], np.cos(x) + 2.0),
    "assignments": written_into,
    "same_factor_twice": lambda x: x * x + x * x[::-1] - x / x[::-1],
    "system": lambda x: solve_symmetric(x[:, None] * x + np.eye(3), np.sqrt(x * x + 1.0)),
    "largest": lambda x: np.stack([x.max(), np.minimum.reduce(x), x.sum()]),
}


@pytest.mark.parametrize("name", COMPOSITIONS)
def test_derivatives_of_compositions_are_central_differences(name: str) -> None:
    assert_derivatives_are_differences(of_one(name, COMPOSITIONS[name], (3,)), points(3, 10))


def test_derivative_of_the_pose_is_the_analytical_jacobian() -> None:
    function = of_one("pose", ARM.forward_kinematics, (3,))
    for q in points(3, 10):
        found = function.evaluate({"x": q})["jacobian"]
        np.testing.assert_allclose(found, ARM.analytical_jacobian(q), rtol=0, atol=ROUNDING)


def test_derivative_of_the_potential_energy_is_the_gravity() -> None:
    function = of_one("potential", ARM.potential_energy, (3,))
    for q in points(3, 10):
        found = function.evaluate({"x": q})["jacobian"][0]
        np.testing.assert_allclose(found, ARM.gravity_vector(q), rtol=0, atol=100.0 * ROUNDING)


def test_second_derivatives_are_central_differences_of_first_ones() -> None:
    def gradient(x: SymbolicArray) -> SymbolicArray:
        return jacobian(norm(x) * np.sin(x[0]) / (2.0 + np.cos(x[1])), x)[0]  # type: ignore[arg-type]

    assert_derivatives_are_differences(of_one("hessian", gradient, (3,)), points(3, 10))


@pytest.mark.parametrize("size", [1, 3])
def test_derivative_of_a_length_is_zero_at_zero(size: int) -> None:
    function = of_one("length", norm, (size,))
    np.testing.assert_array_equal(function.evaluate({"x": np.zeros(size)})["jacobian"], np.zeros((1, size)))


def test_derivative_of_a_direction_is_finite_at_zero() -> None:
    """Where a ufunc is told not to divide, the quotient that it leaves out has no part in derivatives."""

    def direction(x: Any) -> Any:
        length = norm(x)[..., None]
        return np.divide(x, length, out=np.zeros_like(x), where=length > 0.0)

    function = of_one("direction", direction, (3,))
    assert np.isfinite(function.evaluate({"x": np.zeros(3)})["jacobian"]).all()
    assert_derivatives_are_differences(function, points(3, 5))


def test_derivatives_by_what_has_no_effect_are_zero() -> None:
    def formula(x: SymbolicArray, unused: SymbolicArray) -> dict[str, SymbolicArray]:
        return {"by_unused": jacobian(x * x, unused), "of_constant": jacobian(x * 0.0 + 1.0, x)}

    function = trace("none", formula, {"x": (2,), "unused": (3,)})
    found = function.evaluate({"x": np.ones(2), "unused": np.ones(3)})
    np.testing.assert_array_equal(found["by_unused"], np.zeros((2, 3)))
    np.testing.assert_array_equal(found["of_constant"], np.zeros((2, 2)))


def test_adjoints_are_those_of_the_weighted_sum() -> None:
    def formula(x: SymbolicArray) -> dict[str, SymbolicArray]:
        y = np.exp(x) * x[::-1]
        first, second = y.flat()  # type: ignore[operator]
        found = adjoints({first: 2.0, second: -3.0})
        gradient = np.array([found[node] for node in x.flat()], dtype=object)
        return {"y": y, "gradient": SymbolicArray(x.graph, gradient), "jacobian": jacobian(y, x)}  # type: ignore[dict-item,arg-type]

    result = trace("weighted", formula, {"x": (2,)}).evaluate({"x": np.array([0.3, -0.7])})
    expected = np.array([2.0, -3.0]) @ result["jacobian"]
    np.testing.assert_allclose(result["gradient"], expected, rtol=0, atol=ROUNDING)


def dynamics(q: Any, velocity: Any, torque: Any) -> dict[str, Any]:
    acceleration = ARM.forward_dynamics(q, velocity, torque)
    return {"acceleration": acceleration, "pose": ARM.forward_kinematics(q), "again": acceleration[..., :1]}


def test_transposed_function_is_the_transposed_jacobian_times_the_weights() -> None:
    shapes = {"q": (3,), "velocity": (3,), "torque": (3,)}
    function = trace("dynamics", dynamics, shapes)
    backward = transposed(function, "backward", ("q", "torque"))
    assert set(backward.outputs) == {"d_q", "d_torque"}
    assert set(backward.inputs) == {*shapes, "d_acceleration", "d_pose", "d_again"}
    compiled = compile_together([function, backward])["backward"]
    generator = np.random.default_rng(0)
    for _ in range(10):
        values = {name: generator.normal(size=array.shape) for name, array in backward.inputs.items()}
        found = backward.evaluate(values)
        for name, expected in compiled(values).items():
            np.testing.assert_array_equal(found[name], expected)
        for name in ("q", "torque"):
            slope = slope_of_the_weighted_sum(function, values, name)
            # accelerations up to 100, weighted, in the place of values up to 10
            np.testing.assert_allclose(found[f"d_{name}"], slope, rtol=DIFFERENCE, atol=100.0 * DIFFERENCE)


def slope_of_the_weighted_sum(function: SymbolicFunction, values: dict[str, Array], name: str) -> Array:
    """Central differences of Σ d_output · output by an input."""

    def weighted(x: Array) -> float:
        outputs = function.evaluate({**values, name: x})
        return float(sum((values[f"d_{each}"] * outputs[each]).sum() for each in outputs))

    steps = STEP * np.eye(3)
    return np.array([weighted(values[name] + s) - weighted(values[name] - s) for s in steps]) / (2 * STEP)


def test_transposed_function_without_effect_is_zero() -> None:
    function = trace("constant", lambda x: {"y": x * 0.0 + 2.0}, {"x": (2,)})
    backward = transposed(function, "backward", ("x",))
    found = backward.evaluate({"x": np.ones(2), "d_y": np.ones(2)})
    np.testing.assert_array_equal(found["d_x"], np.zeros(2))


def test_a_function_without_its_rounding_is_the_formula_of_doubles() -> None:
    def formula(x: Any, other: Any) -> dict[str, Any]:
        return {"y": np.where(x > 0.0, x / 3.0, 1.0).astype(np.float32), "unused": x[:1]}

    rounded = trace("rounded", formula, {"x": (2,), "other": (1,)})
    smooth = unrounded(rounded, "smooth")
    values = {"x": np.array([0.1, -0.1]), "other": np.zeros(1)}
    assert rounded.evaluate(values)["y"].tolist() == [float(np.float32(0.1 / 3.0)), 1.0]
    assert smooth.evaluate(values)["y"].tolist() == [0.1 / 3.0, 1.0]
    assert smooth.inputs.keys() == rounded.inputs.keys()
    assert smooth.name == "smooth"
    assert not any(node.operation is SINGLE for node in smooth.nodes())
