"""Every environment among many has its own world and its own reset options, and no world is built anew."""

from typing import Any

import numpy as np
import pytest

from prp_gym.drawing.overlay import Ball
from prp_gym.drawing.overlay import Path as OverlayPath
from prp_gym.envs import PRPVectorEnv
from prp_gym.errors import InvalidValueError, JointLimitError, NonFiniteError, ShapeError, UnknownNameError
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from tests.support.covering import covering
from tests.support.vector_episodes import IDS, SHORT, actions_for, assert_same, bits, single, together

N = 3
ARM = PRPArm()
CONTACT_IDS = [name for name in IDS if "surface_stiffness" in single(name).task.reset_options]
ARM_IDS = [name for name in IDS if name != "PRP-Adaptive-v0"]
SURFACE = ("body_pos", "body_quat", "pair_solref")
PLANT = ("body_mass", "body_inertia", "dof_damping", "dof_frictionloss")
LINK = ("body_mass", "body_ipos", "dof_damping")


def worlds(env: PRPVectorEnv, names: tuple[str, ...]) -> list[bytes]:
    """Fields of each environment's model, to the bit."""
    models = [env.physics.model(index) for index in range(env.num_envs)]
    return [b"".join(bits(getattr(model, name)) for name in names) for model in models]


def fields_of(environment_id: str, scenario: str) -> tuple[str, ...]:
    """Fields of the model that a scenario draws."""
    if environment_id not in ARM_IDS:
        return LINK
    surface = SURFACE if environment_id in CONTACT_IDS else ()
    return surface + (PLANT if scenario == "realistic" else ())


