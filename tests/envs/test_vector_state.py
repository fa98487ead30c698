"""Saved, pickled and copied environments go on to the bit, and what cannot be gone back to is refused."""

import copy
import ctypes
import gc
import pickle
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.envs import PRPVectorEnv
from prp_gym.errors import InvalidValueError
from tests.support.vector_episodes import IDS, MODES, SHORT, actions_for, assert_same, single, together

N = 4
FORCE = "PRP-Force-v0"
Copier = Callable[[PRPVectorEnv], PRPVectorEnv]


def by_pickle(env: PRPVectorEnv) -> PRPVectorEnv:
    clone = pickle.loads(pickle.dumps(env))
    assert isinstance(clone, PRPVectorEnv)
    return clone


def by_state(env: PRPVectorEnv) -> PRPVectorEnv:
    """Another one made with the same keywords, after some steps of its own, put where this one is."""
    keywords = dict(env.spec.kwargs if env.spec else {})
    mode = str(keywords.pop("autoreset_mode"))
    keywords.pop("vectorization_mode")
    other = together(env.task.environment_id, mode, **keywords)
    other.reset(seed=99)
    other.step(actions_for(env, 1)[0])
    expected = copy.deepcopy(env).set_state(env.get_state())
    np.testing.assert_array_equal(other.set_state(pickle.loads(pickle.dumps(env.get_state()))), expected)
    return other


COPIERS: tuple[Copier, ...] = (copy.deepcopy, by_pickle, by_state)


def midway(environment_id: str, mode: str, num_envs: int = N) -> tuple[PRPVectorEnv, list[Any]]:
    """Environments in the middle of episodes of which some have just ended, and actions to go on with."""
    env = together(environment_id, mode, num_envs, scenario="realistic", **SHORT)
    env.reset(seed=5)
    values = actions_for(env, 20)
    mask = np.arange(num_envs) % 2 == 0
    for count, action in enumerate(values[:6]):
        if count == 2:
            env.reset(options={"reset_mask": mask})
        ended = env.step(action)[3]
    np.testing.assert_array_equal(ended, ~mask)
    if mode == "Disabled":
        env.reset(options={"reset_mask": ~mask})
    return env, values[6 : 8 if mode == "Disabled" else 20]


def assert_going_on(env: PRPVectorEnv, clone: PRPVectorEnv, values: list[Any]) -> None:
    for count, action in enumerate(values):
        assert_same(clone.step(action), env.step(action), f"step {count}")
        np.testing.assert_array_equal(clone.ground_truth, env.ground_truth)
    assert_same(clone.reset(), env.reset(), "reset")
    assert_same(clone.step(values[0]), env.step(values[0]), "step")


@pytest.mark.parametrize("copied", COPIERS)
@pytest.mark.parametrize(
    ("environment_id", "mode"), [*((name, "NextStep") for name in IDS), *((FORCE, mode) for mode in MODES)]
)
def test_copies_go_on_to_the_bit(environment_id: str, mode: str, copied: Copier) -> None:
    env, values = midway(environment_id, mode)
    assert_going_on(env, copied(env), values)


@pytest.mark.parametrize("copied", COPIERS)
def test_copies_of_more_than_the_physics_keeps_in_memory_go_on_to_the_bit(copied: Copier) -> None:
    env, values = midway("PRP-Impedance-v0", "NextStep", 130)
    assert_going_on(env, copied(env), values[:3])


def test_copies_are_independent() -> None:
    env, values = midway(FORCE, "NextStep")
    twin, clone = midway(FORCE, "NextStep")[0], copy.deepcopy(env)
    for action in values[:5]:
        clone.step(-action)
    clone.reset(seed=1)
    for action in values:
        assert_same(env.step(action), twin.step(action), "step")


def test_state_can_be_gone_back_to_again_and_again_and_is_left_as_it_was() -> None:
    env, values = midway(FORCE, "NextStep")
    state = env.get_state()
    runs = []
    for _ in range(3):
        observation = env.set_state(state)
        runs.append((observation, [env.step(action) for action in values]))
    assert_same(runs[1], runs[0], "second")
    assert_same(runs[2], runs[0], "third")


def test_environments_that_wait_still_do_after_going_back() -> None:
    env, values = midway(FORCE, "NextStep")
    state, expected = env.get_state(), env.step(values[0])
    np.testing.assert_array_equal(expected[4]["time"] == 0.0, [False, True, False, True])
    env.reset(seed=0)
    env.set_state(state)
    assert_same(env.step(values[0]), expected, "step")


