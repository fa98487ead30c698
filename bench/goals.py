"""Goals for the suite's speed, and whether a run of the benchmark reached them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.rounds import ALL_CORES, FREE, LARGE_PPO, REACHER, Label, ratios
from bench.single import REACHER_FREQUENCY
from prp_gym.robot.arrays import Array

Results = Mapping[str, Any]
Rows = Sequence[Mapping[str, Any]]

BARE_SIZES = (256, 1024)
SYNC_SIZE = 64
GROWTH_SIZES = (64, 4096)
EVALUATION_LIMIT = 180.0  # [s]

AS_SHIPPED = "as shipped"
WITHOUT_CLOCK = "clock off for both"


@dataclass(frozen=True)
class Goal:
    """A goal, and the value that a run reached.

    Attributes:
        key: Key of the text in `limits.toml` that explains what limits it.
        what: Programs that are compared.
        how: Clock settings of the programs.
        target: Value to be reached.
        at_least: Whether the target is a lower or an upper bound.
        unit: Unit of the values: `times`, `%` or `s`.
        reached: Median over the rounds.
        lowest: Lowest value over the rounds.
        highest: Highest value over the rounds.
    """

    key: str
    what: str
    how: str
    target: float
    at_least: bool
    unit: str
    reached: float
    lowest: float
    highest: float

    @property
    def met(self) -> bool:
        """Whether the goal was reached."""
        return self.reached >= self.target if self.at_least else self.reached <= self.target


@dataclass(frozen=True)
class Question:
    """Common part of several goals.

    Attributes:
        key: Key of the explaining text, see `Goal`.
        what: Programs that are compared, see `Goal`.
        target: Lower bound of the ratio of rates.
    """

    key: str
    what: str
    target: float

    def answer(self, how: str, rows: Rows, one: Label, other: Label) -> Goal:
        """Goal for the median over the rounds of the ratio of two rates."""
        values = ratios(rows, one, other)
        return Goal(self.key, self.what, how, self.target, True, "times", *_spread(values))

    def both(self, rows: Rows, own: Label, peer: Label) -> Iterator[Goal]:
        """Goals relative to a peer with its default clock setting, and to the same peer without clock."""
        for how, clock in ((AS_SHIPPED, True), (WITHOUT_CLOCK, False)):
            yield self.answer(how, rows, own, replace(peer, clock=clock))


def _spread(values: Array) -> tuple[float, float, float]:
    return float(np.median(values)), float(values.min()), float(values.max())


def _single(results: Results) -> Iterator[Goal]:
    rows, fast = results["single"], Label("single", FREE, 500.0)
    slow = replace(fast, control_frequency=50.0)
    reacher = Question("single", "single environment at 500 Hz against Reacher-v5", 1.3)
    yield from reacher.both(rows, fast, Label("single", REACHER, REACHER_FREQUENCY))
    bare = Question("single_bare", "single environment at 50 Hz against bare mj_step", 0.85)
    yield from bare.both(rows, slow, replace(slow, kind="bare"))


def _vector(results: Results) -> Iterator[Goal]:
    rows = results["vector"]
    if not _has_sizes(rows):
        return
    for count in BARE_SIZES:
        what = f"vector environment, N = {count}, at 50 Hz against bare mj_step on all cores"
        own, bare = Label("native", FREE, 50.0, count, ALL_CORES), Label("bare_all_cores", FREE, 50.0)
        yield from Question("vector_bare", what, 0.85).both(rows, own, bare)
    own, sync = Label("native", FREE, 500.0, SYNC_SIZE, ALL_CORES), Label("sync", FREE, 500.0, SYNC_SIZE)
    what = f"vector environment, N = {SYNC_SIZE}, at 500 Hz against SyncVectorEnv of the same environment"
    yield Question("vector_sync", what, 4.0).answer(AS_SHIPPED, rows, own, sync)
    for frequency in (500.0, 50.0):
        yield _growth(rows, frequency)


def _growth(rows: Rows, frequency: float) -> Goal:
    few, many = GROWTH_SIZES
    own = Label("native", FREE, frequency, few, ALL_CORES)
    values = 100.0 * (ratios(rows, own, replace(own, num_envs=many)) - 1.0)
    what = f"growth of the cost of a single environment's step, N = {few} to {many}, at {frequency:g} Hz"
    return Goal("growth", what, AS_SHIPPED, 10.0, False, "%", *_spread(values))


def _has_sizes(rows: Rows) -> bool:
    """Whether a run has the sizes of vector environments that the goals require."""
    sizes = {row["num_envs"] for row in rows if row["kind"] == "native"}
    return {*BARE_SIZES, *GROWTH_SIZES, SYNC_SIZE} <= sizes


def _training(results: Results) -> Iterator[Goal]:
    rows = results["training"][LARGE_PPO]
    count = int(rows[0]["num_envs"])
    for frequency in (500.0, 50.0):
        what = f"PPO, N = {count}, at {frequency:g} Hz against Reacher-v5 in DummyVecEnv"
        own = Label("adapter", FREE, frequency, count, ALL_CORES)
        peer = Label("dummy", REACHER, REACHER_FREQUENCY, count)
        yield from Question("training", what, 1.5).both(rows, own, peer)


def _evaluate(results: Results) -> Iterator[Goal]:
    seconds = results["evaluate"]["seconds"]
    what = "`make evaluate`, all controllers on all environments"
    yield Goal("evaluate", what, AS_SHIPPED, EVALUATION_LIMIT, False, "s", seconds, seconds, seconds)


_BY_PART: Mapping[str, Callable[[Results], Iterator[Goal]]] = {
    "single": _single,
    "vector": _vector,
    "training": _training,
    "evaluate": _evaluate,
}


def goals(results: Results) -> list[Goal]:
    """The goals of the parts that a run measured."""
    return [goal for part, make in _BY_PART.items() if part in results for goal in make(results)]


def describe(goal: Goal) -> dict[str, Any]:
    """The goal as it is stored in the results."""
    return {**vars(goal), "met": goal.met}
