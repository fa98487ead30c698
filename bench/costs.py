"""What a step and a reset are made of.

The parts of a step are timed from within, in the same steps: the call that advances the physics, the step of
the loop of environments that holds it (`EpisodeLoop.step`), and the step of the environment as it is made for
users. What a part costs beyond the one that it holds is its own. A law is timed on the observations of these
steps.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any

import gymnasium
import numpy as np

import prp_gym
from bench.rounds import ALL_CORES, CONTACT, FREE, Effort
from bench.single import PLACES, random_actions
from prp_gym.robot.arrays import Array

LAWS = {FREE: "joint_inverse_dynamics", CONTACT: "impedance"}
GAINS = {500.0: "tuned", 50.0: "tuned_50hz"}
_MOST_STEPS = 500
_LEAST_STEPS = 8
_SUBSTEPS_A_TURN = 2**16  # of all environments together


@dataclass(frozen=True)
class Condition:
    """Where costs are measured.

    Attributes:
        environment: id.
        control_frequency: [Hz].
        num_envs: N; a single environment is no vector environment.
        threads: of the physics.
    """

    environment: str
    control_frequency: float
    num_envs: int
    threads: int


class Parts:
    """The parts of one place, timed from within the environment as it is made for users.

    Args:
        place: where.
        effort: how long an episode is.
    """

    def __init__(self, place: Condition, effort: Effort) -> None:
        self.place = place
        settings: dict[str, Any] = {"control_frequency": place.control_frequency, "duration": effort.duration}
        self._single = gymnasium.make(place.environment, **settings)
        inner: Any = self._single.unwrapped
        most = _steps(place.num_envs * inner.config.substeps)
        self._steps = min(inner.config.horizon - 1, most)  # nothing is reset on the way
        self._actions = random_actions(place.num_envs, inner.action_space.shape[0])
        gains = GAINS[place.control_frequency]
        self._controller = prp_gym.make_baseline(LAWS[place.environment], self._single, gains)
        self._env: Any = self._single
        if place.num_envs > 1:
            self._env = gymnasium.make_vec(
                place.environment, place.num_envs, num_threads=place.threads, **settings
            )
        else:
            self._actions = self._actions[:, 0]
        self._seconds = {"loop": 0.0, "physics": 0.0}
        loop = self._env.unwrapped._loop
        loop.step = self._timed("loop", loop.step)
        loop.physics.advance = self._timed("physics", loop.physics.advance)

    def _timed(self, part: str, call: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(call)
        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            result = call(*arguments)
            self._seconds[part] += time.perf_counter() - start
            return result

        return timed

    def measure(self) -> dict[str, float]:
        """Seconds of each part for a step of one environment [s]."""
        self._env.reset(seed=0)
        self._seconds = dict.fromkeys(self._seconds, 0.0)
        seen, start = [], time.perf_counter()
        for index in range(self._steps):
            seen.append(self._env.step(self._actions[index % len(self._actions)])[0])
        step, (loop, physics) = time.perf_counter() - start, self._seconds.values()
        controller = self._time_law(seen)
        parts = {
            "physics": physics,
            "task": loop - physics,
            "wrapper": step - loop,
            "step": step,
            "controller": controller,
        }
        return {name: seconds / (self._steps * self.place.num_envs) for name, seconds in parts.items()}

    def _time_law(self, seen: Sequence[Array]) -> float:
        state, start = None, time.perf_counter()
        for observation in seen:
            _, state = self._controller.predict(observation, state)
        return time.perf_counter() - start

    def close(self) -> None:
        """End the environments."""
        self._env.close()
        self._single.close()


def _steps(substeps: int) -> int:
    """Steps of a turn in which all environments together take so many substeps a step."""
    return max(_LEAST_STEPS, min(_MOST_STEPS, _SUBSTEPS_A_TURN // substeps))


def conditions(effort: Effort) -> Iterator[Condition]:
    """The single environment, and many of them on one core and on all; in contact only a few."""
    few = effort.library_size
    many = [count for count in effort.sizes if count >= few]
    for environment, frequency in PLACES:
        yield Condition(environment, frequency, 1, 1)
        yield Condition(environment, frequency, few, 1)
        for count in many if environment == FREE else [few]:
            yield Condition(environment, frequency, count, ALL_CORES)


def split_steps(effort: Effort) -> list[dict[str, Any]]:
    """Medians over the rounds of what each part of a step costs [s]."""
    parts = [Parts(place, effort) for place in conditions(effort)]
    rounds = [[one.measure() for one in parts] for _ in range(effort.vector_rounds)]
    rows = []
    for index, one in enumerate(parts):
        seconds = _medians([turn[index] for turn in rounds])
        rows.append({**vars(one.place), "law_name": LAWS[one.place.environment], "seconds": seconds})
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
