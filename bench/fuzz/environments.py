"""Cases of environments: actions, reset options, keywords, saved states."""

import copy
from dataclasses import fields
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from hypothesis import strategies as st

import prp_gym
from bench.fuzz.strange import STRANGE, mostly, named, replaced
from bench.fuzz.target import Prepared, Target
from prp_gym.envs import PRPEnv, PRPVectorEnv
from prp_gym.envs.config import EnvConfig
from prp_gym.tasks.spec import TASKS

_MODE = "variable_impedance"
_LONGEST_TEXT = 10_000  # characters
_SINGLE: tuple[tuple[str, dict[str, Any]], ...] = (
    ("PRP-JointTracking-v0", {}),
    ("PRP-Force-v0", {"scenario": "realistic"}),
    ("PRP-Adaptive-v0", {}),
    ("PRP-Impedance-v0", {"action_mode": _MODE, "control_frequency": 50}),
)


def _single() -> list[Any]:
    return [PRPEnv(task, **keywords) for task, keywords in _SINGLE]


def _together() -> list[Any]:
    return [PRPVectorEnv("PRP-Force-v0", num_envs=2, num_threads=1)]


def _prepare_actions(_: Path) -> Prepared:
    environments = [*_single(), *_together()]
    for env in environments:
        env.reset(seed=0)

    def call(arguments: tuple[int, dict[int, float], Any]) -> object:
        index, parts, strange = arguments
        env = environments[index]
        action = np.zeros(env.action_space.shape)
        for slot, value in parts.items():
            action.flat[slot % action.size] = value
        outcome = env.step(action if strange is None else strange)
        if np.any(outcome[2]) or np.any(outcome[3]):
            return outcome, env.reset()
        return outcome

    which = st.integers(0, len(environments) - 1)
    return Prepared(st.tuples(which, replaced(8), st.none() | STRANGE), call)


def _prepare_resets(_: Path) -> Prepared:
    environments = [*_single(), *_together()]
    names = [*sorted({name for env in environments for name in env.task.reset_options}), "reset_mask", "gaol"]

    def call(arguments: tuple[int, Any, Any]) -> object:
        index, seed, options = arguments
        return environments[index].reset(seed=seed, options=options)

    options: st.SearchStrategy[Any] = st.just({}) | named(names, STRANGE)
    which = st.integers(0, len(environments) - 1)
    return Prepared(st.tuples(which, mostly(st.none() | st.integers(0, 99)), mostly(options)), call)


_VECTOR_KEYWORDS = ("num_envs", "num_threads", "autoreset_mode", "max_episode_steps")


def _prepare_keywords(_: Path) -> Prepared:
    tasks = prp_gym.list_envs()
    common = [entry.name for entry in fields(EnvConfig)]
    own = sorted({entry.name for task in tasks for entry in fields(TASKS[task].entry.options)})

    def call(arguments: tuple[int, Any, dict[str, Any]]) -> object:
        way, task, keywords = arguments
        known = isinstance(task, str) and task in tasks
        if way == 0 and known and "render_mode" not in keywords and _has_short_text(keywords):
            env: Any = gymnasium.make(task, **keywords)  # which itself reads the id and the render mode
        else:
            env = (PRPVectorEnv if way == 2 else PRPEnv)(task, **keywords)
        result = env.reset(seed=0)
        env.close()
        return result

    keywords = named([*common, *own], STRANGE)
    vector = named([*common, *_VECTOR_KEYWORDS], STRANGE)
    task = mostly(st.sampled_from(tasks))
    single = st.tuples(st.sampled_from([0, 1]), task, keywords)
    return Prepared(st.one_of(single, st.tuples(st.just(2), task, vector)), call)


def _has_short_text(keywords: dict[str, Any]) -> bool:
    """Whether Gymnasium can write keywords into the message of an error, as it does with all of them."""
    try:
        return len(str(keywords)) < _LONGEST_TEXT
    except Exception:  # of a value without a text
        return False


def _paths(value: Any, depth: int) -> list[tuple[Any, ...]]:
    """Paths to the parts of a state, down to a depth."""
    found: list[tuple[Any, ...]] = [()]
    if depth == 0 or isinstance(value, (str, bytes, type)) or callable(value):
        return found
    for key, part in _parts(value).items():
        found += [(key, *path) for path in _paths(part, depth - 1)]
    return found


def _parts(value: Any) -> dict[Any, Any]:
    if isinstance(value, dict):
        return value
    if isinstance(value, (tuple, list)):
        return dict(enumerate(value))
    return dict(getattr(value, "__dict__", {}))


def _changed(value: Any, path: tuple[Any, ...], new: Any) -> Any:
    """A copy of a state with one part replaced, or with a component of an array replaced."""
    if not path:
        if (
            isinstance(value, np.ndarray)
            and value.size
            and isinstance(new, float)
            and value.dtype.kind == "f"
        ):
            value = value.copy()
            value.flat[value.size // 2] = new
            return value
        return new
    key = path[0]
    part = _changed(_parts(value)[key], path[1:], new)
    if isinstance(value, dict):
        return {**value, key: part}
    if isinstance(value, (tuple, list)):
        parts = [part if index == key else old for index, old in enumerate(value)]
        return type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
    made = copy.copy(value)
    made.__dict__[key] = part
    return made


def _prepare_states(_: Path) -> Prepared:
    environments = [*_single(), *_together()]
    states, paths = [], []
    for env in environments:
        env.reset(seed=0)
        env.step(np.zeros(env.action_space.shape))
        states.append(env.get_state())
        paths.append(_paths(states[-1], 5))

    def call(arguments: tuple[int, int, Any]) -> object:
        index, number, new = arguments
        env, own = environments[index], paths[index]
        observation = env.set_state(_changed(states[index], own[number % len(own)], new))
        step = env.step(np.zeros(env.action_space.shape))
        env.set_state(states[index])
        return observation, step

    which = st.integers(0, len(environments) - 1)
    return Prepared(st.tuples(which, st.integers(0, 10**6), STRANGE), call)


ENVIRONMENTS = (
    Target("actions", _prepare_actions, 3.0),
    Target("reset", _prepare_resets, 3.0),
    Target("keywords", _prepare_keywords),
    Target("set_state", _prepare_states, 0.5),
)
