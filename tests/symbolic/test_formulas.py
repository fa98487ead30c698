"""The arm's formulas and the reference trajectories, compiled: exactly the numbers that NumPy gives."""

import copy
import dataclasses
import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import UntraceableError
from prp_gym.robot import NOMINAL, REPORT, PRPArm
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Sine, SquareAcceleration, Trajectory
from tests.symbolic.compilation import Array, CompiledFunction, compile_together

ROWS = 20
FRICTION = dataclasses.replace(NOMINAL, viscous_friction=(0.5, 2.0, 0.1), coulomb_friction=(0.3, 1.5, 0.05))
ARMS = {"nominal": PRPArm(), "report": PRPArm(REPORT), "friction": PRPArm(FRICTION)}
NOT_TRACED = {"transforms", "inverse_kinematics", "inverse_dynamics"}
"""Methods that choose by numbers or fill arrays of numbers; the compiled simulation needs none of them."""

POSE = ("pose", "velocity", "acceleration")
METHODS = {
    name: tuple(inspect.signature(method).parameters)[1:]
    for name, method in inspect.getmembers(PRPArm, inspect.isfunction)
    if not name.startswith("_") and name not in ("parameter_vector", "use_plant")
}
"""Names of the arguments of every public method."""

TRACED = [name for name in METHODS if name not in NOT_TRACED]


def arguments(method: str) -> dict[str, Array]:
    """Random arguments (rows, components) by name."""
    generator = np.random.default_rng(len(method))
    q = generator.uniform(NOMINAL.joint_lower, NOMINAL.joint_upper, size=(ROWS, 3))
    motion = (q, *generator.uniform(-3.0, 3.0, size=(2, ROWS, 3)))
    known = {"joint_position": q, "tip_position": ARMS["nominal"].forward_kinematics(q)[..., :3]}
    known |= dict(zip(POSE, ARMS["nominal"].pose_motion(*motion), strict=True))
    drawn = {name: generator.uniform(-5.0, 5.0, size=(ROWS, 3)) for name in METHODS[method]}
    return {name: known.get(name, drawn[name]) for name in METHODS[method]}


def called(arm: PRPArm, method: str, values: dict[str, Any]) -> dict[str, Any]:
    """What a method returns, as arrays by name."""
    result = getattr(arm, method)(**values)
    return {f"result_{i}": each for i, each in enumerate(result if isinstance(result, tuple) else (result,))}


def traced(arm: str, method: str) -> SymbolicFunction:
    shapes = {name: values.shape[1:] for name, values in arguments(method).items()}
    return trace(f"{arm}_{method}", lambda **values: called(ARMS[arm], method, values), shapes)


@cache
def formulas() -> dict[str, CompiledFunction]:
    return compile_together(traced(arm, method) for arm in ARMS for method in TRACED)


@pytest.mark.parametrize("method", TRACED)
@pytest.mark.parametrize("arm", ARMS)
def test_compiled_formulas_are_those_of_numpy(arm: str, method: str) -> None:
    """For many states at once and for each alone."""
    code, values = formulas()[f"{arm}_{method}"], arguments(method)
    together = called(ARMS[arm], method, values)
    for row in range(ROWS):
        single = {name: array[row] for name, array in values.items()}
        alone = called(ARMS[arm], method, single)
        found = code(single)
        assert found.keys() == alone.keys()
        for name, result in found.items():
            np.testing.assert_array_equal(result, alone[name])
            np.testing.assert_array_equal(result, together[name][row])


@pytest.mark.parametrize("method", sorted(NOT_TRACED))
def test_formulas_that_need_numbers_are_refused(method: str) -> None:
    with pytest.raises(UntraceableError):
        traced("nominal", method)


def waypoints(count: int) -> QuinticWaypoints:
    """As many trajectories of four waypoints, each at times of its own."""
    generator = np.random.default_rng(0)
    times = np.cumsum(generator.uniform(0.2, 1.0, size=(count, 4)), axis=-1)
    return QuinticWaypoints(times, generator.normal(size=(count, 4, 3)))


def rows(count: int) -> tuple[Array, Array, Array]:
    return tuple(np.random.default_rng(count).uniform(0.5, 2.0, size=(3, count, 3)))


TRAJECTORIES: dict[str, Callable[[int], Trajectory]] = {
    "constant": lambda count: Constant(rows(count)[0]),
    "sine": lambda count: Sine(*rows(count), rows(count)[0] - 1.0),
    "square_acceleration": lambda count: SquareAcceleration(*rows(count)),
    "quintic_waypoints": waypoints,
}
TIMES = np.concatenate([[-0.5, 0.0, 1e-9], np.linspace(0.01, 6.0, 60)])


def attributes(trajectory: Trajectory) -> dict[str, Array]:
    return {each.name: getattr(trajectory, each.name) for each in dataclasses.fields(trajectory)}


def sampled(trajectory: Trajectory, time: Any, unknown: dict[str, Any]) -> dict[str, Any]:
    """A sample of a trajectory whose attributes are unknown."""
    like = copy.copy(trajectory)
    for name, values in unknown.items():
        object.__setattr__(like, name, values)
    return {"values": like.sample(time)}


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("name", TRAJECTORIES)
def test_compiled_trajectories_are_those_of_numpy(name: str, count: int) -> None:
    trajectory = TRAJECTORIES[name](count)
    given = attributes(trajectory)
    shapes = {"time": (count,), **{each: values.shape for each, values in given.items()}}
    function = trace(f"{name}_{count}", lambda time, **unknown: sampled(trajectory, time, unknown), shapes)
    ends = waypoints(count).times.T  # where segments end
    times = np.concatenate([np.repeat(TIMES[:, None], count, axis=1), ends])
    code, expected = compile_together([function])[function.name], trajectory.sample(times)
    for time, values in zip(times, expected, strict=True):
        np.testing.assert_array_equal(code({"time": time, **given})["values"], values)
        np.testing.assert_array_equal(function.evaluate({"time": time, **given})["values"], values)


def test_every_kind_of_trajectory_is_tested() -> None:
    kinds = {type(make(1)) for make in TRAJECTORIES.values()}
    assert kinds == {kind for kind in Trajectory.__subclasses__() if kind.__module__.startswith("prp_gym.")}
