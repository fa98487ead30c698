"""Comparison of policies over tasks: performance profiles and probabilities of improvement."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError, NonFiniteError, PRPError, ShapeError
from prp_gym.evaluation import (
    Estimate,
    paired_probability_of_improvement,
    performance_profile,
    probability_of_improvement,
    resampling,
)
from prp_gym.robot.arrays import Array

PROPERTY = settings(max_examples=40, deadline=None, derandomize=True)
RUNS = st.lists(st.integers(0, 6).map(float), min_size=1, max_size=9)  # few values: many ties
TASKS = st.dictionaries(st.sampled_from("abcd"), RUNS, min_size=1, max_size=3)
PAIRED_RUNS = st.lists(st.tuples(*[st.integers(0, 4).map(float)] * 2), min_size=1, max_size=9)
ROUNDING = 1e-12  # sums of at most a hundred numbers up to 1
FEW = 50  # resamples, where only the estimate is looked at

Comparison = Callable[..., Estimate]
COMPARISONS = [probability_of_improvement, paired_probability_of_improvement]


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def arrays(tasks: dict[str, list[float]]) -> dict[str, Array]:
    return {task: np.array(runs) for task, runs in tasks.items()}


def shares_by_hand(tasks: dict[str, list[float]], levels: list[float]) -> list[float]:
    return [
        sum(sum(run > level for run in runs) / len(runs) for runs in tasks.values()) / len(tasks)
        for level in levels
    ]


def better(x: float, y: float) -> float:
    return 1.0 if x > y else 0.5 if x == y else 0.0


def spread(seed: int = 1) -> dict[str, Array]:
    rng = generator(seed)
    return {"reach": rng.normal(size=12), "track": rng.normal(0.5, size=20)}


@PROPERTY
@given(tasks=TASKS, levels=st.lists(st.integers(-1, 14).map(lambda n: n / 2), min_size=1, max_size=9))
def test_profile_counts_the_runs_above_each_threshold(
    tasks: dict[str, list[float]], levels: list[float]
) -> None:
    profile = performance_profile(arrays(tasks), np.array(levels), generator(), resamples=500)
    expected = shares_by_hand(tasks, levels)
    assert profile.thresholds.tolist() == levels
    assert profile.value == pytest.approx(expected, abs=ROUNDING)
    assert np.all((profile.low >= 0.0) & (profile.low <= profile.value + ROUNDING))
    assert np.all((profile.high <= 1.0) & (profile.high >= profile.value - ROUNDING))


def test_profile_weighs_tasks_and_not_runs() -> None:
    scores = {"long": np.zeros(99), "short": np.ones(1)}
    profile = performance_profile(scores, np.array([0.5]), generator())
    assert (profile.value[0], profile.low[0], profile.high[0]) == (0.5, 0.5, 0.5)


def test_profile_band_is_that_of_binomial_shares() -> None:
    # one of two runs is above: a resample has 0, 1 or 2 of them with ¼, ½, ¼, so tails of 0.2 reach 0 and 1
    # and tails of 0.3 do not; a deviation of 1 % at 2000 resamples is five times nearer than either
    one = {"task": np.array([0.0, 1.0])}
    for confidence, expected in ((0.6, (0.0, 1.0)), (0.4, (0.5, 0.5))):
        profile = performance_profile(one, np.array([0.5]), generator(), confidence)
        assert (profile.low[0], profile.high[0]) == expected
    # two such tasks: 0 to 4 of 4 with 1, 4, 6, 4, 1 sixteenths, if they are drawn apart from each other
    two = {"first": one["task"], "second": one["task"]}
    for confidence, expected in ((0.92, (0.0, 1.0)), (0.7, (0.25, 0.75)), (0.3, (0.5, 0.5))):
        profile = performance_profile(two, np.array([0.5]), generator(), confidence)
        assert (profile.low[0], profile.high[0]) == expected


def test_profile_moves_with_its_runs_and_not_with_their_order() -> None:
    scores, levels = spread(), np.linspace(-1.0, 1.0, 7)
    shuffled = {task: generator(4).permutation(scores[task]) for task in reversed(scores)}
    first, again = (performance_profile(given, levels, generator(2)) for given in (scores, shuffled))
    # multiples of ½ added to both change no comparison here: the runs are further apart than rounding
    shifted = {task: runs + 0.5 for task, runs in scores.items()}
    moved = performance_profile(shifted, levels + 0.5, generator(2))
    for part in ("value", "low", "high"):
        assert np.array_equal(getattr(first, part), getattr(again, part))
        assert np.array_equal(getattr(first, part), getattr(moved, part))


def test_profile_band_covers_the_true_shares_about_as_often_as_it_says() -> None:
    rng = generator(5)
    levels = np.array([-0.5, 0.0])
    ground_truth = (
        np.array([0.6914625, 0.5]) + np.array([0.9331928, 0.8413447])
    ) / 2  # normal, means 0 and 1
    covered = []
    for _ in range(300):
        scores = {"a": rng.normal(size=50), "b": rng.normal(1.0, size=30)}
        band = performance_profile(scores, levels, rng, resamples=300)
        covered.append((band.low <= ground_truth) & (ground_truth <= band.high))
    # 300 trials have a deviation of 1.3 %; percentile intervals of shares are 1 to 2 % too narrow
    assert np.all(np.abs(np.mean(covered, axis=0) - 0.94) < 0.04)


@PROPERTY
@given(x=TASKS, y=TASKS)
def test_probability_of_improvement_compares_every_run_with_every_other(
    x: dict[str, list[float]], y: dict[str, list[float]]
) -> None:
    y = {task: y.get(task, [3.0, 1.0]) for task in x}
    estimate = probability_of_improvement(arrays(x), arrays(y), generator(), resamples=FEW)
    shares = [np.mean([better(a, b) for a in x[task] for b in y[task]]) for task in x]
    assert estimate.value == pytest.approx(np.mean(shares), abs=ROUNDING)
    swapped = probability_of_improvement(arrays(y), arrays(x), generator(), resamples=FEW)
    assert estimate.value + swapped.value == pytest.approx(1.0, abs=ROUNDING)


@PROPERTY
@given(runs=st.dictionaries(st.sampled_from("abcd"), PAIRED_RUNS, min_size=1, max_size=3))
def test_paired_probability_compares_run_with_run(runs: dict[str, list[tuple[float, float]]]) -> None:
    x, y = ({task: np.array(found)[:, side] for task, found in runs.items()} for side in (0, 1))
    estimate = paired_probability_of_improvement(x, y, generator(), resamples=FEW)
    shares = [np.mean([better(first, second) for first, second in found]) for found in runs.values()]
    assert estimate.value == pytest.approx(np.mean(shares), abs=ROUNDING)


@pytest.mark.parametrize("compare", COMPARISONS)
def test_better_in_every_run_is_certain_improvement(compare: Comparison) -> None:
    worse = spread()
    best = {task: runs + 100.0 for task, runs in worse.items()}
    assert compare(best, worse, generator()) == Estimate(1.0, 1.0, 1.0)
    assert compare(worse, best, generator()) == Estimate(0.0, 0.0, 0.0)


def test_equal_policies_are_neither_better() -> None:
    scores = spread()
    estimate = probability_of_improvement(scores, scores, generator())
    assert estimate.value == 0.5
    assert estimate.low < 0.5 < estimate.high
    assert paired_probability_of_improvement(scores, scores, generator()) == Estimate(0.5, 0.5, 0.5)


def test_both_runs_of_a_seed_are_drawn_together() -> None:
    x = {"task": np.array([0.0, 10.0, 20.0, 30.0])}
    y = {"task": x["task"] - 1.0}
    assert paired_probability_of_improvement(x, y, generator()) == Estimate(1.0, 1.0, 1.0)
    # apart: 6 + 4 of 16 comparisons are won
    unpaired = probability_of_improvement(x, y, generator())
    assert unpaired.value == 10 / 16
    assert unpaired.low < 0.5 < unpaired.high


def test_interval_of_improvement_has_the_width_of_theory() -> None:
    # two runs against one between them: a resample wins 0, ½ or 1 with ¼, ½, ¼
    x, y = {"task": np.array([0.0, 2.0])}, {"task": np.array([1.0])}
    for a, b in ((x, y), (y, x)):
        assert probability_of_improvement(a, b, generator(), confidence=0.6) == Estimate(0.5, 0.0, 1.0)
        assert probability_of_improvement(a, b, generator(), confidence=0.4) == Estimate(0.5, 0.5, 0.5)
    # continuous and equal: σ² = (N + M + 1) / (12 N M), that of the Mann-Whitney statistic
    rng = generator(3)
    n, m = 60, 90
    widths = []
    for _ in range(40):
        found = probability_of_improvement({"t": rng.normal(size=n)}, {"t": rng.normal(size=m)}, rng)
        widths.append(found.high - found.low)
    expected = 2 * 1.96 * np.sqrt((n + m + 1) / (12 * n * m))
    # single widths scatter by 5 % and bootstraps of 60 runs are within 2 %: the mean of 40 within 5 %
    assert np.mean(widths) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("compare", COMPARISONS)
def test_interval_of_improvement_covers_the_true_value_about_as_often_as_it_says(compare: Comparison) -> None:
    rng = generator(6)
    covered = []
    for _ in range(300):
        x = {"a": rng.normal(size=40), "b": rng.normal(size=40)}
        y = {"a": rng.normal(size=40), "b": rng.normal(np.sqrt(2.0), size=40)}
        estimate = compare(x, y, rng, resamples=300)
        covered.append(estimate.low <= (0.5 + 0.1586553) / 2 <= estimate.high)  # P(N(-√2, 2) > 0) = Φ(-1)
    # 300 trials have a deviation of 1.3 %; percentile intervals of 40 runs are 1 to 2 % too narrow
    assert abs(np.mean(covered) - 0.94) < 0.04


@pytest.mark.parametrize("compare", COMPARISONS)
def test_improvement_does_not_depend_on_the_order_of_tasks_or_on_a_shift(compare: Comparison) -> None:
    x, y = spread(1), spread(2)
    reversed_x = {task: x[task] for task in reversed(x)}
    first, again = (compare(scores, y, generator(2)) for scores in (x, reversed_x))
    moved = compare(*({task: runs + 0.5 for task, runs in side.items()} for side in (x, y)), generator(2))
    assert first == again == moved


def test_improvement_does_not_depend_on_the_order_of_runs() -> None:
    x, y = spread(1), spread(2)
    orders = {task: generator(3).permutation(len(runs)) for task, runs in x.items()}
    mixed_x, mixed_y = ({task: side[task][orders[task]] for task in side} for side in (x, y))
    for compare in COMPARISONS:
        assert compare(x, y, generator(2)) == compare(mixed_x, mixed_y, generator(2))
    unpaired = probability_of_improvement(mixed_x, y, generator(2))
    assert unpaired == probability_of_improvement(x, y, generator(2))


@pytest.mark.parametrize("compare", COMPARISONS)
def test_interval_depends_on_the_generator_alone(compare: Comparison) -> None:
    x, y = spread(1), spread(2)
    first, again, other = (compare(x, y, generator(seed), resamples=200) for seed in (1, 1, 2))
    assert first == again
    assert first.value == other.value
    assert first != other
    widths = [np.diff(compare(x, y, generator(), confidence)[1:])[0] for confidence in (0.5, 0.9, 0.99)]
    assert widths == sorted(set(widths))


def test_resamples_are_drawn_in_blocks_of_bounded_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resampling, "BLOCK", 100)
    assert list(resampling.split_resamples(25, 10)) == [10, 10, 5]
    assert list(resampling.split_resamples(3, 1000)) == [1, 1, 1]
    # one task and one draw a block: the generator gives the same numbers in blocks as at once
    scores = {"task": spread()["reach"]}
    blocks = performance_profile(scores, np.zeros(1), generator(), resamples=333)
    monkeypatch.undo()
    whole = performance_profile(scores, np.zeros(1), generator(), resamples=333)
    assert (blocks.low, blocks.high) == (whole.low, whole.high)


def test_counts_of_a_resample_are_even_and_sum_to_the_runs() -> None:
    counts = resampling.draw_counts(4000, 7, generator())
    assert counts.shape == (4000, 7)
    assert np.all(counts.sum(axis=1) == 7)
    # binomial of 7 draws at 1/7: deviation 0.926, of a mean of 4000 0.015; five of these
    assert np.abs(counts.mean(axis=0) - 1.0).max() < 0.075
    assert counts.std() == pytest.approx(np.sqrt(6 / 7), abs=0.03)


@pytest.mark.parametrize(
    ("scores", "kind", "message"),
    [
        ({}, InvalidValueError, "number of tasks in .* is 0; allowed: at least 1"),
        ({"reach": np.array([])}, InvalidValueError, "of task 'reach' is 0; allowed: at least 1"),
        ({"reach": np.array([1.0, np.nan])}, NonFiniteError, "of task 'reach' is nan"),
        ({"reach": np.array([np.inf])}, NonFiniteError, "of task 'reach' is inf"),
        ({"reach": np.ones((2, 2))}, ShapeError, r"of task 'reach' has shape \(2, 2\)"),
    ],
)
def test_wrong_runs_are_refused(scores: dict[str, Array], kind: type[PRPError], message: str) -> None:
    right = {"reach": np.ones(2)}
    with pytest.raises(kind, match=message):
        performance_profile(scores, np.zeros(1), generator())
    for compare in COMPARISONS:
        for x, y in ((scores, right), (right, scores)):
            with pytest.raises(kind, match=message):
                compare(x, y, generator())


@pytest.mark.parametrize("compare", COMPARISONS)
def test_different_tasks_are_refused(compare: Comparison) -> None:
    with pytest.raises(InvalidValueError, match=r"tasks of y is \['b'\]; allowed: the tasks of x, \['a'\]"):
        compare({"a": np.ones(2)}, {"b": np.ones(2)}, generator())
    for x, y in (("ab", "a"), ("a", "ab")):
        with pytest.raises(InvalidValueError, match="tasks of y"):
            compare(dict.fromkeys(x, np.ones(2)), dict.fromkeys(y, np.ones(2)), generator())


def test_runs_without_partner_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"y of task 'a' has shape \(1,\); expected \(2,\), as x"):
        paired_probability_of_improvement({"a": np.ones(2)}, {"a": np.ones(1)}, generator())


def test_wrong_thresholds_and_confidences_are_refused() -> None:
    scores = spread()
    with pytest.raises(InvalidValueError, match="number of thresholds is 0"):
        performance_profile(scores, np.array([]), generator())
    with pytest.raises(NonFiniteError, match="one of the thresholds is nan"):
        performance_profile(scores, np.array([np.nan]), generator())
    for confidence in (0.0, 1.0, float("nan")):
        with pytest.raises(InvalidValueError, match="confidence"):
            performance_profile(scores, np.zeros(1), generator(), confidence)
        for compare in COMPARISONS:
            with pytest.raises(InvalidValueError, match="confidence"):
                compare(scores, scores, generator(), confidence)
    for compare in COMPARISONS:
        with pytest.raises(InvalidValueError, match="number of resamples is 0; allowed: a whole number"):
            compare(scores, scores, generator(), resamples=0)
