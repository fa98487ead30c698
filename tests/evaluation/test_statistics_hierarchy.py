"""Bootstraps over training seeds and episodes."""

from collections.abc import Callable

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, NonFiniteError, PRPError, ShapeError
from prp_gym.evaluation import (
    Estimate,
    bootstrap_crossed,
    bootstrap_difference,
    bootstrap_interquartile_mean,
    bootstrap_nested,
    interquartile_mean,
)
from prp_gym.robot.arrays import Array

Bootstrap = Callable[..., Estimate]
SINGLE = [bootstrap_nested, bootstrap_crossed]
ROUNDING = 1e-12  # sums of at most a thousand numbers of size 1
MANY = 20000  # resamples: a share of them is known to 0.4 %


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def made_scores(rng: np.random.Generator, agents: int, columns: int, deviations: Array) -> Array:
    """Scores with mean 0 and deviations of agents, of evaluation seeds common to all, and of the rest."""
    agent, common, rest = deviations
    return np.asarray(
        agent * rng.normal(size=(agents, 1))
        + common * rng.normal(size=(1, columns))
        + rest * rng.normal(size=(agents, columns))
    )


def coverage(bootstrap: Bootstrap, agents: int, columns: int, deviations: tuple[float, ...]) -> float:
    rng = generator(7)
    covered = []
    for _ in range(300):
        scores = made_scores(rng, agents, columns, np.array(deviations))
        estimate = bootstrap(scores, rng, resamples=300)
        covered.append(estimate.low <= 0.0 <= estimate.high)
    return float(np.mean(covered))


@pytest.mark.parametrize("bootstrap", SINGLE)
def test_estimate_is_the_interquartile_mean_of_all_scores(bootstrap: Bootstrap) -> None:
    scores = generator(1).normal(size=(3, 7))
    estimate = bootstrap(scores, generator())
    assert estimate.value == interquartile_mean(scores.ravel())
    assert estimate.low < estimate.value < estimate.high


@pytest.mark.parametrize("bootstrap", SINGLE)
def test_one_training_seed_leaves_a_bootstrap_over_episodes(bootstrap: Bootstrap) -> None:
    scores = generator(2).normal(size=25)
    found = bootstrap(scores[None], generator(1), resamples=MANY)
    expected = bootstrap_interquartile_mean(scores, generator(2), resamples=MANY)
    assert found.value == expected.value
    # ends of an interval 0.9 wide, from 20000 resamples each: a deviation of 0.005 each
    assert found == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize("bootstrap", SINGLE)
def test_training_seeds_are_drawn_as_a_whole(bootstrap: Bootstrap) -> None:
    # two agents without spread of their own: means 0, ½, 1 with ¼, ½, ¼, however many episodes there are
    for columns in (1, 6):
        scores = np.repeat([[0.0], [1.0]], columns, axis=1)
        assert bootstrap(scores, generator(), confidence=0.6) == Estimate(0.5, 0.0, 1.0)
        assert bootstrap(scores, generator(), confidence=0.4) == Estimate(0.5, 0.5, 0.5)


def test_episodes_are_common_to_training_seeds_where_crossed_and_their_own_where_nested() -> None:
    # two equal agents with episodes 0 and 1: crossed, two flips decide, so that 0, ½, 1 have ¼, ½, ¼;
    # nested, four flips do, of which the middle two count: 5/16, 6/16, 5/16
    scores = np.array([[0.0, 1.0], [0.0, 1.0]])
    between = 1.0 - 2 * 0.30  # tails of 0.30, between 1/4 and 5/16, each 3 deviations of 20000 away or more
    assert bootstrap_crossed(scores, generator(), between, MANY) == Estimate(0.5, 0.5, 0.5)
    assert bootstrap_nested(scores, generator(), between, MANY) == Estimate(0.5, 0.0, 1.0)
    assert bootstrap_crossed(scores, generator(), 0.6, MANY) == Estimate(0.5, 0.0, 1.0)
    assert bootstrap_nested(scores, generator(), 0.3, MANY) == Estimate(0.5, 0.5, 0.5)


