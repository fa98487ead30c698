"""Environments among many one by one, as Gymnasium's vectors have them: views, attributes, frames."""

import copy
from typing import Any

import numpy as np
import pytest

import prp_gym  # noqa: F401  # before MuJoCo: it chooses how MuJoCo draws
from prp_gym.envs import PRPVectorEnv
from prp_gym.errors import EpisodeError, ShapeError
from prp_gym.physics.rendering import Arrow
from tests.support.vector_episodes import IDS, SHORT, actions_for, assert_same, one_by_one, single, together

N = 3
FORCE = "PRP-Force-v0"
FRAME: dict[str, Any] = {"width": 64, "height": 48}


def stepped(env: Any, count: int = 3) -> Any:
    """An environment or some after some steps with the same actions."""
    env.reset(seed=4)
    for action in actions_for(env, count):
        env.step(action)
    return env


@pytest.mark.parametrize("environment_id", IDS)
def test_views_show_what_single_environments_show(environment_id: str) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", **SHORT}
    ours = stepped(together(environment_id, num_envs=N, **keywords))
    theirs = stepped(one_by_one(environment_id, num_envs=N, **keywords))
    assert len(ours.envs) == N
    for view, wrapped in zip(ours.envs, theirs.envs, strict=True):
        own = wrapped.unwrapped
        assert view.unwrapped is view
        for name in ("ground_truth", "commanded_torque", "applied_torque", "torque_limit"):
            np.testing.assert_array_equal(getattr(view, name), getattr(own, name))
        for name in ("control_frequency", "duration", "config", "options", "render_mode", "arm"):
            assert getattr(view, name) == getattr(own, name), name
        assert view.observation_space == own.observation_space
        assert view.action_space == own.action_space
        assert view.info_fields == own.info_fields
        assert view.observation_layout.names == own.observation_layout.names
        assert type(view.task) is type(own.task)
        assert view.np_random_seed == own.np_random_seed
        assert view.np_random.bit_generator.state == own.np_random.bit_generator.state
    for name in ("ground_truth", "np_random_seed", "duration", "commanded_torque"):
        assert_same(ours.get_attr(name), theirs.get_attr(name), name)
        assert_same(ours.call(name), theirs.call(name), name)


def test_views_and_properties_are_copies() -> None:
    env, twin = (stepped(together(FORCE, num_envs=N)) for _ in range(2))
    for where in (env, *env.envs):
        for name in ("ground_truth", "commanded_torque", "applied_torque", "torque_limit"):
            getattr(where, name)[:] = 77.0
            np.testing.assert_array_equal(getattr(env, name), getattr(twin, name))
    for action in actions_for(env, 3):
        assert_same(env.step(action), twin.step(action), "step")
        np.testing.assert_array_equal(env.ground_truth, twin.ground_truth)


@pytest.mark.parametrize("environment_id", IDS)
def test_what_is_returned_is_the_callers_own(environment_id: str) -> None:
    used, kept = (together(environment_id, "SameStep", N, **SHORT) for _ in range(2))
    starts = [env.reset(seed=0) for env in (used, kept)]
    starts[0][0][:] = 1.0
    steps = []
    for count, action in enumerate(actions_for(kept, 7)):
        found = used.step(action)
        steps.append((kept.step(action), copy.deepcopy(found)))
        assert_same(*steps[-1], f"step {count}")
        for array in (*found[:4], *(value for value in found[4].values() if isinstance(value, np.ndarray))):
            array[:] = 1
        np.testing.assert_array_equal(used.ground_truth, kept.ground_truth)
    for returned, then in steps:  # later steps have changed nothing
        assert_same(returned, then, "afterwards")


def test_attributes_of_ones_own_are_set_as_gymnasiums_vectors_do() -> None:
    ours, theirs = together(FORCE, num_envs=N), one_by_one(FORCE, num_envs=N)
    for env in (ours, theirs):
        env.set_attr("level", 3)
        assert env.get_attr("level") == (3, 3, 3)
        env.set_attr("level", [1, 2, 3])
        assert env.get_attr("level") == (1, 2, 3)
        env.set_attr("level", (4, 5, 6))
        assert env.call("level") == (4, 5, 6)
        with pytest.raises(ValueError, match="2"):
            env.set_attr("level", [1, 2])
        assert env.envs[1].has_wrapper_attr("level")
        assert not env.envs[1].has_wrapper_attr("levels")
        assert env.envs[1].set_wrapper_attr("level", 9, force=False) is True
        assert env.envs[1].set_wrapper_attr("levels", 9, force=False) is False
        assert env.get_attr("level") == (4, 9, 6)
    with pytest.raises(ShapeError, match=r"values of 'level' has shape \(2,\); expected one, or \(3,\)"):
        ours.set_attr("level", [1, 2])