@pytest.mark.parametrize(("scenario", "mode"), [("randomized", "NextStep"), ("realistic", "SameStep")])
@pytest.mark.parametrize("environment_id", IDS)
def test_every_episode_of_every_environment_has_its_own_world_without_a_new_build(
    environment_id: str, scenario: str, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = fields_of(environment_id, scenario)
    env = together(environment_id, mode, N, scenario=scenario, **SHORT)
    alone = [single(environment_id, scenario=scenario, **SHORT) for _ in range(N)]
    env.reset(seed=3)
    for index, own in enumerate(alone):
        own.reset(seed=3 + index)
    batch = env.physics.batch
    monkeypatch.setattr(type(env.physics), "_build", None)  # nothing is built from here on
    seen = []
    for episode in range(3):
        if episode:
            for own in alone:
                own.reset()
        for field in names:
            own_fields = worlds(env, (field,))
            assert len(set(own_fields)) == N, field
            assert own_fields == [bits(getattr(own.physics.model(), field)) for own in alone], field
        seen += worlds(env, names)
        for action in actions_for(env, 7 if mode == "NextStep" else 6):
            env.step(action)
    assert env.physics.batch is batch
    if names:
        assert len(set(seen)) == 3 * N


@pytest.mark.parametrize("environment_id", ARM_IDS)
def test_arms_are_the_nominal_one_where_a_scenario_does_not_draw_them(environment_id: str) -> None:
    env = together(environment_id, scenario="randomized", num_envs=N)
    env.reset(seed=0)
    assert len(set(worlds(env, PLANT))) == 1


def options_of(name: str) -> Array:
    """Values of a reset option, one for each environment."""
    rng = np.random.default_rng(8)
    if name == "surface_stiffness":
        return np.geomspace(60.0, 4000.0, N)
    if name == "surface_normal":
        return np.array([[np.sin(turn), -np.cos(turn), 0.0] for turn in np.linspace(-0.2, 0.2, N)])
    if name == "surface_damping":
        return np.linspace(0.0, 20.0, N)
    if name == "surface_offset":
        return np.linspace(0.3, 0.5, N)
    if name == "joint_velocity":
        return rng.uniform(-1.0, 1.0, (N, 3))
    if name == "desired_force":
        return np.linspace(1.0, 8.0, N)
    return rng.uniform([-1.0, -0.25, -1.0], [1.0, -0.05, 1.0], (N, 3))


def check_taken(env: PRPVectorEnv, index: int, option: str, value: Array, observation: Array) -> None:
    """The environment started with the value, where that can be observed."""
    if option == "desired_force":
        force = env.observation_layout.split(observation)[option]
        assert np.linalg.norm(force) == pytest.approx(float(value))
    elif option in env.observation_layout.names:
        found = env.observation_layout.split(observation)[option]
        np.testing.assert_array_equal(found, value)
    elif option == "goal":
        shown = env.task.overlay(index, 100.0)[0]
        assert isinstance(shown, Ball | OverlayPath)
        end = shown.center if isinstance(shown, Ball) else shown.points[-1]  # of a path, when it rests
        # sums of three products of numbers below 1
        np.testing.assert_allclose(end, ARM.forward_kinematics(value)[:3], atol=1e-14)


COVERING = covering(
    [
        (name, option)
        for name in ARM_IDS
        for option in single(name).task.reset_options
        if name in CONTACT_IDS or option in ("joint_position", "goal")
    ],
    lambda each: (each[1], each[0] in CONTACT_IDS),
)
"""Every reset option with and without contact, and every environment of the arm."""


@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize(("environment_id", "option"), COVERING)
def test_reset_options_are_those_of_single_environments(
    environment_id: str, option: str, shared: bool
) -> None:
    values = options_of(option)
    env = together(environment_id, "Disabled", N, scenario="realistic")
    observation, _ = env.reset(seed=1, options={option: values[2] if shared else values})
    acted = [env.step(action)[0] for action in actions_for(env, 3)]
    physics = worlds(env, SURFACE) if environment_id in CONTACT_IDS else []
    for index in range(N):
        own = single(environment_id, scenario="realistic")
        expected, _ = own.reset(seed=1 + index, options={option: values[2 if shared else index]})
        np.testing.assert_array_equal(observation[index], expected)
        for step, action in zip(acted, actions_for(env, 3), strict=True):
            np.testing.assert_array_equal(step[index], own.step(action[index])[0])
        if physics:
            assert physics[index] == b"".join(bits(getattr(own.physics.model(), name)) for name in SURFACE)
        check_taken(env, index, option, values[2 if shared else index], observation[index])


@pytest.mark.parametrize("count", [1, 3])
def test_one_value_for_each_environment_is_accepted_for_any_number_of_them(count: int) -> None:
    env = together("PRP-Compliance-v0", num_envs=count)
    goal = np.tile([0.1, -0.2, 0.3], (count, 1))
    stiffness = np.full(count, 100.0)
    found, _ = env.reset(seed=0, options={"goal": goal, "surface_stiffness": stiffness})
    expected, _ = env.reset(seed=0, options={"goal": goal[0], "surface_stiffness": 100.0})
    np.testing.assert_array_equal(found, expected)


def test_options_with_a_mask_are_those_of_the_environments_that_begin_anew() -> None:
    env, twin = (together("PRP-Impedance-v0", num_envs=N, **SHORT) for _ in range(2))
    values, mask = options_of("surface_stiffness"), np.array([False, True, True])
    for each in (env, twin):
        each.reset(seed=2)
    before = worlds(env, SURFACE)
    given = {"surface_stiffness": values, "joint_position": options_of("joint_position"), "reset_mask": mask}
    env.reset(seed=[None, 50, 51], options=given)
    assert set(given) == {"surface_stiffness", "joint_position", "reset_mask"}  # left as it was
    after = worlds(env, SURFACE)
    assert [old == new for old, new in zip(before, after, strict=True)] == [True, False, False]
    alone = []
    for index, seed in ((1, 50), (2, 51)):
        own = single("PRP-Impedance-v0", **SHORT)
        own.reset(
            seed=seed, options={name: given[name][index] for name in ("surface_stiffness", "joint_position")}
        )
        alone.append((index, own))
    for action in actions_for(env, 5):
        found, others = env.step(action)[0], twin.step(action)[0]
        np.testing.assert_array_equal(found[~mask], others[~mask])
        for index, own in alone:
            np.testing.assert_array_equal(found[index], own.step(action[index])[0])


def test_options_hold_for_one_episode_only() -> None:
    env = together("PRP-Compliance-v0", "SameStep", N, scenario="report", **SHORT)
    target_impedance = {"joint_position": np.tile([0.2, -0.1, 0.1], (N, 1))}
    plain, _ = env.reset(seed=0)
    given, _ = env.reset(seed=0, options=target_impedance)
    assert (plain != given).any()
    for action in actions_for(env, 6, share=1e-3):  # of the report's huge limits
        observation, *_ = env.step(action)
    np.testing.assert_array_equal(observation, plain)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"surface_stiffness": np.ones(4)}, ShapeError, r"'surface_stiffness' has shape \(4,\); .* \(3,\)"),
        ({"surface_stiffness": np.ones((3, 1))}, ShapeError, r"expected \(\) or \(3,\)"),
        ({"goal": np.zeros(5)}, ShapeError, r"'goal' has shape \(5,\); expected \(3,\) or \(3, 3\)"),
        ({"goal": np.zeros((3, 2))}, ShapeError, r"'goal' has shape \(3, 2\)"),
        ({"goal": np.zeros((1, 3))}, ShapeError, r"'goal' has shape \(1, 3\)"),
        ({"goal": np.full((3, 3), np.nan)}, NonFiniteError, "reset option 'goal'"),
        ({"surface_stiffness": [1.0, 2.0, np.inf]}, NonFiniteError, "surface_stiffness"),
        ({"joint_position": "home"}, InvalidValueError, "'joint_position' is 'home'; allowed: a number"),
        ({"joint_position": [[0, 0, 0], [0, 0]]}, InvalidValueError, "joint_position"),
        ({"goals": np.zeros(3)}, UnknownNameError, "unknown reset option 'goals'. Did you mean 'goal'"),
        ({"reset_masks": np.ones(3, bool)}, UnknownNameError, "unknown reset option 'reset_masks'"),
        ({"surface_stiffness": [1.0, 2.0, -5.0]}, InvalidValueError, r"is -5.0 N/m; allowed"),
        ({"joint_position": np.eye(3) * 4.0}, JointLimitError, "joint 1 is 4 rad"),
        (5, InvalidValueError, "reset options is 5; allowed: a dictionary"),
        ([("goal", np.zeros(3))], InvalidValueError, "allowed: a dictionary"),
    ],
)
def test_options_that_are_refused_change_no_bit_of_what_follows(
    options: Any, error: type[Exception], words: str
) -> None:
    env, twin = (
        together("PRP-ForcePosition-v0", "Disabled", N, scenario="realistic", **SHORT) for _ in range(2)
    )
    for each in (env, twin):
        each.reset(seed=2)
        each.step(actions_for(each, 1)[0])
    with pytest.raises(error, match=words):
        env.reset(options=options)
    for action in actions_for(env, 5):
        assert_same(env.step(action), twin.step(action), "step")
    if error is not JointLimitError and "-5.0" not in words:  # these are met when episodes are drawn
        assert_same(env.reset(), twin.reset(), "reset")


def test_seeds_of_a_refused_reset_are_not_used() -> None:
    env, twin = together("PRP-Impedance-v0", num_envs=N), together("PRP-Impedance-v0", num_envs=N)
    for each in (env, twin):
        each.reset(seed=2)
    for options in ({"goal": np.zeros(2)}, {"no": 1.0}, {"reset_mask": np.zeros(N, dtype=np.bool_)}):
        with pytest.raises((ShapeError, UnknownNameError, InvalidValueError)):
            env.reset(seed=9, options=options)
    assert env.np_random_seed == twin.np_random_seed
    assert_same(env.reset(), twin.reset(), "reset")
