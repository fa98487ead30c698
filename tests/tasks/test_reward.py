"""The reward: closed-form values and one bounded shape."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array
from prp_gym.tasks import Reward, RewardTerm

UNITS = ("rad", "m", "rad")
TRACKING = RewardTerm("tracking", 0.75, (0.1, 0.02, 0.1), UNITS)
EFFORT = RewardTerm("effort", 0.25, (50.0, 100.0, 10.0), ("N·m", "N", "N·m"))
SHORT = RewardTerm("force", 0.25, (2.0,), ("N",))
REWARD = Reward((TRACKING, EFFORT))
SEEDS = st.integers(0, 2**32 - 1)
ROUNDING = 1e-15  # relative, of the few operations of one value


def random_errors(seed: int, *leading: int) -> Array:
    """From far below to far above the scales."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-4.0, 4.0, size=(*leading, 2, 1))
    values: Array = size * rng.normal(size=(*leading, 2, 3))
    return values


def test_term_without_error_is_its_weight() -> None:
    np.testing.assert_allclose(REWARD(np.zeros((2, 3))), [0.75, 0.25], rtol=ROUNDING)


@pytest.mark.parametrize("component", range(3))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_error_of_one_scale_in_one_component_halves_a_term(component: int, sign: float) -> None:
    errors = np.zeros((2, 3))
    errors[0, component] = sign * TRACKING.scale[component]
    np.testing.assert_allclose(REWARD(errors), [0.375, 0.25], rtol=ROUNDING)


def test_components_count_by_the_norm_of_their_scaled_errors() -> None:
    errors = np.array([[0.3, 0.08, 0.0], [0.0, 200.0, 0.0]])  # scaled (3, 4, 0) and (0, 2, 0)
    np.testing.assert_allclose(REWARD(errors), [0.75 / 6, 0.25 / 3], rtol=ROUNDING)


@given(SEEDS)
def test_contributions_are_the_formula(seed: int) -> None:
    errors = random_errors(seed)
    for term, error, value in zip(REWARD.terms, errors, REWARD(errors), strict=True):
        distance = np.linalg.norm(error / np.array(term.scale))
        assert value == pytest.approx(term.weight / (1.0 + distance), rel=ROUNDING)


@given(SEEDS)
def test_reward_lies_between_zero_and_one(seed: int) -> None:
    total = REWARD(random_errors(seed, 20)).sum(axis=-1)
    assert (total > 0.0).all()
    assert (total <= 1.0 + ROUNDING).all()


@given(SEEDS, st.floats(1.001, 1e3))
def test_larger_errors_give_smaller_rewards(seed: int, factor: float) -> None:
    errors = random_errors(seed)
    assert (REWARD(factor * errors) < REWARD(errors)).all()


@given(SEEDS)
def test_batch_equals_loop_to_the_last_bit(seed: int) -> None:
    errors = random_errors(seed, 4, 5)
    batch = REWARD(errors)
    assert batch.shape == (4, 5, 2)
    loop = [[REWARD(errors[i, j]) for j in range(5)] for i in range(4)]
    np.testing.assert_array_equal(batch, loop)


def test_components_beyond_a_short_terms_scale_do_not_count() -> None:
    reward = Reward((TRACKING, SHORT))
    errors = np.zeros((2, 3))
    errors[1] = [2.0, 1e6, -1e6]
    np.testing.assert_allclose(reward(errors)[1], 0.125, rtol=ROUNDING)


def test_term_is_read_from_its_data_table() -> None:
    table = {"weight": 1, "scale": [2, 3], "unit": ["N", "m"]}
    term = RewardTerm.from_table("pressing", table)
    assert term == RewardTerm("pressing", 1.0, (2.0, 3.0), ("N", "m"))


@pytest.mark.parametrize("weight", [0.2, 0.3, np.nan, 0.25 + 1e-6])
def test_weights_must_sum_to_one(weight: float) -> None:
    other = RewardTerm("effort", weight, (1.0,), ("N",))
    with pytest.raises(InvalidValueError, match="sum of the reward weights") as caught:
        Reward((TRACKING, other))
    assert caught.value.value == pytest.approx(0.75 + weight, nan_ok=True)
    assert caught.value.allowed == "1"


def test_weights_may_sum_to_one_up_to_rounding() -> None:
    tenths = [RewardTerm(f"term {i}", 0.1, (1.0,), ("m",)) for i in range(10)]
    # ten times 0.1 need not add up to 1 exactly; ten roundings
    assert Reward(tenths)(np.zeros((10, 1))).sum() == pytest.approx(1.0, rel=1e-14)


def test_reward_without_terms_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="sum of the reward weights"):
        Reward(())


@pytest.mark.parametrize("scale", [0.0, -0.1, np.nan])
def test_scales_must_be_positive(scale: float) -> None:
    with pytest.raises(InvalidValueError, match="scale of reward term 'tilt'") as caught:
        Reward((RewardTerm("tilt", 1.0, (0.1, scale), ("rad", "rad")),))
    assert caught.value.allowed == "above 0"