def test_diverged_environments_are_copied() -> None:
    env = together(FORCE, "NextStep", N, torque_limit=None)
    env.reset(seed=0)
    action = np.full((N, 3), 1e-6)
    action[1] = 1.0
    assert env.step(action)[2].tolist() == [False, True, False, False]
    for clone in [copied(env) for copied in COPIERS]:
        assert_going_on(copy.deepcopy(env), clone, [np.full((N, 3), 1e-6)] * 3)


def test_state_of_single_environments_or_of_nothing_is_refused() -> None:
    env, alone = together(FORCE, num_envs=1), single(FORCE)
    env.reset(seed=0)
    alone.reset(seed=0)
    before = pickle.dumps(env.get_state())
    for state, kind in ((alone.get_state(), "EnvState"), (None, "NoneType"), ({}, "dict")):
        with pytest.raises(InvalidValueError, match=f"saved state is '{kind}'; allowed: a VectorState"):
            env.set_state(state)  # type: ignore[arg-type]
    with pytest.raises(InvalidValueError, match="saved state is 'VectorState'"):
        alone.set_state(env.get_state())  # type: ignore[arg-type]
    assert pickle.dumps(env.get_state()) == before


@pytest.mark.parametrize(
    ("others", "words"),
    [
        ({"num_envs": N - 1}, "number of environments is 3; allowed: 4"),
        ({"num_envs": 1}, "number of environments is 1; allowed: 4"),
        ({"environment_id": "PRP-ForcePosition-v0"}, "task is 'PRP-ForcePosition-v0'; allowed: PRP-Force-v0"),
        ({"environment_id": "PRP-Adaptive-v0"}, "task is 'PRP-Adaptive-v0'"),
        ({"scenario": "realistic"}, "keywords"),
        ({"duration": 1.0}, "keywords"),
        ({"surface_stiffness": 100.0}, "keywords"),
    ],
)
def test_state_of_other_environments_is_refused_and_nothing_changes(
    others: dict[str, Any], words: str
) -> None:
    env, twin = together(FORCE, num_envs=N), together(FORCE, num_envs=N)
    other = together(**{"environment_id": FORCE, "num_envs": N, **others})
    other.reset(seed=1)
    for each in (env, twin):
        each.reset(seed=0)
    with pytest.raises(InvalidValueError, match=f"state's {words}"):
        env.set_state(other.get_state())
    for action in actions_for(env, 3):
        assert_same(env.step(action), twin.step(action), "step")
    assert_same(env.reset(), twin.reset(), "reset")


def test_environments_that_wait_cannot_be_put_where_nothing_waits() -> None:
    env, values = midway(FORCE, "NextStep")
    same = together(FORCE, "SameStep", N, scenario="realistic", **SHORT)
    with pytest.raises(
        InvalidValueError, match=r"ended environments is \[1, 3\]; allowed: none with SameStep"
    ):
        same.set_state(env.get_state())
    env.reset()
    same.set_state(env.get_state())
    assert_same(same.step(values[1]), env.step(values[1]), "step")


@pytest.mark.parametrize("copied", [copy.deepcopy, by_pickle])
def test_environments_never_reset_are_copied_with_their_views(copied: Copier) -> None:
    env = together(FORCE, "SameStep", N)
    env.envs[1].label = 7
    clone = copied(env)
    assert clone.metadata == env.metadata
    assert clone.envs[1].get_wrapper_attr("label") == 7
    assert clone.reset(seed=1)[0].shape == (N, env.observation_layout.size)
    np.testing.assert_array_equal(clone.envs[2].ground_truth, clone.ground_truth[2])
    env.reset(seed=2)
    assert (clone.envs[2].ground_truth != env.envs[2].ground_truth).any()


def resident() -> int:
    """Memory of this process [bytes], without what the C library keeps to give out again."""
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="reads /proc and trims the C library's heap")
def test_dropped_environments_give_their_memory_back() -> None:
    sizes = []
    for _ in range(12):
        env = together("PRP-PoseRegulation-v0", "SameStep", 32)
        env.reset(seed=0)
        assert len(env.envs) == 32
        env.step(actions_for(env, 1)[0])
        del env
        gc.collect()
        sizes.append(resident())
    # one of them takes some 10 MB, so 7 that were kept 70 MB
    assert sizes[-1] - sizes[4] < 10e6
