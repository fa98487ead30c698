"""The target impedance of a task: passed to the controllers, which render it with tuned gains only."""

from contextlib import closing
from dataclasses import MISSING, fields
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import TimeLimit

import prp_gym
from prp_gym.baselines import BASELINES, ControlInterface, list_baselines, make_baseline
from prp_gym.baselines.base.gains import gain_sets, load_gains
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array
from tests.support.controller_episodes import COMBINATIONS, make

COMPLIANCE, IMPEDANCE, ADMITTANCE = "PRP-Compliance-v0", "PRP-Impedance-v0", "PRP-Admittance-v0"
RENDERING = (COMPLIANCE, IMPEDANCE, ADMITTANCE)
AXES: dict[str, Array] = {
    "inertia": np.array([1.1, 1.2, 1.3, 1.4, 1.5, 1.6]),
    "damping": np.array([21.0, 22.0, 23.0, 24.0, 25.0, 26.0]),
    "stiffness": np.array([31.0, 32.0, 33.0, 34.0, 35.0, 36.0]),
}
TAKEN = {
    "compliance": ("stiffness",),
    "impedance": ("inertia", "damping", "stiffness"),
    "admittance": ("inertia", "damping", "stiffness"),
}
RATE = {"tuned": 500, "tuned_50hz": 50}
ASKING = [
    (controller, environment_id)
    for environment_id, controller in COMBINATIONS
    if controller in TAKEN and environment_id in RENDERING
]


def names_of(environment_id: str) -> tuple[str, ...]:
    """The target parameters of a task; a spring has neither inertia nor damping."""
    return ("stiffness",) if environment_id == COMPLIANCE else tuple(AXES)


def keywords_of(environment_id: str) -> dict[str, Any]:
    return {f"target_{name}": AXES[name].tolist() for name in names_of(environment_id)}


def numbers_of(controller: str, gains: str, environment_id: str) -> dict[str, Any]:
    """A gain set with the defaults of the settings that it does not name."""
    declared = fields(BASELINES[controller].settings_class)
    defaults = {entry.name: entry.default for entry in declared if entry.default is not MISSING}
    return {**defaults, **load_gains(controller, gains, environment_id)}


def settings_of(controller: str, environment_id: str, gains: str, rate: int = 500, **overrides: Any) -> Any:
    """Settings of a controller on a task whose target keywords are `AXES`."""
    with closing(make(environment_id, control_frequency=rate, **keywords_of(environment_id))) as env:
        return make_baseline(controller, env, gains, **overrides).settings


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_impedance_rendering_tasks_have_a_target_and_others_have_none(environment_id: str) -> None:
    with closing(make(environment_id)) as env:
        target_impedance = ControlInterface.of(TimeLimit(env, max_episode_steps=5)).target_impedance
        own = env.unwrapped.task.numbers.constants.get("target", {})
    assert tuple(target_impedance) == (names_of(environment_id) if environment_id in RENDERING else ())
    for name, value in target_impedance.items():
        np.testing.assert_array_equal(value, own[name])


@pytest.mark.parametrize("environment_id", RENDERING)
def test_target_keywords_set_the_target_impedance(environment_id: str) -> None:
    with closing(make(environment_id, **keywords_of(environment_id))) as env:
        target_impedance = ControlInterface.of(env).target_impedance
    assert tuple(target_impedance) == names_of(environment_id)
    for name, value in target_impedance.items():
        np.testing.assert_array_equal(value, AXES[name])


def test_controllers_that_render_a_target_declare_its_parameters() -> None:
    assert {name: spec.policy.rendered for name, spec in BASELINES.items() if spec.policy.rendered} == TAKEN
    for spec in BASELINES.values():
        assert set(spec.policy.rendered) <= set(spec.settings_class.vectors)
        assert set(spec.data.target_impedance_sets) <= set(spec.gain_sets)
    assert {name for name, spec in BASELINES.items() if spec.data.target_impedance_sets} == set(TAKEN)


RENDERED = [
    (controller, environment_id, gains)
    for controller, environment_id in ASKING
    for gains in BASELINES[controller].data.target_impedance_sets
]


@pytest.mark.parametrize(("controller", "environment_id", "gains"), RENDERED)
def test_tuned_controller_renders_the_target_impedance(
    controller: str, environment_id: str, gains: str
) -> None:
    settings = settings_of(controller, environment_id, gains, RATE[gains])
    numbers = numbers_of(controller, gains, environment_id)
    factors = numbers.get("target_factor", {})
    rendered = set(TAKEN[controller]) & set(names_of(environment_id))
    assert rendered
    assert set(factors) <= rendered
    for name in settings.vectors:
        if name in rendered:
            expected = AXES[name] * np.array(factors.get(name, 1.0))
        else:
            expected = np.broadcast_to(numbers[name], 6)
        np.testing.assert_array_equal(getattr(settings, name), expected, err_msg=name)


@pytest.mark.parametrize(("controller", "environment_id"), ASKING)
def test_other_gain_sets_keep_their_own_numbers(controller: str, environment_id: str) -> None:
    others = set(gain_sets(controller)) - set(BASELINES[controller].data.target_impedance_sets)
    assert "report" in others
    for gains in others:
        settings, numbers = (
            settings_of(controller, environment_id, gains),
            numbers_of(controller, gains, environment_id),
        )
        for name in settings.vectors:
            np.testing.assert_array_equal(getattr(settings, name), np.broadcast_to(numbers[name], 6))


