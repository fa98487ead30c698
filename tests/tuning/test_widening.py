"""Ranges that grow where the best candidate lies at their edge, but not beyond a declared limit."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from prp_gym.tuning import Parameter, Ranges, StoredStudy, Trial, ranges_after
from prp_gym.tuning.widening import MOST_WIDENINGS, NO_LIMIT, widest
from tests.tuning.test_journal import PlainSpace

GAIN = Parameter("gain", 0.1, 10.0, {"gain": 1.0}, ...)
RATIO = Parameter("ratio", 0.5, 2.0, {"ratio": 1.0}, ...)
LIMITED = replace(GAIN, limits=("", "a rate above that of the sampling"))


def trial(gain: float, score: float, stopped: bool = False) -> Trial:
    return Trial({"gain": gain, "ratio": 1.0}, score, 1, 0.0, (score,), stopped)


def after(*trials: Trial, gain: Parameter = GAIN) -> Ranges:
    return ranges_after((gain, RATIO), trials)


def bounds(ranges: Ranges) -> tuple[float, float]:
    return ranges.parameters[0].low, ranges.parameters[0].high


@pytest.mark.parametrize(
    ("gain", "expected", "edge"),
    [
        (1.0, (0.1, 10.0), None),
        (7.9, (0.1, 10.0), None),  # 94.9 % of two decades
        (8.0, (0.1, 100.0), "gain, high"),
        (10.0, (0.1, 100.0), "gain, high"),
        (0.12, (0.01, 10.0), "gain, low"),
        (0.13, (0.1, 10.0), None),
    ],
)
def test_end_at_which_the_best_candidate_lies_moves_by_half_of_the_range(
    gain: float, expected: tuple[float, float], edge: str | None
) -> None:
    found = after(trial(1.0, 0.1), trial(gain, 0.5))
    assert bounds(found) == pytest.approx(expected)
    assert found.edges == ({} if edge is None else {edge: NO_LIMIT})
    assert found.is_open == (edge is not None)
    assert found.parameters[1] == RATIO


def test_candidate_that_is_not_the_best_or_was_stopped_moves_nothing() -> None:
    assert bounds(after(trial(1.0, 0.5), trial(10.0, 0.4))) == (0.1, 10.0)
    assert bounds(after(trial(1.0, 0.5), trial(10.0, 0.9, stopped=True))) == (0.1, 10.0)


def test_declared_limit_stays_and_its_reason_is_told() -> None:
    found = after(trial(10.0, 0.5), gain=LIMITED)
    assert bounds(found) == (0.1, 10.0)
    assert found.edges == {"gain, high": "a rate above that of the sampling"}
    assert not found.is_open
    assert bounds(after(trial(0.1, 0.5), gain=LIMITED)) == pytest.approx((0.01, 10.0))  # the other end


def test_edge_of_a_range_that_has_grown_is_another_one() -> None:
    found = after(trial(10.0, 0.5), trial(100.0, 0.6), trial(20.0, 0.7))
    assert bounds(found) == pytest.approx((0.1, 1000.0))
    assert found.edges == {}


def test_edge_counts_until_the_wider_range_has_been_searched() -> None:
    worse = [trial(20.0, 0.1)] * 3
    assert after(trial(10.0, 0.5), *worse).is_open
    assert not after(trial(10.0, 0.5), *worse, trial(30.0, 0.2)).is_open  # twice the two parameters


def test_range_stops_growing_and_then_its_edge_stays_one() -> None:
    trials = [trial(10.0 ** (1 + count), 0.1 * (count + 1)) for count in range(MOST_WIDENINGS + 1)]
    found = after(*trials, *[trial(1.0, 0.0)] * 50)
    assert bounds(found) == pytest.approx((0.1, 10.0 ** (1 + MOST_WIDENINGS)))
    assert found.edges == {"gain, high": NO_LIMIT}
    assert widest(GAIN) == pytest.approx((10.0 ** -(1 + MOST_WIDENINGS), 10.0 ** (1 + MOST_WIDENINGS)))


def test_search_finds_an_optimum_outside_the_declared_range(tmp_path: Path) -> None:
    """The best factors, 30 and 1, are beyond the declared range 0.1 to 10 of the first."""
    study = StoredStudy(tmp_path, PlainSpace(), {}, 0, False)
    for _ in range(30):
        for factors in study.propose():
            score = math.exp(-(math.log(factors["first"] / 30.0) ** 2) - math.log(factors["second"]) ** 2)
            study.record(Trial(factors, score, 1, 0.0, (score,)))
    best = max(study.trials, key=lambda trial: trial.score)
    assert best.factors["first"] == pytest.approx(30.0, rel=0.3)
    assert StoredStudy(tmp_path, PlainSpace(), {}, 0, True).trials == study.trials