def test_methods_are_called_with_their_arguments() -> None:
    env = together(FORCE, num_envs=N)
    env.set_attr("double", lambda value, plus=0: 2 * value + plus)
    assert env.call("double", 4, plus=1) == (9, 9, 9)
    assert env.call("has_wrapper_attr", "double") == (True, True, True)


def test_names_that_do_not_exist_are_attribute_errors() -> None:
    env = together(FORCE, num_envs=N)
    for call in (env.get_attr, env.call):
        with pytest.raises(AttributeError, match="'EnvironmentView' object has no attribute 'levels'"):
            call("levels")


@pytest.mark.parametrize("name", ["duration", "config", "task", "render_mode", "ground_truth", "np_random"])
def test_what_the_environments_share_or_show_cannot_be_set_for_one(name: str) -> None:
    env = together(FORCE, num_envs=N)
    before = env.get_attr("duration")
    with pytest.raises(AttributeError):
        env.set_attr(name, 1.0)
    assert env.get_attr("duration") == before


def test_one_among_many_is_neither_stepped_nor_reset_nor_closed() -> None:
    env, twin = (stepped(together(FORCE, num_envs=N)) for _ in range(2))
    with pytest.raises(EpisodeError, match="reset by itself"):
        env.envs[0].reset(seed=3)
    with pytest.raises(EpisodeError, match="stepped by itself"):
        env.envs[0].step(np.zeros(3))
    env.envs[0].close()
    for action in actions_for(env, 2):
        assert_same(env.step(action), twin.step(action), "step")


def arrows(env: PRPVectorEnv) -> list[int]:
    """Environments that are drawn with a force."""
    return [index for index in range(N) if any(type(item) is Arrow for item in env.overlay(index))]


@pytest.mark.parametrize(
    ("environment_id", "mode", "kind"),
    [
        ("PRP-Adaptive-v0", "rgb_array", np.uint8),
        ("PRP-PoseTracking-v0", "rgb_array", np.uint8),
        (FORCE, "depth_array", np.float32),
    ],
)
def test_frames_are_those_of_single_environments(
    open_contexts: None, environment_id: str, mode: str, kind: type
) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "render_mode": mode, **FRAME}
    ours = stepped(together(environment_id, num_envs=N, **keywords))
    theirs = stepped(one_by_one(environment_id, num_envs=N, **keywords))
    frames, expected = ours.render(), theirs.render()
    assert type(frames) is tuple
    assert_same(frames, expected, "frames")
    assert frames[0].dtype == kind
    assert frames[0].shape == (48, 64, 3)[: frames[0].ndim]
    assert (frames[0] != frames[1]).any()
    for index, view in enumerate(ours.envs):
        np.testing.assert_array_equal(view.render(), expected[index])
    assert_same(ours.call("render"), expected, "call")
    ours.close()
    theirs.close()


def test_frames_show_every_environments_own_surface_and_force(open_contexts: None) -> None:
    keywords: dict[str, Any] = {"render_mode": "rgb_array", **FRAME}
    env = together(FORCE, "Disabled", N, **keywords)
    options = {
        "surface_normal": np.array([[0.0, -1.0, 0.0], [0.0, -1.0, 0.0], [0.6, -0.8, 0.0]]),
        "surface_offset": np.array([0.30, 0.50, 0.50]),
        "surface_stiffness": np.full(N, 100.0),
        "joint_position": np.array([0.0, -0.14, 0.0]),
    }
    env.reset(seed=1, options=options)
    assert arrows(env) == [1]  # the tip is at y = -0.4 m, 0.1 m inside the second surface
    frames = env.render()
    for index in range(N):
        own = single(FORCE, **keywords)
        given = options | {
            name: options[name][index] for name in ("surface_normal", "surface_offset", "surface_stiffness")
        }
        own.reset(seed=1 + index, options=given)
        np.testing.assert_array_equal(frames[index], own.render())
        own.close()
    assert (frames[1] != frames[2]).any()
    env.close()


def test_frames_leave_the_environments_as_they_are(open_contexts: None) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "render_mode": "rgb_array", **SHORT, **FRAME}
    drawn, blind = (together(FORCE, "NextStep", N, **keywords) for _ in range(2))
    for env in (drawn, blind):
        env.reset(seed=0)
    for action in actions_for(drawn, 9):
        drawn.render()
        assert_same(drawn.step(action), blind.step(action), "step")
    drawn.close()


def test_closing_frees_the_drawing_context(open_contexts: None) -> None:
    env = stepped(together(FORCE, num_envs=N, render_mode="rgb_array", **FRAME))
    frames = env.render()
    assert env._renderer is not None
    env.close()
    assert env._renderer is None
    assert env.closed
    env.close()
    again = stepped(together(FORCE, num_envs=N, render_mode="rgb_array", **FRAME))
    assert_same(again.render(), frames, "frames")
    again.close()
