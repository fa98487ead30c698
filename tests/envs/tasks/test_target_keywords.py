"""The target models' numbers: what keywords replace, and what they refuse."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs import PRPEnv
from prp_gym.envs.base.target_errors import TargetErrors
from prp_gym.errors import InvalidValueError, PRPError, ShapeError, UnknownNameError
from prp_gym.robot.arrays import Array

COMPLIANCE, IMPEDANCE, ADMITTANCE = "PRP-Compliance-v0", "PRP-Impedance-v0", "PRP-Admittance-v0"


def environment(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def target(env: PRPEnv) -> tuple[Array, Array, Array]:
    """M, K_D, K_P (6) of an environment's target model."""
    assert isinstance(env.task.parts.errors, TargetErrors)
    model = env.task.parts.errors.target
    return model.inertia, model.damping, model.stiffness


@pytest.mark.parametrize("environment_id", [IMPEDANCE, ADMITTANCE])
def test_target_keywords_replace_the_tasks_own_numbers_and_no_others(environment_id: str) -> None:
    own = target(environment(environment_id))
    names = ("target_inertia", "target_damping", "target_stiffness")
    for index, name in enumerate(names):
        for value, expected in ((3, [3.0] * 6), ([1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6])):
            found = target(environment(environment_id, **{name: value}))
            for axis_kind in range(3):
                np.testing.assert_array_equal(
                    found[axis_kind], expected if axis_kind == index else own[axis_kind]
                )


def test_static_task_takes_no_inertia_or_damping() -> None:
    for name in ("target_inertia", "target_damping"):
        with pytest.raises(UnknownNameError, match=f"unexpected keyword argument '{name}'"):
            environment(COMPLIANCE, **{name: 1.0})


@pytest.mark.parametrize("name", ["target_inertia", "target_damping", "target_stiffness"])
@pytest.mark.parametrize("end", [0, 1])
def test_targets_at_the_end_of_their_bounds_are_taken_and_move_finitely(name: str, end: int) -> None:
    bounds = {
        "target_inertia": (1e-3, 1e3),
        "target_damping": (0.0, 1e5),
        "target_stiffness": (0.0, 1e6),
    }
    for frequency in (1, 1000):
        keywords = {name: bounds[name][end], "control_frequency": frequency, "duration": 5.0}
        env = environment(IMPEDANCE, **keywords)
        own = target(env)[tuple(bounds).index(name)]
        np.testing.assert_array_equal(own, bounds[name][end])
        env.reset(seed=0)
        for _ in range(5):
            env.step(np.zeros(3))
            assert np.isfinite(env.ground_truth).all()


@pytest.mark.parametrize(
    ("environment_id", "name", "value", "kind", "message"),
    [
        (
            COMPLIANCE,
            "target_stiffness",
            -1.0,
            InvalidValueError,
            r"target_stiffness is -1\.0 N/m, N·m/rad; allowed: 0 to 1e\+06\.",
        ),
        (
            IMPEDANCE,
            "target_stiffness",
            (1, 2, 3),
            ShapeError,
            r"target_stiffness has shape \(3,\); expected",
        ),
        (
            IMPEDANCE,
            "target_damping",
            float("nan"),
            InvalidValueError,
            "target_damping is nan N·s/m, N·m·s/rad",
        ),
        (
            IMPEDANCE,
            "target_damping",
            "much",
            InvalidValueError,
            "target_damping is 'much' N·s/m, .*: a number or numbers",
        ),
        (ADMITTANCE, "target_inertia", float("inf"), InvalidValueError, "target_inertia is inf kg, kg·m²"),
        (
            ADMITTANCE,
            "target_inertia",
            0.0,
            InvalidValueError,
            r"target_inertia is 0\.0 .*allowed: 0\.001 to 1000\.",
        ),
        (
            IMPEDANCE,
            "target_inertia",
            1001,
            InvalidValueError,
            r"target_inertia is 1001 .*: 0\.001 to 1000\.",
        ),
        (IMPEDANCE, "target_damping", 1.1e5, InvalidValueError, r"target_damping is .*: 0 to 100000\."),
        (COMPLIANCE, "target_stiffness", True, InvalidValueError, "target_stiffness is True .*: a number"),
        (
            ADMITTANCE,
            "target_inertia",
            (1, 1, 0, 1, 1, 1),
            InvalidValueError,
            r"target_inertia is \(1, 1, 0, 1, 1, 1\) kg, kg·m²; allowed: 0\.001",
        ),
        (ADMITTANCE, "reference", "stay", UnknownNameError, "unknown reference 'stay'"),
    ],
)
def test_impossible_target_is_refused(
    environment_id: str, name: str, value: Any, kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        gymnasium.make(environment_id, **{name: value})