@pytest.mark.parametrize(("controller", "environment_id", "gains"), RENDERED)
def test_overrides_take_precedence_over_the_target_impedance(
    controller: str, environment_id: str, gains: str
) -> None:
    for name in TAKEN[controller]:
        changed = settings_of(controller, environment_id, gains, RATE[gains], **{name: 7.0})
        plain = settings_of(controller, environment_id, gains, RATE[gains])
        for other in plain.vectors:
            expected = np.full(6, 7.0) if other == name else getattr(plain, other)
            np.testing.assert_array_equal(getattr(changed, other), expected)


@pytest.mark.parametrize("environment_id", RENDERING)
def test_controllers_that_render_no_target_do_not_depend_on_it(environment_id: str) -> None:
    with (
        closing(make(environment_id)) as env,
        closing(make(environment_id, **keywords_of(environment_id))) as other,
    ):
        for controller in set(list_baselines(env.unwrapped.observation_layout)) - set(TAKEN):
            first, second = make_baseline(controller, env).settings, make_baseline(controller, other).settings
            for name in first.vectors:
                np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


@pytest.mark.parametrize("controller", TAKEN)
def test_gain_set_keeps_its_own_numbers_on_tasks_without_a_target(controller: str) -> None:
    with closing(make("PRP-Force-v0")) as env:
        settings, numbers = (
            make_baseline(controller, env).settings,
            load_gains(controller, "tuned", "PRP-Force-v0"),
        )
    for name in settings.vectors:
        np.testing.assert_array_equal(getattr(settings, name), np.broadcast_to(numbers[name], 6))


@pytest.mark.parametrize(
    ("controller", "environment_id"),
    [("impedance", IMPEDANCE), ("admittance", ADMITTANCE), ("compliance", COMPLIANCE)],
)
def test_controller_that_renders_the_target_scores_better_than_one_that_does_not(
    controller: str, environment_id: str
) -> None:
    """A target of three times the stiffness: the controller that receives it follows its model's pose."""
    keywords: dict[str, Any] = {
        "target_stiffness": [150.0, 150.0, 150.0, 50.0, 50.0, 50.0],
        "surface_stiffness": 400.0,
    }
    env = gymnasium.make(environment_id, scenario="randomized", duration=3.0, **keywords)
    told = make_baseline(controller, env)
    own = load_gains(controller, "tuned", environment_id)["stiffness"]
    untold = make_baseline(controller, env, stiffness=own)
    scores = [float(prp_gym.evaluate(policy, env, episodes=3).score.value) for policy in (told, untold)]
    assert 1.0 - scores[0] < 0.5 * (1.0 - scores[1])
    env.close()


def home_of(controller: str) -> str:
    """An environment on which a controller can run."""
    return next(environment_id for environment_id, other in COMBINATIONS if other == controller)


LEAST = [
    (controller, gains, float(numbers["minimum_frequency"]))
    for controller in BASELINES
    for gains in gain_sets(controller)
    if "minimum_frequency" in (numbers := load_gains(controller, gains, home_of(controller)))
]
SLOWER = {1000.0: 500, 500.0: 250, 100.0: 50, 50.0: 25}


@pytest.mark.parametrize(("controller", "gains", "least"), LEAST)
def test_set_is_refused_below_its_rate_and_taken_at_it(controller: str, gains: str, least: float) -> None:
    with closing(make(home_of(controller), control_frequency=least)) as env:
        assert type(make_baseline(controller, env, gains)) is BASELINES[controller].policy
    with closing(make(home_of(controller), control_frequency=SLOWER[least])) as env:
        allowed = f"at least {least:g} with gains '{gains}' of controller '{controller}'"
        with pytest.raises(InvalidValueError, match=rf"control_frequency is .* Hz|{allowed}") as caught:
            make_baseline(controller, env, gains)
        assert allowed in caught.value.allowed
        assert caught.value.value == SLOWER[least]


@pytest.mark.parametrize(("controller", "gains", "least"), LEAST)
def test_complete_gains_of_the_user_may_have_any_control_frequency(
    controller: str, gains: str, least: float
) -> None:
    names = tuple(BASELINES[controller].settings_class.vectors)
    with closing(make(home_of(controller), control_frequency=SLOWER[least])) as env:
        made = make_baseline(controller, env, gains, **dict.fromkeys(names, 1.5))
        for name in names:
            np.testing.assert_array_equal(getattr(made.settings, name), 1.5)
        settings = fields(BASELINES[controller].settings_class)
        optional = {entry.name for entry in settings if entry.default is not MISSING}
        for absent in set(names) - optional:
            some = {name: 1.5 for name in names if name != absent}
            with pytest.raises(InvalidValueError, match="control_frequency is"):
                make_baseline(controller, env, gains, **some)


FIFTY = {
    "compliance": COMPLIANCE,
    "impedance": IMPEDANCE,
    "admittance": ADMITTANCE,
    "force_inner_position": "PRP-Force-v0",
    "parallel_force_position": "PRP-ForcePosition-v0",
}


@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
@pytest.mark.parametrize("controller", FIFTY)
def test_gains_for_fifty_hertz_neither_diverge_nor_chatter_in_contact(controller: str, scenario: str) -> None:
    with closing(
        make(FIFTY[controller], control_frequency=50, scenario=scenario, surface_stiffness=1000.0)
    ) as env:
        policy = make_baseline(controller, env, "tuned_50hz")
        median = prp_gym.evaluate(policy, env, episodes=4).median
    assert median["divergence"] == 0.0
    assert median["saturation"] < 5.0  # [%]: the bound of test_seams
