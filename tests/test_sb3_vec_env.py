"""The adapter for Stable-Baselines3 is its DummyVecEnv of single environments, bit for bit."""

import copy
import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import (
    DummyVecEnv,
    VecCheckNan,
    VecEnv,
    VecFrameStack,
    VecMonitor,
    VecNormalize,
)

import prp_gym
from prp_gym.agents.vec_env import SB3VecEnv
from prp_gym.envs import PRPVectorEnv
from prp_gym.errors import (
    EpisodeError,
    InvalidValueError,
    JointLimitError,
    NonFiniteError,
    PRPError,
    RenderingError,
    ShapeError,
    UnknownNameError,
)
from prp_gym.physics import Physics
from prp_gym.physics.rendering import OffscreenRenderer
from prp_gym.robot.arrays import Array

N = 4
IDS = prp_gym.list_envs()
ID = "PRP-JointRegulation-v0"
SHORT: dict[str, Any] = {"duration": 0.06, "control_frequency": 100}  # [s], [Hz]: episodes of six steps


@pytest.fixture(scope="module")
def drawing() -> None:
    """Skip where no picture can be drawn, unless that must not be."""
    try:
        OffscreenRenderer(Physics().model(), 64, 64, "top").close()
    except RenderingError as error:
        if os.environ.get("PRP_REQUIRE_RENDERING") == "1":
            pytest.fail(f"PRP_REQUIRE_RENDERING=1, but: {error}")
        pytest.skip(f"no drawing context on this machine: {error}")


def together(environment_id: str = ID, **keywords: Any) -> SB3VecEnv:
    vector = gymnasium.make_vec(environment_id, N, autoreset_mode="SameStep", **{**SHORT, **keywords})
    assert isinstance(vector, PRPVectorEnv)
    return SB3VecEnv(vector)


def one_by_one(environment_id: str = ID, **keywords: Any) -> DummyVecEnv:
    return DummyVecEnv([partial(gymnasium.make, environment_id, **{**SHORT, **keywords})] * N)


def both(environment_id: str = ID, **keywords: Any) -> tuple[SB3VecEnv, DummyVecEnv]:
    return together(environment_id, **keywords), one_by_one(environment_id, **keywords)


def actions_for(env: VecEnv, count: int, wild: Sequence[float] = (1.2,) * N) -> list[Array]:
    """Random actions, some beyond the limits; how large, for each environment."""
    rng = np.random.default_rng(11)
    size = (N, *(env.action_space.shape or ()))
    return [(np.array(wild)[:, None] * rng.uniform(-1, 1, size)).astype(np.float32) for _ in range(count)]


def assert_same(found: Any, expected: Any, where: str) -> None:
    """Equal to the last bit, with the same types, in arrays, lists and dictionaries in their order."""
    assert type(found) is type(expected), where
    if isinstance(expected, dict):
        assert list(found) == list(expected), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}[{key!r}]")
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected), where
        for index, item in enumerate(expected):
            assert_same(found[index], item, f"{where}[{index}]")
    elif isinstance(expected, np.ndarray):
        assert (found.dtype, found.shape) == (expected.dtype, expected.shape), where
        np.testing.assert_array_equal(found, expected, err_msg=where)
    else:
        assert found == expected, where


def assert_same_episodes(ours: VecEnv, theirs: VecEnv, actions: Sequence[Array]) -> list[Any]:
    """Play both; what they returned."""
    steps = []
    ours.seed(7)
    theirs.seed(7)
    assert_same(ours.reset(), theirs.reset(), "reset")
    for count, action in enumerate(actions):
        steps.append(ours.step(action))
        assert_same(steps[-1], theirs.step(action), f"step {count}")
        assert_same(ours.reset_infos, theirs.reset_infos, f"reset infos {count}")
    return steps


@pytest.mark.parametrize("scenario", ["report", "randomized", "realistic"])
@pytest.mark.parametrize("environment_id", IDS)
def test_steps_and_episode_ends_are_those_of_single_environments(environment_id: str, scenario: str) -> None:
    ours, theirs = both(environment_id, scenario=scenario)
    steps = assert_same_episodes(ours, theirs, actions_for(ours, 20, (0.01,) * N))
    dones = np.array([done for _, _, done, _ in steps])
    np.testing.assert_array_equal(np.flatnonzero(dones.all(axis=1)), [5, 11, 17])
    assert all(info["TimeLimit.truncated"] for info in steps[5][3])


