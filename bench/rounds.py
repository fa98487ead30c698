"""Races: contenders take turns, so that a machine whose speed drifts does not favour one of them."""

import gc
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from prp_gym.errors import UnknownNameError
from prp_gym.physics.clock import clock_reading
from prp_gym.robot.arrays import Array

FREE, CONTACT, REACHER = "PRP-JointTracking-v0", "PRP-Impedance-v0", "Reacher-v5"
ALL_CORES = 0
"""As a number of threads."""

LARGE_PPO = "PPO, N = 64"
"""The training that a goal is about."""


@dataclass(frozen=True)
class Label:
    """What a contender is.

    Attributes:
        kind: the program: `bare` and `bare_all_cores` for MuJoCo alone, `single`, `native`, `sync`, `async`,
            `dummy` and `adapter` for environments.
        environment: id.
        control_frequency: environment steps a simulated second [Hz].
        num_envs: N.
        threads: of the physics; 0 takes all cores.
        clock: whether MuJoCo reads its clock in every step, as its Python module makes it do.
    """

    kind: str
    environment: str
    control_frequency: float
    num_envs: int = 1
    threads: int = 1
    clock: bool = False


@dataclass(frozen=True)
class Contender:
    """A loop that can be timed.

    Attributes:
        label: what it is.
        rate: environment steps a second over about so many seconds.
        close: ends it.
    """

    label: Label
    rate: Callable[[float], float]
    close: Callable[[], None] = lambda: None


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        rounds: of the single environments; their medians are reported.
        vector_rounds: of everything else.
        single_seconds: that each single environment runs in a round [s].
        seconds: that everything else runs in a round [s].
        sizes: N of the native vector environment; the goals need 64, 256, 1024 and 4096.
        loop_sizes: N of the vector environments that loop over single ones.
        library_size: N of Stable-Baselines3's vector environments.
        duration: of an episode [s].
        recipes: how many of the ways to train.
        training_scale: of the steps that agents are trained for.
    """

    rounds: int
    vector_rounds: int
    single_seconds: float
    seconds: float
    sizes: tuple[int, ...]
    loop_sizes: tuple[int, ...]
    library_size: int
    duration: float
    recipes: int
    training_scale: float


FULL = Effort(25, 5, 0.15, 0.25, (1, 8, 64, 256, 1024, 4096), (8, 64), 64, 5.0, 4, 1.0)
QUICK = Effort(2, 2, 0.001, 0.001, (1, 4), (2,), 4, 0.1, 1, 0.001)


@dataclass(frozen=True, eq=False)
class Result:
    """Rates of one contender.

    Attributes:
        label: what it is.
        rates: of every round [1/s].
    """

    label: Label
    rates: Array

    def describe(self) -> dict[str, Any]:
        """As it stands in the results."""
        spread = {"median": np.median(self.rates), "lowest": self.rates.min(), "highest": self.rates.max()}
        return {**asdict(self.label), **spread, "rates": self.rates}


def timed(chunk: Callable[[], float]) -> Callable[[float], float]:
    """The rate of a chunk of work that returns how many steps it took, called until the time is over."""

    def rate(seconds: float) -> float:
        steps, start = 0.0, time.perf_counter()
        while (elapsed := time.perf_counter() - start) < seconds:
            steps += chunk()
        return steps / elapsed

    return rate


def race(contenders: Sequence[Contender], rounds: int, seconds: float) -> list[Result]:
    """Time contenders in turn, and end them.

    Args:
        contenders: each with its own label.
        rounds: turns of each.
        seconds: of a turn [s].

    Returns:
        the rates of each contender, in their order.
    """
    rates: list[list[float]] = [[] for _ in contenders]
    gc.collect()
    gc.freeze()  # what waits for its turn costs the others no time
    try:
        for _ in range(rounds):
            for contender, values in zip(contenders, rates, strict=True):
                with clock_reading(contender.label.clock):
                    values.append(contender.rate(seconds))
    finally:
        gc.unfreeze()
        for contender in contenders:
            contender.close()
    return [Result(one.label, np.array(values)) for one, values in zip(contenders, rates, strict=True)]


def find(rows: Iterable[Mapping[str, Any]], label: Label) -> Mapping[str, Any]:
    """The row of a contender among those of a section of the results.

    Raises:
        UnknownNameError: there is none.
    """
    wanted, names = asdict(label), []
    for row in rows:
        if all(row[key] == value for key, value in wanted.items()):
            return row
        names.append("/".join(str(row[key]) for key in wanted))
    raise UnknownNameError("contender", "/".join(map(str, wanted.values())), names)


def ratios(rows: Sequence[Mapping[str, Any]], one: Label, other: Label) -> Array:
    """How many times as fast one contender was as another in each round (rounds)."""
    quotient: Array = np.array(find(rows, one)["rates"]) / np.array(find(rows, other)["rates"])
    return quotient
