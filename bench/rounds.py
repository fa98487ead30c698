"""Measurements in rounds: programs take turns, so that a drift of the machine's speed favours none."""

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
"""Number of threads that stands for all cores."""

LARGE_PPO = "PPO, N = 64"
"""Name of the training that a goal is about."""


@dataclass(frozen=True)
class Label:
    """Label of a measured program.

    Attributes:
        kind: Kind of program: `bare` and `bare_all_cores` for MuJoCo alone, `single`, `native`, `sync`,
            `async`, `dummy` and `adapter` for environments.
        environment: Environment id.
        control_frequency: Environment steps per simulated second [Hz].
        num_envs: Number of environments N.
        threads: Number of threads of the physics; 0 uses all cores.
        clock: Whether MuJoCo reads its clock in every step, as its Python module makes it do.
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
        label: Label of the program.
        rate: Function that returns environment steps per second, measured over about the given time [s].
        close: Function that ends the program.
    """

    label: Label
    rate: Callable[[float], float]
    close: Callable[[], None] = lambda: None


@dataclass(frozen=True)
class Effort:
    """Extent of a run.

    Attributes:
        rounds: Number of rounds of the single environments; their medians are reported.
        vector_rounds: Number of rounds of all other programs.
        single_seconds: Time that each single environment runs in a round [s].
        seconds: Time that each other program runs in a round [s].
        sizes: Sizes N of the native vector environment; the goals need 64, 256, 1024 and 4096.
        loop_sizes: Sizes N of the vector environments that loop over single ones.
        library_size: Size N of Stable-Baselines3's vector environments.
        chunk_steps: Steps of the environments of a loop between two readings of the clock.
        duration: Duration of an episode [s].
        recipes: Number of training recipes that are measured.
        training_scale: Factor of the steps for which agents are trained.
    """

    rounds: int
    vector_rounds: int
    single_seconds: float
    seconds: float
    sizes: tuple[int, ...]
    loop_sizes: tuple[int, ...]
    library_size: int
    chunk_steps: int
    duration: float
    recipes: int
    training_scale: float


FULL = Effort(25, 5, 0.15, 0.25, (1, 8, 64, 256, 1024, 4096), (8, 64), 64, 1024, 5.0, 4, 1.0)
QUICK = Effort(2, 2, 0.001, 0.001, (1, 4), (2,), 4, 64, 0.1, 1, 0.001)


@dataclass(frozen=True, eq=False)
class Result:
    """Rates of one program.

    Attributes:
        label: Label of the program.
        rates: Rates of all rounds [1/s].
    """

    label: Label
    rates: Array

    def describe(self) -> dict[str, Any]:
        """The result as it is stored."""
        spread = {"median": np.median(self.rates), "lowest": self.rates.min(), "highest": self.rates.max()}
        return {**asdict(self.label), **spread, "rates": self.rates}


def timed(chunk: Callable[[], float]) -> Callable[[float], float]:
    """Function that measures the rate of a chunk, which returns its number of steps."""

    def rate(seconds: float) -> float:
        steps, start = 0.0, time.perf_counter()
        while (elapsed := time.perf_counter() - start) < seconds:
            steps += chunk()
        return steps / elapsed

    return rate


def race(contenders: Sequence[Contender], rounds: int, seconds: float) -> list[Result]:
    """Measure programs in turn, and end them.

    Args:
        contenders: Programs with different labels.
        rounds: Number of rounds.
        seconds: Time of each program in a round [s].

    Returns:
        Rates of each program, in the given order.
    """
    rates: list[list[float]] = [[] for _ in contenders]
    gc.collect()
    gc.freeze()  # programs that wait cost the others no time
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
    """The row of a program in a section of the results.

    Raises:
        UnknownNameError: There is no such row.
    """
    wanted, names = asdict(label), []
    for row in rows:
        if all(row[key] == value for key, value in wanted.items()):
            return row
        names.append("/".join(str(row[key]) for key in wanted))
    raise UnknownNameError("contender", "/".join(map(str, wanted.values())), names)


def ratios(rows: Sequence[Mapping[str, Any]], one: Label, other: Label) -> Array:
    """Ratio of the rates of two programs in each round (rounds)."""
    quotient: Array = np.array(find(rows, one)["rates"]) / np.array(find(rows, other)["rates"])
    return quotient