@pytest.mark.parametrize("environment_id", [name for name in IDS if name != "PRP-Adaptive-v0"])
def test_diverged_environments_begin_anew_alone(environment_id: str) -> None:
    ours, theirs = both(environment_id, scenario="report")
    steps = assert_same_episodes(ours, theirs, actions_for(ours, 20, (1.0, 1e-6, 0.2, 1.0)))
    dones = np.array([done for _, _, done, _ in steps])
    assert (dones.any(axis=1) & ~dones.all(axis=1)).any()
    ended = [info for _, _, done, infos in steps for info in np.array(infos)[done]]
    assert {info["TimeLimit.truncated"] for info in ended} == {True, False}
    assert all("terminal_observation" in info for info in ended)


def test_link_that_diverges_begins_anew_alone() -> None:
    ours, theirs = both("PRP-Adaptive-v0", scenario="report", duration=1.0)
    actions = [np.array([[1.0], [0.0], [-1.0], [0.0]], dtype=np.float32)] * 60
    dones = np.array([done for _, _, done, _ in assert_same_episodes(ours, theirs, actions)])
    assert (dones.any(axis=1) & ~dones.all(axis=1)).any()


def test_nothing_returned_changes_later() -> None:
    env = together()
    env.seed(7)
    returned: list[Any] = [env.reset()]
    copies = copy.deepcopy(returned)
    for action in actions_for(env, 7):
        env.step_async(action)
        returned.append(env.step_wait())
        copies.append(copy.deepcopy(returned[-1]))
    assert_same(returned, copies, "after seven steps")
    observation, _, done, infos = returned[6]
    assert done.all()
    for info in infos:
        info["terminal_observation"] += 1.0
    np.testing.assert_array_equal(observation, copies[6][0])


@pytest.mark.parametrize(
    "wrapped",
    [VecNormalize, VecCheckNan, VecMonitor, partial(VecFrameStack, n_stack=3)],
    ids=["VecNormalize", "VecCheckNan", "VecMonitor", "VecFrameStack"],
)
def test_wrappers_of_stable_baselines_do_the_same(
    wrapped: Callable[[VecEnv], VecEnv], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("time.time", lambda: 0.0)  # VecMonitor's "t"
    ours, theirs = both()
    assert_same_episodes(wrapped(ours), wrapped(theirs), actions_for(ours, 20))


def test_episode_statistics_are_those_of_single_monitors() -> None:
    ours = prp_gym.make_sb3_vec_env(ID, N, **SHORT)
    theirs = DummyVecEnv([lambda: Monitor(gymnasium.make(ID, **SHORT))] * N)
    statistics: list[list[Any]] = []
    for env in (ours, theirs):
        env.seed(3)
        env.reset()
        infos = [env.step(action)[3] for action in actions_for(env, 13)]
        statistics.append([item["episode"] for step in infos for item in step if "episode" in item])
    assert len(statistics[0]) == 2 * N
    assert [found["l"] for found in statistics[0]] == [expected["l"] for expected in statistics[1]]
    returns = [[float(episode["r"]) for episode in episodes] for episodes in statistics]
    # six rewards of at most 0.01 s in float32, and Monitor rounds to 1e-6
    np.testing.assert_allclose(returns[0], returns[1], rtol=0, atol=6e-7)


def test_seeds_and_options_are_used_once() -> None:
    pair = both()
    for env in pair:
        assert env.seed(5) == [5, 6, 7, 8]
        env.set_options({"goal": np.array([0.4, -0.1, 0.2])})
    first, plain = ([env.reset() for env in pair] for _ in range(2))
    assert_same(*first, "seeded, with a goal")
    assert_same(*plain, "neither")
    assert not np.array_equal(first[0], plain[0])
    assert_same(*(env.reset_infos for env in pair), "reset infos")
    pair[0].seed(5)
    pair[0].set_options({"goal": np.array([0.4, -0.1, 0.2])})
    assert_same(pair[0].reset(), first[0], "the same seed again")


@pytest.mark.parametrize("seeds", [(5,), (5, 6), (5, None)])
def test_environments_may_have_different_options(seeds: Sequence[int | None]) -> None:
    pair = both(scenario="realistic")
    start, goal = np.array([0.3, -0.2, 0.1]), np.array([0.4, -0.1, 0.2])
    for env in pair:
        for seed in seeds[:-1]:
            env.seed(seed)
            env.reset()
        if seeds[-1] is not None:
            env.seed(seeds[-1])
        env.set_options([{"goal": goal}, {}, {"joint_position": start, "goal": goal}, {"goal": start}])
    assert_same(*(env.reset() for env in pair), "reset")
    for count, action in enumerate(actions_for(pair[0], 13)):
        assert_same(*(env.step(action) for env in pair), f"step {count}")


def test_environments_without_seeds_may_have_different_options() -> None:
    env = together()
    goal = np.array([0.4, -0.1, 0.2])
    env.set_options([{"goal": goal}, {}, {}, {}])
    desired = env.together.observation_layout.split(env.reset())["desired_joint_position"]
    np.testing.assert_array_equal((desired == goal).all(axis=1), [True, False, False, False])


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ([{}] * (N - 1), ShapeError),
        ([{}, {"goals": np.zeros(3)}, {}, {}], UnknownNameError),
        ({"reset_mask": np.ones(N, dtype=np.bool_)}, UnknownNameError),
        ({"goal": np.zeros((N, 3))}, ShapeError),
        ({"goal": [0.0, np.nan, 0.0]}, NonFiniteError),
        ([{}, {}, {"goal": [0.0, 0.5, 0.0]}, {}], JointLimitError),
    ],
)
def test_options_that_a_task_does_not_take_are_refused(options: Any, error: type[PRPError]) -> None:
    env = together()
    env.reset()
    env.set_options(options)
    with pytest.raises(error):
        env.reset()


