"""Cost of the parts of a step, and of a reset.

The parts are timed within the same steps: the call that advances the physics, the step of the loop of
environments that contains it (`EpisodeLoop.step`, `step_alone`), and the step of the environment as users
have it. The own cost of a part is its time without that of the part that it contains. Controllers are timed
on the observations of these steps.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

import prp_gym
from bench.part_times import PartTimes
from bench.rounds import ALL_CORES, CONTACT, FREE, Effort
from bench.single import CONDITIONS, random_actions
from prp_gym.robot.arrays import Array

CONTROLLERS = {FREE: "joint_inverse_dynamics", CONTACT: "impedance"}
GAINS = {500.0: "tuned", 50.0: "tuned_50hz"}
_MOST_STEPS = 500
_LEAST_STEPS = 8
_SUBSTEPS_A_TURN = 2**16  # of all environments together


@dataclass(frozen=True)
class Condition:
    """Condition in which costs are measured.

    Attributes:
        environment: Environment id.
        control_frequency: Control frequency [Hz].
        num_envs: Number of environments N; with N = 1 it is not a vector environment.
        threads: Number of threads of the physics.
    """

    environment: str
    control_frequency: float
    num_envs: int
    threads: int


class Parts:
    """Parts of a step in one condition, timed within the environment as users have it.

    Args:
        condition: Condition in which they are measured.
        effort: Effort of the run, whose duration of episodes is used.
    """

    def __init__(self, condition: Condition, effort: Effort) -> None:
        self.condition = condition
        settings: dict[str, Any] = {
            "control_frequency": condition.control_frequency,
            "duration": effort.duration,
        }
        self._single = gymnasium.make(condition.environment, **settings)
        inner: Any = self._single.unwrapped
        most = _steps(condition.num_envs * inner.config.substeps)
        self._steps = min(inner.config.horizon - 1, most)  # without resets
        self._actions = random_actions(condition.num_envs, inner.action_space.shape[0])
        gains = GAINS[condition.control_frequency]
        self._controller = prp_gym.make_baseline(CONTROLLERS[condition.environment], self._single, gains)
        self._env: Any = self._single
        if condition.num_envs > 1:
            self._env = gymnasium.make_vec(
                condition.environment, condition.num_envs, num_threads=condition.threads, **settings
            )
        else:
            self._actions = self._actions[:, 0]
        loop, self._times = self._env.unwrapped._loop, PartTimes()
        self._times.count("loop", loop, "step")
        self._times.count("loop", loop, "step_alone")  # of a single environment, in place of `step`
        self._times.count("physics", loop.physics, "advance")

    def measure(self) -> dict[str, float]:
        """Time of each part for a step of one environment [s]."""
        self._env.reset(seed=0)
        self._times.restart()
        seen, start = [], time.perf_counter()
        for index in range(self._steps):
            seen.append(self._env.step(self._actions[index % len(self._actions)])[0])
        step, (loop, physics) = time.perf_counter() - start, self._times.seconds.values()
        controller = self._time_controller(seen)
        parts = {
            "physics": physics,
            "task": loop - physics,
            "wrapper": step - loop,
            "step": step,
            "controller": controller,
        }
        return {name: seconds / (self._steps * self.condition.num_envs) for name, seconds in parts.items()}

    def _time_controller(self, seen: Sequence[Array]) -> float:
        state, start = None, time.perf_counter()
        for observation in seen:
            _, state = self._controller.predict(observation, state)
        return time.perf_counter() - start

    def close(self) -> None:
        """End the environments."""
        self._env.close()
        self._single.close()


def _steps(substeps: int) -> int:
    """Number of steps of a round, given the substeps that all environments together take per step."""
    return max(_LEAST_STEPS, min(_MOST_STEPS, _SUBSTEPS_A_TURN // substeps))


def conditions(effort: Effort) -> Iterator[Condition]:
    """The single environment, and vector environments on one core and on all; fewer of them in contact."""
    few = effort.library_size
    many = [count for count in effort.sizes if count >= few]
    for environment, frequency in CONDITIONS:
        yield Condition(environment, frequency, 1, 1)
        yield Condition(environment, frequency, few, 1)
        for count in many if environment == FREE else [few]:
            yield Condition(environment, frequency, count, ALL_CORES)


def split_steps(effort: Effort) -> list[dict[str, Any]]:
    """Medians over the rounds of the cost of each part of a step [s]."""
    parts = [Parts(condition, effort) for condition in conditions(effort)]
    rounds = [[one.measure() for one in parts] for _ in range(effort.vector_rounds)]
    rows = []
    for index, one in enumerate(parts):
        seconds = _medians([turn[index] for turn in rounds])
        rows.append(
            {
                **vars(one.condition),
                "controller_name": CONTROLLERS[one.condition.environment],
                "seconds": seconds,
            }
        )
        one.close()
    return rows


def time_resets(effort: Effort, sizes: Sequence[int]) -> list[dict[str, Any]]:
    """Medians of the time of a reset per environment [s]: of all together, and of one of N."""
    rows = []
    for environment in CONTROLLERS:
        for count in sizes:
            reset, one = _resets(environment, count)
            turns = [{"all": reset() / count, "one": one()} for _ in range(effort.vector_rounds)]
            rows.append({"environment": environment, "num_envs": count, "seconds": _medians(turns)})
    return rows


def _resets(environment: str, count: int) -> tuple[Callable[[], float], Callable[[], float]]:
    """Functions that reset all environments and the first one; both return the time that it took [s]."""
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