# With 20 agents as with 20 numbers, 1.96 deviations estimated from them cover 93.5 %; 300 trials have a
# deviation of 1.4 %; three of these.
EXPECTED, TOLERANCE = 0.935, 0.042


def test_nested_interval_covers_the_true_value_about_as_often_as_it_says() -> None:
    assert coverage(bootstrap_nested, 20, 20, (1.0, 0.0, 1.0)) == pytest.approx(EXPECTED, abs=TOLERANCE)


def test_few_training_seeds_are_covered_less_often_than_the_interval_says() -> None:
    # the deviation of 3 agents lacks √(2/3) and has 2 degrees of freedom: with u = 1.96 √(2/3), Student's t
    # is within ±u in u / √(2 + u²) = 75 %; 300 trials have a deviation of 2.5 %, three of these
    u = 1.96 * np.sqrt(2 / 3)
    expected = u / np.sqrt(2 + u**2)
    for bootstrap in SINGLE:
        assert coverage(bootstrap, 3, 50, (1.0, 0.0, 0.1)) == pytest.approx(expected, abs=0.075)


def test_crossed_interval_covers_the_true_value_where_evaluation_seeds_are_common() -> None:
    deviations = (0.5, 1.0, 0.3)
    assert coverage(bootstrap_crossed, 20, 20, deviations) == pytest.approx(EXPECTED, abs=TOLERANCE)
    # the nested one takes 400 episodes for as many evaluation seeds: half the deviation is missing
    assert coverage(bootstrap_nested, 20, 20, deviations) < 0.8


def test_episodes_alone_do_not_cover_the_spread_of_training() -> None:
    def pooled(scores: Array, rng: np.random.Generator, resamples: int) -> Estimate:
        return bootstrap_interquartile_mean(scores.ravel(), rng, resamples=resamples)

    assert coverage(pooled, 20, 20, (1.0, 0.0, 1.0)) < 0.6  # a third of the deviation


def test_difference_covers_the_true_value_about_as_often_as_it_says() -> None:
    rng = generator(8)
    covered = []
    for _ in range(300):
        common = 3.0 * rng.normal(size=40)
        x = made_scores(rng, 20, 40, np.array([0.5, 0.0, 0.3])) + common
        y = 0.7 + common + rng.normal(size=(1, 40))  # a controller: one row
        estimate = bootstrap_difference(x, y, rng, resamples=300)
        covered.append(estimate.low <= -0.7 <= estimate.high)
    # the interquartile means of the two cut off slightly different tails of the common part, and percentile
    # intervals of 20 and 40 are 1 to 2 % too narrow; 300 trials have a deviation of 1.4 %
    assert np.mean(covered) == pytest.approx(0.94, abs=0.05)


def test_what_evaluation_seeds_do_to_both_drops_out_of_the_difference() -> None:
    common = generator(3).normal(size=30)
    estimate = bootstrap_difference(common[None] + 0.25, common[None], generator())
    assert estimate == pytest.approx(Estimate(0.25, 0.25, 0.25), abs=ROUNDING)
    # without the pairing it does not
    other = generator(4).permutation(common)
    estimate = bootstrap_difference(common[None] + 0.25, other[None], generator())
    assert estimate.value == pytest.approx(0.25, abs=ROUNDING)
    assert estimate.high - estimate.low > 0.5


def test_training_seeds_of_two_policies_are_drawn_apart() -> None:
    # each has 0, ½, 1 with ¼, ½, ¼: the difference is ±1 with 1/16, ±½ with 4/16, 0 with 6/16; drawn
    # together it would be 0
    agents = np.array([[0.0], [1.0]])
    assert bootstrap_difference(agents, agents, generator(), 0.92) == Estimate(0.0, -1.0, 1.0)
    assert bootstrap_difference(agents, agents, generator(), 0.7) == Estimate(0.0, -0.5, 0.5)
    assert bootstrap_difference(agents, agents, generator(), 0.3) == Estimate(0.0, 0.0, 0.0)