def test_actions_of_another_shape_or_before_an_episode_are_refused() -> None:
    env = together()
    with pytest.raises(EpisodeError):
        env.step(np.zeros((N, 3)))
    env.reset()
    with pytest.raises(ShapeError):
        env.step(np.zeros((N, 2)))
    with pytest.raises(NonFiniteError):
        env.step(np.full((N, 3), np.nan))


@pytest.mark.parametrize("indices", [None, 2, -1, [0, 3], (1,), range(1, 3), np.array([3, 1])])
def test_attributes_are_those_of_the_environments_asked_for(indices: Any) -> None:
    pair = both("PRP-Force-v0")
    for env in pair:
        env.seed(4)
        env.reset()
        env.step(actions_for(env, 1)[0])
    for name in ("truth", "commanded_torque", "applied_torque", "torque_limit", "duration", "render_mode"):
        assert_same(*(env.get_attr(name, indices) for env in pair), name)
    assert_same(*(env.env_is_wrapped(Monitor, indices) for env in pair), "wrapped")
    for env in pair:
        env.set_attr("label", "mine", indices)
    holders = [[hasattr(view, "label") for view in env.envs] for env in (pair[0].together, pair[1])]
    assert holders[0] == holders[1]
    assert pair[0].get_attr("label", indices) == pair[1].get_attr("label", indices)
    draws = [env.env_method("get_wrapper_attr", "np_random", indices=indices) for env in pair]
    assert [own.random() for own in draws[0]] == [own.random() for own in draws[1]]
    assert [env.has_attr("label") for env in pair] == [indices is None] * 2
    with pytest.raises(AttributeError):
        pair[0].env_method("no_such_method", indices=indices)


@pytest.mark.parametrize("method", ["step", "reset"])
def test_one_among_many_is_neither_stepped_nor_reset_alone(method: str) -> None:
    env = together()
    with pytest.raises(EpisodeError, match="one of many"):
        env.env_method(method, *([np.zeros(3)] if method == "step" else []), indices=1)


@pytest.mark.parametrize("mode", ["NextStep", "Disabled"])
def test_other_autoreset_modes_are_refused(mode: str) -> None:
    vector = gymnasium.make_vec(ID, N, autoreset_mode=mode)
    assert isinstance(vector, PRPVectorEnv)
    with pytest.raises(InvalidValueError, match="SameStep"):
        SB3VecEnv(vector)


def test_metadata_and_modes_are_those_of_the_environments() -> None:
    env = together(render_mode="rgb_array", control_frequency=100)
    assert env.metadata == {"render_modes": ["rgb_array", "depth_array"], "render_fps": 100}
    assert env.render_mode == "rgb_array"
    assert env.spec is not None
    assert env.spec.id == ID
    assert env.unwrapped is env
    env.close()
    env.close()


def test_pictures_are_those_of_single_environments_side_by_side(drawing: None) -> None:
    pair = both(render_mode="rgb_array", width=32, height=24)
    for env in pair:
        env.seed(2)
        env.reset()
    assert_same(list(pair[0].get_images()), list(pair[1].get_images()), "images")
    tiled = [env.render() for env in pair]
    assert_same(tiled[0], tiled[1], "side by side")
    assert tiled[0] is not None
    assert tiled[0].shape == (48, 64, 3)
    assert_same(*(env.env_method("render", indices=[3, 0]) for env in pair), "two of them")
    for env in pair:
        env.close()


def test_without_a_render_mode_there_are_no_pictures() -> None:
    env = together()
    with pytest.warns(UserWarning, match="render_mode='rgb_array'; it is None"):
        assert list(env.get_images()) == [None] * N
    with pytest.warns(UserWarning, match="no `render_mode`"):
        assert env.render() is None
