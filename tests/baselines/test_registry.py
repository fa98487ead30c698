"""Controllers by name, and the policies that are made of them for an environment."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import ClipAction, TimeLimit

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, Baseline, list_baselines, make_baseline
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.baselines.base.references import REFERENCE_FIELDS
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.robot import Link, LinkParameters, RobotParameters
from prp_gym.tasks.fields import MEASURED_FIELDS, ObservationLayout
from tests.support.controller_episodes import ONE_EACH, environment

Env = gymnasium.Env[Any, Any]
each = pytest.mark.parametrize(("environment_id", "controller"), ONE_EACH, ids=map("-".join, ONE_EACH))


def setting_names(controller: str) -> list[str]:
    return [field.name for field in fields(BASELINES[controller].settings_class)]


@pytest.fixture(params=list_envs())
def env(request: pytest.FixtureRequest) -> Iterator[Env]:
    made = gymnasium.make(request.param)
    yield made
    made.close()


def test_controllers_are_listed_under_their_own_names() -> None:
    assert list_baselines() == list(BASELINES)
    for name, spec in BASELINES.items():
        assert spec.name == name
        assert issubclass(spec.policy, Baseline)


def test_list_is_the_caller_s_own() -> None:
    list_baselines().clear()
    assert list_baselines() == list(BASELINES)


def test_every_controller_has_a_one_line_summary() -> None:
    summaries = [controller.summary for controller in BASELINES.values()]
    assert len(set(summaries)) == len(summaries)
    assert all(summary and "\n" not in summary for summary in summaries)


def test_every_listed_controller_runs(env: Env) -> None:
    observation, _ = env.reset(seed=2)
    names = list_baselines(env.get_wrapper_attr("observation_layout"))
    assert [type(make_baseline(name, env)) for name in names] == [BASELINES[name].policy for name in names]
    for name in names:
        _, reward, *_ = env.step(make_baseline(name, env).predict(observation)[0])
        assert float(reward) > 0.0


def test_controller_is_listed_only_where_all_its_fields_are_observed(env: Env) -> None:
    layout: ObservationLayout = env.get_wrapper_attr("observation_layout")
    for absent in layout.names:
        reduced = ObservationLayout([field for field in layout.fields if field.name != absent])
        needed = {absent} & {name for fields in REFERENCE_FIELDS for name in fields}
        readers = [
            name
            for name in list_baselines(layout)
            if needed or absent in BASELINES[name].policy.measured_fields
        ]
        assert list_baselines(reduced) == [name for name in list_baselines(layout) if name not in readers]


def test_no_controller_runs_without_a_reference() -> None:
    assert list_baselines(ObservationLayout(MEASURED_FIELDS)) == []


@pytest.mark.parametrize("controller", BASELINES)
def test_every_required_field_is_one_that_an_environment_observes(controller: str) -> None:
    known: set[str] = set()
    for environment_id in list_envs():
        known |= set(environment(environment_id).get_wrapper_attr("observation_layout").names)
    assert set(BASELINES[controller].policy.measured_fields) <= known


def test_policy_is_the_same_through_wrappers(env: Env) -> None:
    wrapped = ClipAction(TimeLimit(env, max_episode_steps=10))
    observation, _ = wrapped.reset(seed=3)
    for controller in list_baselines(env.get_wrapper_attr("observation_layout")):
        action, _ = make_baseline(controller, wrapped).predict(observation)
        np.testing.assert_array_equal(action, make_baseline(controller, env).predict(observation)[0])


def test_gains_are_the_tuned_ones_unless_named(env: Env) -> None:
    observation, _ = env.reset(seed=4)
    for controller in list_baselines(env.get_wrapper_attr("observation_layout")):
        default, tuned = make_baseline(controller, env), make_baseline(controller, env, gains="tuned")
        np.testing.assert_array_equal(default.predict(observation)[0], tuned.predict(observation)[0])


def test_override_replaces_one_setting_and_leaves_the_others(env: Env) -> None:
    for controller in list_baselines(env.get_wrapper_attr("observation_layout")):
        plain = make_baseline(controller, env).settings
        linked = isinstance(make_baseline(controller, env).model, Link)
        heavy = RobotParameters().with_masses((0.9, 0.5, 0.7))
        model = LinkParameters(inertia=0.4) if linked else heavy
        changed = make_baseline(controller, env, model=model).settings
        assert changed.model == model != plain.model
        for name in set(setting_names(controller)) - {"model"}:
            assert np.array_equal(getattr(changed, name), getattr(plain, name))


@each
def test_misspelt_controller_gets_the_nearest_name_and_all_valid_ones(
    environment_id: str, controller: str
) -> None:
    with pytest.raises(UnknownNameError, match=f"Did you mean '{controller}'") as caught:
        make_baseline(controller[:-1], environment(environment_id))
    assert caught.value.kind == "baseline"
    assert caught.value.valid == tuple(sorted(BASELINES))


@each
def test_misspelt_gain_set_or_setting_gets_the_nearest_name(environment_id: str, controller: str) -> None:
    env = environment(environment_id)
    with pytest.raises(UnknownNameError, match="Did you mean 'tuned'") as caught:
        make_baseline(controller, env, gains="tunde")
    assert caught.value.valid == tuple(sorted(gain_sets(controller)))
    name = next(iter(BASELINES[controller].settings_class.vectors))
    with pytest.raises(UnknownNameError, match=f"Did you mean '{name}'") as caught:
        make_baseline(controller, env, "tuned", **{f"{name}s": 1.0})
    assert caught.value.kind == f"setting of controller {controller!r}"


@each
def test_source_of_a_gain_set_is_no_setting(environment_id: str, controller: str) -> None:
    with pytest.raises(UnknownNameError, match=r"unknown setting of controller .* 'source'"):
        make_baseline(controller, environment(environment_id), source="mine")


@each
@pytest.mark.parametrize("value", [-1.0, float("nan"), [[1.0]]])
def test_setting_that_is_not_allowed_is_refused(environment_id: str, controller: str, value: object) -> None:
    name = next(iter(BASELINES[controller].settings_class.vectors))
    with pytest.raises(InvalidValueError, match=f"{name} is"):
        make_baseline(controller, environment(environment_id), "tuned", **{name: value})


@pytest.mark.parametrize("controller", BASELINES)
def test_environment_of_another_suite_is_refused(controller: str) -> None:
    foreign = gymnasium.make("CartPole-v1")
    with pytest.raises(InvalidValueError, match="an environment of prp_gym, wrapped or not"):
        make_baseline(controller, foreign)
    foreign.close()
