"""Refusals of vector environments: the message says what is allowed, and nothing is changed."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.errors import (
    EpisodeError,
    InvalidValueError,
    NonFiniteError,
    PRPError,
    ShapeError,
    UnknownNameError,
)
from tests.support.vector_episodes import MODES, SHORT, actions_for, assert_same, single, together

N = 3
FORCE, LINK = "PRP-Force-v0", "PRP-Adaptive-v0"


@pytest.mark.parametrize("value", [0, -1, 1.5, 2.0, True, "2", None, np.nan])
def test_number_of_environments_that_is_not_a_whole_number_above_zero_is_refused(value: object) -> None:
    with pytest.raises(
        InvalidValueError, match=r"num_envs is .*; allowed: a whole number, at least 1"
    ) as caught:
        together(FORCE, num_envs=value)  # type: ignore[arg-type]
    assert caught.value.value is value


@pytest.mark.parametrize("value", [-1, 0.5, False, "all"])
def test_number_of_threads_that_is_not_a_whole_number_is_refused(value: object) -> None:
    with pytest.raises(InvalidValueError, match=r"num_threads is .*; allowed: a whole number, at least 0"):
        together(FORCE, num_envs=2, num_threads=value)


@pytest.mark.parametrize("mode", ["nextstep", "", None, 1])
def test_autoreset_mode_that_does_not_exist_is_refused(mode: Any) -> None:
    with pytest.raises(UnknownNameError, match=r"unknown autoreset_mode .* Valid: Disabled, NextStep, Same"):
        together(FORCE, mode)


def test_window_of_many_environments_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="'human'; allowed: rgb_array, depth_array or None"):
        together(FORCE, render_mode="human")


@pytest.mark.parametrize(
    ("keywords", "error", "words"),
    [
        ({"durations": 1.0}, UnknownNameError, "'durations'. Did you mean 'duration'"),
        ({"scenario": "reports"}, UnknownNameError, "'reports'. Did you mean 'report'"),
        ({"duration": -1.0}, InvalidValueError, "duration is -1.0 s"),
        ({"surface_stiffness": -1.0}, InvalidValueError, "surface_stiffness is -1.0 N/m"),
    ],
)
def test_keywords_are_checked_as_those_of_a_single_environment(
    keywords: dict[str, Any], error: type[Exception], words: str
) -> None:
    for make in (together, single):
        with pytest.raises(error, match=words):
            make(FORCE, **keywords)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("actions", "error", "words"),
    [
        (np.zeros(3), ShapeError, r"actions has shape \(3,\); expected \(3, 3\)"),
        (np.zeros((2, 3)), ShapeError, r"actions has shape \(2, 3\)"),
        (np.zeros((3, 1)), ShapeError, r"actions has shape \(3, 1\)"),
        (np.zeros((1, 3, 3)), ShapeError, r"actions has shape \(1, 3, 3\)"),
        (0.5, ShapeError, r"actions has shape \(\)"),
        (np.full((3, 3), np.nan), NonFiniteError, "action of environments .*nan"),
        ([[0, 0, np.inf], [0, 0, 0], [0, 0, 0]], NonFiniteError, "action of environments .*inf"),
        ("left", InvalidValueError, "actions is 'left'; allowed: a number or numbers"),
        ([["0", "0", "0"]] * 3, InvalidValueError, "actions is .*; allowed: a number or numbers"),
        ([[0, 0, 0], [0, 0], [0]], InvalidValueError, "allowed: a number or numbers"),
        (np.zeros((3, 3), dtype=bool), InvalidValueError, "allowed: a number or numbers"),
        (np.zeros((3, 3), dtype=complex), InvalidValueError, "allowed: a number or numbers"),
        (None, InvalidValueError, "actions is None"),
    ],
)
def test_actions_that_are_refused_change_nothing(
    actions: Any, error: type[Exception], words: str, mode: str
) -> None:
    env, twin = (together(FORCE, mode, N, scenario="realistic", **SHORT) for _ in range(2))
    for each in (env, twin):
        each.reset(seed=0)
    values = actions_for(env, 8)[: 5 if mode == "Disabled" else 8]
    for count, action in enumerate(values):
        if count == 1:
            for each in (env, twin):
                each.reset(options={"reset_mask": np.array([True, False, False])})
        if count in (2, 6):  # in an episode; with environments that wait for their reset
            with pytest.raises(error, match=words):
                env.step(actions)
        assert_same(env.step(action), twin.step(action), f"step {count}")


def test_actions_for_the_link_have_one_component() -> None:
    env = together(LINK, num_envs=N)
    env.reset(seed=0)
    with pytest.raises(ShapeError, match=r"actions has shape \(3, 3\); expected \(3, 1\)"):
        env.step(np.zeros((3, 3)))


def test_actions_of_environments_that_are_reset_are_ignored() -> None:
    env, twin = (together(FORCE, "NextStep", N, **SHORT) for _ in range(2))
    mask = np.array([False, True, False])
    values = actions_for(env, 8)
    for each in (env, twin):
        each.reset(seed=0)
        each.step(values[0])
        each.reset(options={"reset_mask": mask})
        for action in values[1:6]:
            ended = each.step(action)[3]
        assert ended.tolist() == [True, False, True]
    odd = values[6].copy()
    odd[~mask] = np.nan
    assert_same(env.step(odd), twin.step(values[6]), "step")
    odd = values[7].copy()
    odd[mask] = np.inf
    assert_same(env.step(odd), twin.step(values[7]), "step")


@pytest.mark.parametrize("mode", MODES)
def test_step_before_the_first_reset_is_refused(mode: str) -> None:
    env = together(FORCE, mode, N)
    with pytest.raises(EpisodeError, match="never reset"):
        env.step(np.zeros((N, 3)))
    env.reset(seed=0)
    env.step(np.zeros((N, 3)))


@pytest.mark.parametrize("method", ["render", "get_state"])
def test_what_needs_an_episode_is_refused_before_the_first_reset(method: str) -> None:
    env = together(FORCE, num_envs=N, render_mode="rgb_array")
    with pytest.raises(EpisodeError, match=rf"{method}\(\) needs an episode: call reset\(\) first"):
        getattr(env, method)()


def test_frames_without_a_render_mode_are_refused() -> None:
    env = together(FORCE, num_envs=N)
    env.reset(seed=0)
    for draw in (env.render, env.envs[1].render):
        with pytest.raises(EpisodeError, match="needs a render_mode at make time"):
            draw()


def test_step_after_the_end_of_episodes_is_refused_without_autoreset() -> None:
    env = together(FORCE, "Disabled", N, **SHORT)
    env.reset(seed=0)
    for action in actions_for(env, 6):
        ended = env.step(action)[3]
    assert ended.all()
    with pytest.raises(EpisodeError, match=r"the episodes of environments \[0, 1, 2\] have ended"):
        env.step(np.zeros((N, 3)))
    env.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(EpisodeError, match=r"environments \[1\] have ended"):
        env.step(np.zeros((N, 3)))
    env.reset(options={"reset_mask": np.array([False, True, False])})
    assert not env.step(np.zeros((N, 3)))[3].any()


@pytest.mark.parametrize(
    ("mask", "error", "words"),
    [
        (np.zeros(3, dtype=bool), InvalidValueError, "at least one of them True"),
        (np.ones(3), InvalidValueError, "reset_mask is .*; allowed: truth values"),
        (np.array([0, 1, 1]), InvalidValueError, "reset_mask is .*; allowed: truth values"),
        ("yes", ShapeError, r"reset_mask has shape \(\); expected \(3,\)"),
        (np.ones(2, dtype=bool), ShapeError, r"reset_mask has shape \(2,\); expected \(3,\)"),
        (np.ones((3, 1), dtype=bool), ShapeError, r"reset_mask has shape \(3, 1\)"),
        (True, ShapeError, r"reset_mask has shape \(\)"),
        (None, ShapeError, r"reset_mask has shape \(\)"),
        ([[True], [True, False], []], InvalidValueError, "reset_mask is .*; allowed: truth values"),
    ],
)
def test_value_that_is_not_a_mask_is_refused_and_nothing_changes(
    mask: Any, error: type[Exception], words: str
) -> None:
    env, twin = (together(FORCE, "NextStep", N, **SHORT) for _ in range(2))
    for each in (env, twin):
        each.reset(seed=0)
    for action in actions_for(env, 8):
        with pytest.raises(error, match=words):
            env.reset(seed=3, options={"reset_mask": mask})
        assert_same(env.step(action), twin.step(action), "step")


def test_first_reset_that_leaves_some_out_is_refused_and_draws_nothing() -> None:
    env = together(FORCE, num_envs=N)
    with pytest.raises(InvalidValueError, match=r"reset_mask of the first reset is \[True, False, True\]"):
        env.reset(seed=0, options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(EpisodeError, match="never reset"):
        env.step(np.zeros((N, 3)))
    assert not set(env.np_random_seed) & {0, 1, 2}
    everyone, plain = env.reset(seed=0, options={"reset_mask": np.ones(N, dtype=np.bool_)}), env.reset(seed=0)
    assert_same(everyone, plain, "reset")


def test_every_refusal_is_one_of_the_package_and_survives_a_process() -> None:
    env = together(FORCE, num_envs=N)
    env.reset(seed=0)
    tries: list[Any] = [
        lambda: env.step(np.zeros(2)),
        lambda: env.reset(seed=-1),
        lambda: env.reset(options={"no": 1}),
        lambda: env.envs[0].step(np.zeros(3)),
        lambda: env.envs[0].reset(seed=1),
        lambda: env.set_attr("label", [1, 2]),
        lambda: together(FORCE, num_envs=0),
    ]
    for attempt in tries:
        with pytest.raises(PRPError) as caught:
            attempt()
        again = pickle.loads(pickle.dumps(caught.value))
        assert (type(again), str(again)) == (type(caught.value), str(caught.value))
        assert vars(copy.deepcopy(caught.value)).keys() == vars(caught.value).keys()


def test_wrappers_of_single_environments_are_refused_by_gymnasium() -> None:
    with pytest.raises(gymnasium.error.Error, match="wrappers argument"):
        gymnasium.make_vec(FORCE, N, wrappers=[gymnasium.wrappers.FlattenObservation])
