"""Common steps of the bootstraps: checks of the runs, resampling in blocks, percentile intervals."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import as_array, check_finite, random_generator, shaped, whole
from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError
from prp_gym.robot.arrays import Array

RESAMPLES = 2000
_MOST_RESAMPLES = 10**6
BLOCK = 2**20  # numbers drawn at once at most, unless one resample alone has more

Indices = NDArray[np.int64]
Counts = NDArray[np.int64]
Runs = Mapping[str, Array]


def check_bootstrap(confidence: float, resamples: int, rng: np.random.Generator) -> None:
    """Refuse an invalid confidence, number of resamples or random generator.

    Raises:
        InvalidValueError: a confidence outside (0, 1), no resamples or too many, or no random generator.
        ShapeError: several numbers in place of one.
    """
    if not 0.0 < float(shaped("confidence", confidence, ())) < 1.0:
        raise InvalidValueError("confidence", confidence, "between 0 and 1")
    whole("number of resamples", resamples, 1, _MOST_RESAMPLES)
    random_generator("rng", rng)


def check_scores(scores: Array, what: str, axes: Sequence[str]) -> Array:
    """`scores` as finite float64 numbers, one axis for each name in `axes`.

    Raises:
        ShapeError: another number of axes.
        InvalidValueError: no scores.
        NonFiniteError: NaN or infinity among them.
    """
    checked = as_array(what, scores)
    if checked.ndim != len(axes):
        raise ShapeError(what, checked.shape, f"({', '.join(axes)})")
    if checked.size == 0:
        raise InvalidValueError(f"number of {what}", 0, "at least 1")
    wrong = checked[~np.isfinite(checked)]
    if wrong.size:
        raise NonFiniteError(f"one of the {what}", float(wrong[0]))
    check_finite(what, checked)
    return checked


def check_runs(runs: Runs, policy: str = "scores") -> dict[str, Array]:
    """Scores of each task, sorted by task, so that results do not depend on the order of the mapping.

    Args:
        runs: one array (runs of the task) for each task.
        policy: name of the policy whose scores they are, for messages.

    Raises:
        InvalidValueError: no tasks, or a task without runs.
        ShapeError: runs of a task that are not in one row.
        NonFiniteError: NaN or infinity among the runs.
    """
    if not isinstance(runs, Mapping) or not all(isinstance(task, str) for task in runs):
        raise InvalidValueError(policy, runs, "a mapping from the names of tasks to their scores")
    if not runs:
        raise InvalidValueError(f"number of tasks in {policy}", 0, "at least 1")
    return {task: check_scores(runs[task], f"{policy} of task {task!r}", ("runs",)) for task in sorted(runs)}


def check_same_tasks(x: Runs, y: Runs) -> None:
    """Refuse two policies that were not evaluated on the same tasks.

    Raises:
        InvalidValueError: a task of one is not a task of the other.
    """
    if set(x) != set(y):
        raise InvalidValueError("tasks of y", sorted(y), f"the tasks of x, {sorted(x)}")


def split_resamples(resamples: int, size: int) -> Iterator[int]:
    """How many resamples of `size` numbers each to draw at once, until all are drawn."""
    step = max(1, BLOCK // size)
    for start in range(0, resamples, step):
        yield min(step, resamples - start)


def draw_counts(resamples: int, runs: int, rng: np.random.Generator) -> Counts:
    """How often each of `runs` is in each resample: (resamples, runs), rows that sum to `runs`."""
    drawn = rng.integers(runs, size=(resamples, runs))
    cells = drawn + runs * np.arange(resamples)[:, None]
    return np.bincount(cells.ravel(), minlength=resamples * runs).reshape(resamples, runs)


def accumulate(counts: Counts) -> Counts:
    """Sum of the first 0, 1, ..., n counts: (..., n) -> (..., n + 1)."""
    total: Counts = np.zeros((*counts.shape[:-1], counts.shape[-1] + 1), dtype=np.int64)
    np.cumsum(counts, axis=-1, out=total[..., 1:])
    return total


def cut_tails(drawn: Array, confidence: float) -> tuple[Array, Array]:
    """Percentile interval over the first axis: (resamples, ...) -> low (...), high (...)."""
    tail = (1.0 - confidence) / 2
    low, high = np.quantile(drawn, [tail, 1.0 - tail], axis=0)
    return low, high