def test_difference_is_that_of_the_interquartile_means() -> None:
    x, y = generator(5).normal(size=(4, 9)), generator(6).normal(size=(2, 9))
    expected = interquartile_mean(x.ravel()) - interquartile_mean(y.ravel())
    assert bootstrap_difference(x, y, generator()).value == pytest.approx(expected, abs=ROUNDING)
    assert bootstrap_difference(y, x, generator()).value == pytest.approx(-expected, abs=ROUNDING)
    # a constant added to one moves the interval with it
    first, moved = (bootstrap_difference(shifted, y, generator(1)) for shifted in (x, x + 2.0))
    assert np.array(moved) - first == pytest.approx([2.0] * 3, abs=ROUNDING)


@pytest.mark.parametrize("bootstrap", SINGLE)
def test_estimate_moves_with_its_scores_and_not_with_their_order(bootstrap: Bootstrap) -> None:
    scores = generator(9).normal(size=(4, 11))
    first = bootstrap(scores, generator(1), resamples=MANY)
    moved = bootstrap(3.0 + 2.0 * scores, generator(1), resamples=MANY)
    assert np.array(moved) == pytest.approx(3.0 + 2.0 * np.array(first), abs=ROUNDING)
    mixed = bootstrap(scores[::-1, generator(2).permutation(11)], generator(1), resamples=MANY)
    assert mixed.value == pytest.approx(first.value, abs=ROUNDING)
    # other resamples of the same scores: ends of an interval 0.7 wide have a deviation of 0.004 each
    assert mixed == pytest.approx(first, abs=0.03)


def test_interval_depends_on_the_generator_alone() -> None:
    x, y = generator(1).normal(size=(3, 8)), generator(2).normal(size=(5, 8))
    for arguments, bootstrap in (((x,), SINGLE[0]), ((x,), SINGLE[1]), ((x, y), bootstrap_difference)):
        run: Bootstrap = bootstrap
        first, again, other = (run(*arguments, generator(seed), resamples=200) for seed in (1, 1, 2))
        assert first == again
        assert first.value == other.value
        assert first != other


@pytest.mark.parametrize(
    ("scores", "kind", "message"),
    [
        (np.ones((0, 4)), InvalidValueError, "number of scores.* is 0; allowed: at least 1"),
        (np.ones((2, 0)), InvalidValueError, "number of scores.* is 0; allowed: at least 1"),
        (np.ones(4), ShapeError, r"scores.* has shape \(4,\); expected \(training seeds, episodes\)"),
        (np.array([[1.0, np.nan]]), NonFiniteError, "one of the scores.* is nan"),
    ],
)
def test_wrong_scores_are_refused(scores: Array, kind: type[PRPError], message: str) -> None:
    for bootstrap in SINGLE:
        with pytest.raises(kind, match=message):
            bootstrap(scores, generator())
    for x, y in ((scores, np.ones((1, 2))), (np.ones((1, 2)), scores)):
        with pytest.raises(kind, match=message):
            bootstrap_difference(x, y, generator())


def test_other_evaluation_seeds_confidences_and_resamples_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"scores y has shape \(1, 3\); expected \(training seeds, 2\)"):
        bootstrap_difference(np.ones((4, 2)), np.ones((1, 3)), generator())
    for arguments, bootstrap in (((1,), SINGLE[0]), ((1,), SINGLE[1]), ((1, 1), bootstrap_difference)):
        run: Bootstrap = bootstrap
        scores = [np.ones((2, 2)) for _ in arguments]
        with pytest.raises(InvalidValueError, match="confidence is 95"):
            run(*scores, generator(), confidence=95)
        with pytest.raises(InvalidValueError, match="number of resamples is 0"):
            run(*scores, generator(), resamples=0)
