"""Rank correlation against values computed by hand, and audits of made-up policies."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.comparison.audit import (
    LEAST_CORRELATION,
    Audit,
    Finding,
    audit_rewards,
    criterion_values,
)
from prp_gym.comparison.rank import (
    average_ranks,
    concordance,
    distinguished,
    rank_correlation,
    resampled_concordances,
)
from prp_gym.comparison.values import Entry, group_conditions
from prp_gym.errors import ShapeError
from prp_gym.tasks.spec import Criterion
from tests.support.synthetic_comparison import record

ROUNDING = 1e-12  # a few additions of small numbers


def test_ties_share_the_mean_of_their_ranks() -> None:
    values = np.array([3.0, 1.0, 3.0, np.inf, 2.0, np.inf, 3.0])
    # sorted: 1 2 3 3 3 inf inf on ranks 0 1 (2 3 4) (5 6)
    np.testing.assert_array_equal(average_ranks(values), [3.0, 0.0, 3.0, 5.5, 1.0, 5.5, 3.0])


def test_rank_correlation_with_ties_is_that_computed_by_hand() -> None:
    # ranks of x less their mean: -1.5 0 0 1.5; of y: -1.5 -0.5 0.5 1.5; products 4.5, squares 4.5 and 5
    found = rank_correlation(np.array([1.0, 2.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0, 9.0]))
    assert found == pytest.approx(4.5 / np.sqrt(4.5 * 5.0), abs=ROUNDING)


def test_rank_correlation_without_ties_is_the_formula_of_squared_differences() -> None:
    x, y = np.array([106.0, 100.0, 86.0, 101.0, 99.0]), np.array([7.0, 27.0, 2.0, 50.0, 28.0])
    # ranks of x: 4 2 0 3 1, of y: 1 2 0 4 3; squared differences 9 + 0 + 0 + 1 + 4 = 14
    assert rank_correlation(x, y) == pytest.approx(1.0 - 6.0 * 14.0 / (5.0 * 24.0), abs=ROUNDING)


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=20, unique=True))
def test_rank_correlation_of_a_monotonic_change_is_one(values: list[float]) -> None:
    x = np.array(values)
    order = np.argsort(np.argsort(x)).astype(np.float64)
    assert rank_correlation(x, order**3) == pytest.approx(1.0, abs=ROUNDING)
    assert rank_correlation(x, -order) == pytest.approx(-1.0, abs=ROUNDING)


def test_rank_correlation_with_a_constant_is_undefined() -> None:
    assert np.isnan(rank_correlation(np.ones(4), np.arange(4.0)))


def test_rank_correlation_of_different_lengths_is_refused() -> None:
    with pytest.raises(ShapeError, match="y has shape"):
        rank_correlation(np.ones(4), np.ones(3))


def test_concordance_is_that_over_every_two_values_that_both_distinguish() -> None:
    # of six cases of two x leaves one undecided and y another one; three agree, one does not
    found = concordance(np.array([1.0, 2.0, 2.0, 4.0]), np.array([0.0, 3.0, 0.0, 1.0]))
    assert found == pytest.approx((3 - 1) / (3 + 1))
    assert np.isnan(concordance(np.ones(3), np.arange(3.0)))
    with pytest.raises(ShapeError, match="y has shape"):
        concordance(np.ones(4), np.ones(3))


def test_resample_without_a_correlation_is_left_out() -> None:
    x = np.array([[1.0, 2.0, 3.0], [5.0, 5.0, 5.0], [1.0, 2.0, 3.0]])
    y = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])
    np.testing.assert_allclose(resampled_concordances(x, y), [1.0, -1.0], atol=ROUNDING)


def test_cases_that_do_not_count_are_left_out_of_the_concordance() -> None:
    x, y = np.arange(4.0), np.array([0.0, 2.0, 1.0, 3.0])
    counted = ~np.eye(4, dtype=bool)
    assert concordance(x, y, counted) == pytest.approx((5 - 1) / 6)
    counted[1, 2] = counted[2, 1] = False  # the only case that is ranked oppositely
    assert concordance(x, y, counted) == pytest.approx(1.0)
    assert resampled_concordances(x[None], y[None], counted) == pytest.approx([1.0])


def test_values_are_distinguished_by_the_standard_error_of_their_difference_sample_by_sample() -> None:
    common = np.array([0.0, 10.0, 20.0, 30.0])  # of all rows, much larger than what sets them apart
    first, second = common, common + np.array([1.0, 2.0, 1.0, 2.0])
    # mean difference 1.5, variance (0.25 * 4)/3, standard error √(1/12) = 0.289: 5.2 standard errors
    third = common + np.array([3.0, -2.0, 0.0, 0.0])  # 0.25 with a standard error of 1.03
    found = distinguished(np.stack([first, second, third]), 2.0)
    np.testing.assert_array_equal(found, [[0, 1, 0], [1, 0, 0], [0, 0, 0]])
    assert distinguished(np.stack([first, second]), 5.1)[0, 1]
    assert not distinguished(np.stack([first, second]), 5.3)[0, 1]


def test_undefined_samples_are_left_out_and_single_ones_differ_if_they_are_unequal() -> None:
    values = np.array([[1.0, np.nan], [2.0, 5.0], [np.nan, np.nan], [1.0, 7.0]])
    found = distinguished(values, 2.0)
    np.testing.assert_array_equal(found[0], [0, 1, 0, 0])
    assert not found[2].any()


def policy(
    name: str, score: float, settling: float, unsettled: float = 0.0, **metrics: float
) -> dict[str, Any]:
    """The record of a policy with the same result in each of three episodes."""
    made = record(name, [score] * 3)
    values = {"response_settling_time": settling, "unsettled": unsettled, "overshoot": 1.0, **metrics}
    values |= {"excess_energy": 1.0, "energy": 1.0}
    return {**made, "episodes": {**made["episodes"], **{key: [[value]] * 3 for key, value in values.items()}}}


def audited(*records: dict[str, Any]) -> Audit:
    (audit,) = audit_rewards(group_conditions(records), 0)
    return audit


def finding(audit: Audit, metric: str) -> Finding:
    return next(item for item in audit.findings if item.metric == metric)


def test_criterion_of_an_episode_that_does_not_settle_is_the_worst_and_no_value_is_beyond() -> None:
    plain = policy("joint_pd", 0.5, 1.0)
    plain["episodes"]["overshoot"] = [[3.0], [250.0], [None]]
    plain["episodes"]["unsettled"] = [[100.0], [0.0], [100.0]]
    found = criterion_values(Entry.of([plain]), Criterion("overshoot", 100.0))
    np.testing.assert_array_equal(found, [[100.0, 100.0, np.nan]])


def test_score_that_ranks_policies_as_a_criterion_does_correlates_fully() -> None:
    ranked = [policy(f"policy {i}", 1.0 - i / 50, 0.1 * i) for i in range(40)]
    audit = audited(*ranked)
    assert finding(audit, "response_settling_time").correlation.value == pytest.approx(1.0)
    assert finding(audit, "response_settling_time").holds
    assert not audited(*ranked[:39]).holds  # too few policies


def test_score_against_a_criterion_fails_and_names_the_bad_policies_among_the_best() -> None:
    ranked = [policy(f"policy {i}", 1.0 - i / 50, 0.1 * i) for i in range(40)]
    ranked[1] = policy("deceiver", 0.98, 1.0, unsettled=100.0)
    found = finding(audited(*ranked), "response_settling_time")
    assert found.correlation.value > LEAST_CORRELATION
    assert found.offenders == ("deceiver",)
    assert not found.holds
    reversed_order = [policy(f"policy {i}", i / 50, 0.1 * i) for i in range(40)]
    assert finding(audited(*reversed_order), "response_settling_time").correlation.value == pytest.approx(
        -1.0
    )
    assert not audited(*reversed_order).holds


def test_differences_that_chance_may_have_made_do_not_count_against_the_score() -> None:
    ranked = [policy(f"policy {i}", 1.0 - i / 50, 0.1 * i) for i in range(40)]
    for index in (10, 11):  # in one episode of three the lower score is far better by the criterion
        ranked[index]["episodes"]["response_settling_time"] = [[1.0], [1.0], [2.0 - 5.0 * (index - 10) / 4]]
    found = finding(audited(*ranked), "response_settling_time")
    assert found.correlation.value == pytest.approx(1.0)
    assert found.unfiltered < 1.0
    assert found.counted < 1.0


def test_energy_is_reported_and_fails_nothing() -> None:
    ranked = [policy(f"policy {i}", 1.0 - i / 50, 0.1 * i, energy=40.0 - i) for i in range(40)]
    found = finding(audited(*ranked), "energy")
    assert not found.required
    assert found.holds
