"""The intervals of a plan and its shift by a control period."""

import numpy as np
import pytest

from prp_gym.baselines.predictive.formulas import KNOTS
from prp_gym.baselines.predictive.grid import interval_durations, shifted


@pytest.mark.parametrize(("period", "horizon"), [(0.002, 0.2), (0.002, 1.0), (0.02, 0.5), (0.001, 0.017)])
def test_intervals_begin_with_the_period_and_end_with_the_horizon(period: float, horizon: float) -> None:
    duration = interval_durations(period, horizon)
    assert duration.shape == (KNOTS, 1)
    assert duration[0, 0] == period
    assert duration.sum() == pytest.approx(horizon, rel=1e-12)  # of 60 bisections
    ratio = duration[1:] / duration[:-1]
    assert (ratio >= 1.0).all()
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-14)


@pytest.mark.parametrize("horizon", [0.0, 0.001, KNOTS * 0.002])
def test_a_plan_lasts_at_least_as_many_periods_as_it_has_intervals(horizon: float) -> None:
    np.testing.assert_allclose(interval_durations(0.002, horizon), 0.002, rtol=1e-12)


def test_shifted_plan_has_the_means_of_what_it_covers() -> None:
    period, fine = 0.002, 2000
    duration = interval_durations(period, 0.25)
    plan = np.random.default_rng(1).normal(size=(2, KNOTS, 3))
    ends = np.cumsum(duration[:, 0])

    def value(time: float) -> np.ndarray:
        return plan[:, min(int(np.searchsorted(ends, time)), KNOTS - 1)]

    found = shifted(plan, duration)
    for k in range(KNOTS):
        begin = ends[k] - duration[k, 0] + period
        times = begin + duration[k, 0] * (np.arange(fine) + 0.5) / fine
        expected = np.mean([value(time) for time in times], axis=0)
        # of 2000 samples one may fall on the wrong side of a change of up to 6
        np.testing.assert_allclose(found[:, k], expected, atol=6.0 / fine)


def test_constant_plan_stays() -> None:
    duration = interval_durations(0.002, 0.3)
    plan = np.full((1, KNOTS, 3), 0.7)
    np.testing.assert_allclose(shifted(plan, duration), plan, rtol=1e-15)
