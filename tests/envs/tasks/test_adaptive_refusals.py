"""Refusals of the one-link task, with name, value and unit."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, NonFiniteError, PRPError, ShapeError, UnknownNameError

ID = "PRP-Adaptive-v0"
NAN, INFINITY = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("name", "value", "kind", "message"),
    [
        ("inertia", 0.0, InvalidValueError, r"inertia is 0\.0 kg·m²; allowed: 0\.001 to 1000\."),
        ("inertia", -1, InvalidValueError, r"inertia is -1.0 kg·m²"),
        ("inertia", NAN, InvalidValueError, "inertia is nan kg·m²"),
        ("inertia", "heavy", InvalidValueError, "inertia is 'heavy' kg·m²; allowed: a number"),
        ("inertia", True, InvalidValueError, "inertia is True kg·m²; allowed: a number"),
        ("inertia", (1.0,), ShapeError, r"inertia has shape \(1,\); expected \(\)"),
        ("inertia", 1001, InvalidValueError, r"inertia is 1001\.0 kg·m²; allowed: 0\.001 to 1000\."),
        (
            "viscous_friction",
            -0.1,
            InvalidValueError,
            r"viscous_friction is -0\.1 N·m·s/rad; allowed: 0 to 1000\.",
        ),
        ("viscous_friction", INFINITY, InvalidValueError, "viscous_friction is inf N·m·s/rad"),
        ("gravity_moment", -0.1, InvalidValueError, r"gravity_moment is -0\.1 N·m; allowed: 0 to 1000\."),
        (
            "reference_frequency",
            0.04,
            InvalidValueError,
            r"reference_frequency is 0\.04 Hz; allowed: 0\.05 to 20\.",
        ),
        (
            "reference_frequency",
            20.5,
            InvalidValueError,
            r"reference_frequency is 20\.5 Hz; allowed: 0\.05 to 20",
        ),
        ("reference_frequency", INFINITY, InvalidValueError, "reference_frequency is inf Hz"),
        ("reference_frequency", NAN, InvalidValueError, "reference_frequency is nan Hz"),
        ("reference", "cosine", UnknownNameError, "unknown reference 'cosine'"),
        ("start", "home", UnknownNameError, "unexpected keyword argument 'start'"),
    ],
)
def test_impossible_keyword_is_refused(name: str, value: Any, kind: type[PRPError], message: str) -> None:
    with pytest.raises(kind, match=message):
        gymnasium.make(ID, **{name: value})


@pytest.mark.parametrize(
    ("name", "value", "kind", "message"),
    [
        ("inertia", -1.0, InvalidValueError, r"inertia is -1\.0 kg·m²; allowed: 0\.001 to 1000\."),
        ("inertia", INFINITY, NonFiniteError, "reset option 'inertia' is inf"),
        ("inertia", (1.0,), ShapeError, r"reset option 'inertia' has shape \(1,\); expected \(\)"),
        ("viscous_friction", -1.0, InvalidValueError, "viscous_friction is -1.0 N·m·s/rad"),
        ("gravity_moment", -1.0, InvalidValueError, "gravity_moment is -1.0 N·m"),
        (
            "joint_position",
            (0.0, 0.0, 0.0),
            ShapeError,
            r"'joint_position' has shape \(3,\); expected \(1,\)",
        ),
        (
            "joint_position",
            (1.1e5,),
            InvalidValueError,
            r"initial joint position is \[110000\.0\].*within ±100000\.",
        ),
        ("gravity_moment", True, InvalidValueError, "reset option 'gravity_moment' is True"),
        ("joint_velocity", (-501.0,), InvalidValueError, r"initial joint velocity is \[-501.0\].*±500"),
        ("goal", (0.0,), UnknownNameError, "unknown reset option 'goal'"),
    ],
)
def test_impossible_reset_option_is_refused_and_the_episode_goes_on(
    name: str, value: Any, kind: type[PRPError], message: str
) -> None:
    env, twin = (gymnasium.make(ID, scenario="realistic") for _ in range(2))
    for either in (env, twin):
        either.reset(seed=0)
        either.step(np.zeros(1))
    with pytest.raises(kind, match=message):
        env.reset(options={name: value})
    for _ in range(5):
        np.testing.assert_array_equal(env.step(np.zeros(1))[0], twin.step(np.zeros(1))[0])
