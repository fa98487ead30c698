"""Contact tasks: the surface acts as declared, `info` has its force, impossible ones are refused."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs.base.surface_options import SURFACE_BOUNDS
from prp_gym.errors import (
    InvalidValueError,
    JointLimitError,
    NonFiniteError,
    PRPError,
    ShapeError,
    UnknownNameError,
)
from prp_gym.robot.arrays import Array
from tests.support.contact_episodes import (
    ARM,
    CONTACT_IDS,
    assert_force,
    depth_of,
    draw,
    environment,
    ground_truth_of,
    task_of,
)

PLANE = {"surface_normal": (0.0, -1.0, 0.0), "surface_offset": 0.44}
PRESSED = {"joint_position": (0.0, -0.15, 0.0), **PLANE}  # tip at y = -0.39 m: 0.05 m deep
NAN, INFINITY = float("nan"), float("inf")


@pytest.fixture(params=CONTACT_IDS)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def begun(environment_id: str, options: Mapping[str, Any], **keywords: Any) -> dict[str, Array]:
    """The ground truth at the start of an episode, by field."""
    env = environment(environment_id, **keywords)
    env.reset(seed=0, options=dict(options))
    return ground_truth_of(env)


def test_keywords_of_the_surface_take_effect(environment_id: str) -> None:
    keywords = {"surface_stiffness": 200.0, "surface_damping": 3.0, **PLANE}
    options = {"joint_position": (0.0, -0.15, 0.0), "joint_velocity": (0.0, -0.1, 0.0)}
    ground_truth = begun(environment_id, options, **keywords)
    # 0.05 m deep and going deeper at 0.1 m/s; by the tip on the surface, along +y
    expected = [0.0, 200.0 * 0.05 + 3.0 * 0.1, 0.0]
    assert_force(ground_truth["contact_force"], expected)


def test_reset_options_of_the_surface_take_effect_and_override_keywords(environment_id: str) -> None:
    keywords = {"surface_stiffness": 200.0, "surface_damping": 3.0, **PLANE}
    options = {
        "joint_position": (0.0, -0.15, 0.0),
        "joint_velocity": (0.0, -0.1, 0.0),
        "surface_stiffness": 100.0,
        "surface_damping": 5.0,
        "surface_normal": (-1.0, 0.0, 0.0),
        "surface_offset": -0.37,
    }
    ground_truth = begun(environment_id, options, **keywords)
    # x = 0.4 m is 0.03 m behind the plane x = 0.37; the slide moves along it
    assert_force(ground_truth["contact_force"], [3.0, 0.0, 0.0])
    env = environment(environment_id, **keywords)
    env.reset(seed=0, options=options)
    env.reset(seed=0, options={"joint_position": (0.0, -0.15, 0.0)})
    # options are of one episode
    assert_force(ground_truth_of(env)["contact_force"], [0.0, 10.0, 0.0])


@pytest.mark.parametrize("seed", range(6))
def test_any_plane_pushes_back_along_its_normal_with_stiffness_times_depth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = rng.uniform([-3.0, -0.28, -1.4], [3.0, -0.02, 1.4])
    normal, depth = rng.normal(size=3), rng.uniform(0.02, 0.1)
    unit = normal / np.linalg.norm(normal)
    offset = unit @ ARM.forward_kinematics(q)[:3] + depth
    options = {
        "joint_position": q,
        "surface_normal": normal,
        "surface_offset": offset,
        "surface_stiffness": 300.0,
        "surface_damping": 0.0,
    }
    ground_truth = begun("PRP-Compliance-v0", options)
    assert_force(ground_truth["contact_force"], -unit * 300.0 * depth, atol=0.06)
    away = {**options, "surface_offset": offset - depth - 1e-3}
    np.testing.assert_array_equal(begun("PRP-Compliance-v0", away)["contact_force"], 0.0)


def test_static_contact_force_is_stiffness_times_depth(environment_id: str) -> None:
    env = environment(environment_id, surface_stiffness=400.0, surface_damping=20.0, duration=2.0, **PLANE)
    env.reset(seed=0, options={"joint_position": (0.0, -0.1, 0.0)})
    stiffness, damping = np.array([2000.0, 0.0, 20.0]), np.array([60.0, 20.0, 1.0])
    for _ in range(1000):
        q, velocity = env.physics.joint_position[0], env.physics.joint_velocity[0]
        torque = ARM.gravity_vector(q) - stiffness * q - damping * velocity - np.array([0.0, 8.0, 0.0])
        _, _, _, truncated, info = env.step(torque / env.torque_limit)
    assert truncated
    parts = ground_truth_of(env)
    depth = ARM.forward_kinematics(parts["joint_position"])[1] + 0.44
    # at rest to 1e-7 of the force; 8 N pull the slide in, turned by what joint 1 yields, 2e-3 rad
    np.testing.assert_allclose(parts["contact_force"], [0.0, 400.0 * depth, 0.0], rtol=1e-6, atol=1e-9)
    assert parts["contact_force"][1] == pytest.approx(8.0, rel=1e-4)
    assert info["contact_force"] == pytest.approx(8.0, rel=1e-4)


def test_info_reports_the_force_and_whether_it_is_beyond_its_bound(environment_id: str) -> None:
    env = environment(environment_id)
    for stiffness, beyond in ((900.0, 0.0), (1100.0, 1.0), (0.5, 0.0)):
        env.reset(seed=0, options={**PRESSED, "surface_stiffness": stiffness, "surface_damping": 0.0})
        *_, info = env.step(np.zeros(3))
        # 0.05 m deep, out by millimetres within 2 ms at most: 45 N, 55 N and less than 1 N
        assert info["contact_force"] == pytest.approx(0.05 * stiffness, rel=0.05)
        force = np.linalg.norm(ground_truth_of(env)["contact_force"])
        assert info["contact_force"] == pytest.approx(force, rel=1e-15)  # one root
        assert info["cost_force_bound"] == beyond
    assert env.task.numbers.constants["force_bound"] == 50.0
    units = {field.name: field.unit for field in env.info_fields}
    assert units["contact_force"] == "N"


def test_tip_off_the_surface_has_no_contact_force_and_no_cost(environment_id: str) -> None:
    env = environment(environment_id)
    env.reset(seed=0, options={**PRESSED, "surface_offset": 0.38, "surface_stiffness": 5000.0})
    *_, info = env.step(np.zeros(3))
    assert info["contact_force"] == info["cost_force_bound"] == 0.0
    np.testing.assert_array_equal(ground_truth_of(env)["contact_force"], 0.0)


def test_drawn_surface_of_each_environment_is_its_own() -> None:
    task = task_of("PRP-Impedance-v0")
    physics = task.make_physics(0.001, 3, 1)
    starts = [draw(task, seed) for seed in range(3)]
    rngs = [np.random.default_rng(seed) for seed in range(3)]
    inside = [start.joint_position for start in starts]
    task.configure(physics, np.arange(3), task.draw(rngs, {}), task.draw_plants(rngs))
    # every tip 0.02 m inside its own surface along the slide, whose direction is the normal's
    for start, q in zip(starts, inside, strict=True):
        slide = start.surface.normal[0] @ (np.sin(q[0]), -np.cos(q[0]), 0.0)
        q[1] -= (0.02 - depth_of(start, q)) / slide
    physics.reset(np.arange(3), np.array(inside), np.zeros((3, 3)))
    for row, start in enumerate(starts):
        expected = -start.surface.normal[0] * start.surface.stiffness[0] * 0.02
        assert_force(physics.contact_force[row], expected)


@pytest.mark.parametrize(
    ("name", "value", "kind", "message"),
    [
        (
            "surface_stiffness",
            0.0,
            InvalidValueError,
            r"surface_stiffness is 0.0 N/m; allowed: 0.001 to 1000",
        ),
        ("surface_stiffness", -5.0, InvalidValueError, r"surface_stiffness is -5.0 N/m; allowed: 0.001 to"),
        ("surface_stiffness", 1.1e5, InvalidValueError, r"surface_stiffness is 110000.0 N/m; .* to 100000\."),
        ("surface_stiffness", NAN, InvalidValueError, r"surface_stiffness is nan N/m"),
        ("surface_stiffness", INFINITY, InvalidValueError, r"surface_stiffness is inf N/m"),
        ("surface_stiffness", True, InvalidValueError, r"surface_stiffness is True N/m; allowed: a number"),
        ("surface_stiffness", "50", InvalidValueError, r"surface_stiffness is '50' N/m; allowed: a number"),
        (
            "surface_stiffness",
            "stiff",
            InvalidValueError,
            r"surface_stiffness is 'stiff' N/m; allowed: a num",
        ),
        ("surface_stiffness", (1.0, 2.0), ShapeError, r"surface_stiffness has shape \(2,\); expected \(\)"),
        ("surface_damping", -0.1, InvalidValueError, r"surface_damping is -0.1 N·s/m; allowed: 0 to 1000\."),
        (
            "surface_damping",
            1001,
            InvalidValueError,
            r"surface_damping is 1001.0 N·s/m; allowed: 0 to 1000\.",
        ),
        ("surface_damping", INFINITY, InvalidValueError, r"surface_damping is inf N·s/m"),
        (
            "surface_normal",
            (0, 0, 0),
            InvalidValueError,
            r"surface normal is \[0.0, 0.0, 0.0\]; allowed: a v",
        ),
        ("surface_normal", (0, NAN, 1), InvalidValueError, r"surface normal is \[0.0, nan, 1.0\]"),
        ("surface_normal", (0, 1), ShapeError, r"surface_normal has shape \(2,\); expected \(3,\)"),
        ("surface_normal", "up", InvalidValueError, r"surface_normal is 'up'; allowed: a number or numbers"),
        ("surface_normal", (True, False, False), InvalidValueError, r"surface_normal is .* a number or num"),
        ("surface_normal", ((1,), (0, 1)), InvalidValueError, r"surface_normal is .* a number or numbers"),
        ("surface_offset", NAN, InvalidValueError, r"surface_offset is nan m; allowed: -5 to 5\."),
        ("surface_offset", -5.1, InvalidValueError, r"surface_offset is -5.1 m; allowed: -5 to 5\."),
        ("surface_offset", 5.1, InvalidValueError, r"surface_offset is 5.1 m; allowed: -5 to 5\."),
        ("surface_offset", (0.1,), ShapeError, r"surface_offset has shape \(1,\); expected \(\)"),
    ],
)
def test_impossible_surface_is_refused_as_keyword(
    environment_id: str, name: str, value: Any, kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        gymnasium.make(environment_id, **{name: value})


@pytest.mark.parametrize(
    ("name", "value", "kind", "message"),
    [
        (
            "surface_stiffness",
            0.0,
            InvalidValueError,
            r"surface_stiffness is 0.0 N/m; allowed: 0.001 to 1000",
        ),
        ("surface_stiffness", 1.1e5, InvalidValueError, r"surface_stiffness is 110000.0 N/m; allowed: 0.001"),
        ("surface_stiffness", NAN, NonFiniteError, "reset option 'surface_stiffness' is nan"),
        ("surface_stiffness", True, InvalidValueError, "reset option 'surface_stiffness' is True"),
        ("surface_stiffness", "stiff", InvalidValueError, "reset option 'surface_stiffness' is 'stiff'"),
        ("surface_stiffness", (1.0, 2.0), ShapeError, r"reset option 'surface_stiffness' has shape \(2,\)"),
        ("surface_damping", -0.1, InvalidValueError, r"surface_damping is -0.1 N·s/m; allowed: 0 to 1000\."),
        ("surface_normal", (0, 0, 0), InvalidValueError, "surface normal is .*a vector of positive length"),
        ("surface_normal", (0, 1), ShapeError, r"reset option 'surface_normal' has shape \(2,\)"),
        ("surface_offset", -5.1, InvalidValueError, r"surface_offset is -5.1 m; allowed: -5 to 5\."),
        ("surface_offset", INFINITY, NonFiniteError, "reset option 'surface_offset' is inf"),
        ("joint_position", (0.0, -0.4, 0.0), JointLimitError, "initial joint position: joint 2 is -0.4 m"),
        ("joint_velocity", (0.0, 101.0, 0.0), InvalidValueError, "initial joint velocity"),
    ],
)
def test_impossible_reset_option_is_refused_and_the_episode_goes_on(
    environment_id: str, name: str, value: Any, kind: type[PRPError], message: str
) -> None:
    env, twin = (environment(environment_id, scenario="realistic") for _ in range(2))
    options = {**PRESSED, "surface_stiffness": 100.0}
    for either in (env, twin):
        either.reset(seed=0, options=options)
        either.step(np.zeros(3))
    with pytest.raises(kind, match=message):
        env.reset(options={name: value})
    for _ in range(5):
        np.testing.assert_array_equal(env.step(np.zeros(3))[0], twin.step(np.zeros(3))[0])
        np.testing.assert_array_equal(env.ground_truth, twin.ground_truth)


def test_impossible_goal_is_refused_and_force_regulation_takes_none(environment_id: str) -> None:
    env = environment(environment_id)
    if environment_id == "PRP-Force-v0":
        assert "goal" not in env.task.reset_options
        with pytest.raises(UnknownNameError, match="unknown reset option 'goal'"):
            env.reset(seed=0, options={"goal": (0.0, -0.1, 0.0)})
    else:
        with pytest.raises(JointLimitError, match=r"goal: joint 2 is 0\.1 m; allowed: -0\.3 to 0 m"):
            env.reset(seed=0, options={"goal": (0.0, 0.1, 0.0)})


@pytest.mark.parametrize(("name", "bounds"), SURFACE_BOUNDS.items())
@pytest.mark.parametrize("end", [0, 1])
def test_surface_at_the_end_of_its_bounds_is_taken(name: str, bounds: tuple[float, float], end: int) -> None:
    value: dict[str, Any] = {name: bounds[end]}
    plain, keyed = task_of("PRP-Compliance-v0"), task_of("PRP-Compliance-v0", **value)
    for start in (draw(plain, 0, **value), draw(keyed, 0)):
        assert getattr(start.surface, name.removeprefix("surface_"))[0] == bounds[end]


def test_hardest_surface_pushes_within_the_declared_bounds(environment_id: str) -> None:
    """Stiffest, and as far before the arm as a surface may be: an observation that the space contains."""
    hardest: dict[str, Any] = {name: bounds[1] for name, bounds in SURFACE_BOUNDS.items()}
    hardest["surface_normal"] = (0.0, -1.0, 0.0)
    env = environment(environment_id, scenario="report")
    observation, _ = env.reset(seed=0, options=hardest)
    depth = 5.0 + ARM.forward_kinematics(ground_truth_of(env)["joint_position"])[1]
    assert depth > 4.0
    assert_force(ground_truth_of(env)["contact_force"], [0.0, 1e5 * depth, 0.0])
    assert env.observation_space.contains(observation)


def test_initial_joint_state_is_the_requested_one(environment_id: str) -> None:
    position, velocity = (0.3, -0.2, 0.1), (0.1, -0.2, 0.3)
    ground_truth = begun(environment_id, {"joint_position": position, "joint_velocity": velocity})
    np.testing.assert_array_equal(ground_truth["joint_position"], position)
    np.testing.assert_array_equal(ground_truth["joint_velocity"], velocity)
