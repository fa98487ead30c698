"""What the tests of all controllers share: on which environments they run, and observations of episodes."""

from collections.abc import Hashable, Mapping
from contextlib import closing
from functools import cache
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import prp_gym
from prp_gym.baselines import Baseline, list_baselines, make_baseline
from tests.support.covering import covering

Array = NDArray[np.float64]


def make(environment_id: str, **options: Any) -> Any:
    return gymnasium.make(environment_id, **options)


@cache
def environment(environment_id: str) -> Any:
    """A shared environment that callers inspect but never step."""
    return make(environment_id)


def kind_of_environment(environment_id: str) -> Hashable:
    """What can be measured there: the model, its contact, the references and the reference model."""
    task = environment(environment_id).unwrapped.task
    return type(task.model), frozenset(task.ground_truth_layout.names)


ENVIRONMENTS = list({kind_of_environment(name): name for name in reversed(prp_gym.list_envs())}.values())
"""One environment of each kind, for what depends on the kind of its fields alone."""


def controllers_of(environment_id: str) -> list[str]:
    """The controllers that can run on an environment."""
    return list_baselines(environment(environment_id).get_wrapper_attr("observation_layout"))


COMBINATIONS = [(name, controller) for name in prp_gym.list_envs() for controller in controllers_of(name)]
"""Every environment with every controller that can run on it."""


class Watched(dict[str, Array]):
    """Fields by name that record which of them were read."""

    def __init__(self, fields: Mapping[str, Array]) -> None:
        super().__init__(fields)
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Array:
        self.read.add(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        self.read.add(name)
        return super().get(name, default)


def fields_read(policy: Baseline[Any], observation: Array) -> set[str]:
    """The fields of an observation that a controller reads in its first two steps."""
    watched = Watched(policy.interface.layout.split(observation))
    state = policy.initial_state(watched)
    for _ in range(2):
        _, state = policy.control(watched, state)
    return watched.read


def kind_of(combination: tuple[str, str]) -> Hashable:
    """What a controller sees of an environment: its model, the fields that it reads, what it must render."""
    environment_id, controller = combination
    policy = make_baseline(controller, environment(environment_id))
    layout = policy.interface.layout
    observation = np.random.default_rng(0).uniform(-1.0, 1.0, size=layout.size)
    read = fields_read(policy, observation) & set(layout.names)
    rendered = set(policy.rendered) & set(policy.interface.target_impedance)
    return controller, type(policy.model), frozenset(read), frozenset(rendered)


COVERING = covering(COMBINATIONS, kind_of)
"""Every controller on one environment of each kind that it distinguishes, and every environment."""

ONE_EACH = covering(COMBINATIONS, lambda combination: combination[1])
"""Every controller once and every environment once, for what depends on one of them alone."""


@cache
def observed_episodes(
    environment_id: str, controller: str, count: int, length: int
) -> tuple[Baseline[Any], Array]:
    """A controller, and what it observes in the first second of realistic episodes (length, count, size)."""
    with closing(make(environment_id, scenario="realistic", duration=1.0)) as env:
        policy, loop = make_baseline(controller, env), env.unwrapped.make_loop(count)
    rngs = [np.random.default_rng(seed) for seed in range(count)]
    observation, state = loop.reset(np.arange(count), rngs, {}), None
    starts, seen = np.ones(count, dtype=np.bool_), []
    for _ in range(500):
        seen.append(observation)
        action, state = policy.predict(observation, state, starts)
        observation, starts = (
            loop.step(action.astype(np.float64)).observation,
            np.zeros(count, dtype=np.bool_),
        )
    return policy, np.array(seen)[:: 500 // length]
