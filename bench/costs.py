"""What a step and a reset are made of.

The parts of a step are measured one by one, over the same episode, in turn: the physics alone under the same
torques, the loop of environments that holds it (`EpisodeLoop.step`), and the environment as it is made for
users. What a part costs beyond the one that it holds is its own. A law is timed on observations of the same
episode.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import seeding

import prp_gym
from bench.rounds import CONTACT, FREE, Effort
from bench.single import random_actions
from prp_gym.robot.arrays import Array

LAWS = {FREE: "joint_inverse_dynamics", CONTACT: "impedance"}
FREQUENCY = 500.0
_OBSERVATIONS = 200
_MOST_STEPS = 500

Step = Callable[[Any], object]


@dataclass(frozen=True)
class Place:
    """Where costs are measured.

    Attributes:
        environment: id.
        num_envs: N; a single environment is no vector environment.
        threads: of the physics.
    """

    environment: str
    num_envs: int
    threads: int


class Parts:
    """The parts of one place, each over an episode of its own that is the same for all.

    Args:
        place: where.
        effort: how long an episode is.
    """

    def __init__(self, place: Place, effort: Effort) -> None:
        self.place = place
        settings: dict[str, Any] = {"control_frequency": FREQUENCY, "duration": effort.duration}
        self.single = gymnasium.make(place.environment, **settings)
        inner: Any = self.single.unwrapped
        self._horizon = min(inner.config.horizon - 1, _MOST_STEPS)  # nothing is reset on the way
        self._substeps, self._limit = inner.config.substeps, inner.torque_limit
        self._loop = inner.make_loop(place.num_envs, place.threads)
        self._actions = list(random_actions(place.num_envs, inner.action_space.shape[0]).astype(np.float64))
        self._law = prp_gym.make_baseline(LAWS[place.environment], self.single)
        self._env: Any = self.single
        if place.num_envs > 1:
            self._env = gymnasium.make_vec(
                place.environment, num_envs=place.num_envs, num_threads=place.threads, **settings
            )

    def measure(self) -> dict[str, float]:
        """Seconds of each part for a step of one environment [s]."""
        physics = self._play(self._begin_loop, self._advance)
        loop = self._play(self._begin_loop, self._loop.step)
        env = self._play(lambda: self._env.reset(seed=0), self._step_env)
        law = self._time_law()
        return {"physics": physics, "task": loop - physics, "wrapper": env - loop, "step": env, "law": law}

    def _begin_loop(self) -> None:
        rngs = [seeding.np_random(seed)[0] for seed in range(self.place.num_envs)]
        self._loop.reset(np.arange(self.place.num_envs), rngs, {})

    def _advance(self, action: Array) -> None:
        self._loop.physics.set_torque(action * self._limit)
        self._loop.physics.advance(self._substeps)

    def _step_env(self, action: Array) -> None:
        self._env.step(action if self.place.num_envs > 1 else action[0])

    def _play(self, begin: Callable[[], object], step: Step) -> float:
        begin()
        start = time.perf_counter()
        for index in range(self._horizon):
            step(self._actions[index % len(self._actions)])
        return float((time.perf_counter() - start) / (self._horizon * self.place.num_envs))

    def _time_law(self) -> float:
        self._begin_loop()
        seen = [
            self._loop.step(self._actions[index]).observation
            for index in range(min(_OBSERVATIONS, self._horizon))
        ]
        if self.place.num_envs == 1:
            seen = [observation[0] for observation in seen]
        state = None
        start = time.perf_counter()
        for observation in seen:
            _, state = self._law.predict(observation, state)
        return (time.perf_counter() - start) / len(seen) / self.place.num_envs

    def close(self) -> None:
        """End the environments."""
        self._env.close()
        self.single.close()


def places(effort: Effort) -> Iterator[Place]:
    """The single environment, and many of them on one core and on all."""
    for environment in LAWS:
        yield Place(environment, 1, 1)
        yield Place(environment, effort.library_size, 1)
        yield Place(environment, effort.library_size, 0)


def split_steps(effort: Effort) -> list[dict[str, Any]]:
    """Medians over the rounds of what each part of a step costs [s]."""
    parts = [Parts(place, effort) for place in places(effort)]
    rounds = [[one.measure() for one in parts] for _ in range(effort.vector_rounds)]
    rows = []
    for index, one in enumerate(parts):
        seconds = _medians([turn[index] for turn in rounds])
        about = {"law_name": LAWS[one.place.environment], "control_frequency": FREQUENCY}
        rows.append({**vars(one.place), **about, "seconds": seconds})
        one.close()
    return rows


def time_resets(effort: Effort, sizes: Sequence[int]) -> list[dict[str, Any]]:
    """Medians of the time that a reset costs for each environment [s]: of all at once, and of one of N."""
    rows = []
    for environment in LAWS:
        for count in sizes:
            reset, one = _resets(environment, count)
            turns = [{"all": reset() / count, "one": one()} for _ in range(effort.vector_rounds)]
            rows.append({"environment": environment, "num_envs": count, "seconds": _medians(turns)})
    return rows


def _resets(environment: str, count: int) -> tuple[Callable[[], float], Callable[[], float]]:
    """What resets all environments, and what resets the first; both return how long it took [s]."""
    env: Any = gymnasium.make(environment) if count == 1 else gymnasium.make_vec(environment, count)
    env.reset(seed=0)
    first = np.arange(count) == 0

    def one() -> float:
        options = None if count == 1 else {"reset_mask": first}
        return _seconds(lambda: env.reset(options=options))

    return lambda: _seconds(env.reset), one


def _seconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def _medians(turns: Sequence[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.median([turn[name] for turn in turns])) for name in turns[0]}
