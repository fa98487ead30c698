"""Conversion of keywords and reset options to numbers: other values are refused by name and unit."""

from typing import Any

import numpy as np
import pytest

from prp_gym.checks import (
    LARGEST,
    as_numbers,
    check_finite,
    choice,
    components,
    finite,
    flag,
    random_generator,
    random_seed,
    shaped,
    text,
    whole,
    within,
)
from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError, UnknownNameError

NAN, INFINITY = float("nan"), float("inf")
NO_NUMBERS: dict[str, Any] = {
    "text": "fast",
    "text of a number": "2.5",
    "bytes": b"2",
    "truth value": True,
    "truth value of numpy": np.True_,
    "truth values": [True, False],
    "texts among numbers": [1.0, "2"],
    "complex": 1 + 2j,
    "nothing": None,
    "nothing among numbers": [1.0, None],
    "mapping": {"value": 1.0},
    "set": {1.0},
    "object": object(),
    "rows of different lengths": [[1.0], [1.0, 2.0]],
    "date": np.datetime64("2020-01-01"),
}


@pytest.mark.parametrize("value", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_what_is_no_number_is_refused_by_name_value_and_unit(value: Any) -> None:
    for convert in (
        lambda: as_numbers("speed", value, "m/s"),
        lambda: shaped("speed", value, (), "m/s"),
        lambda: within("speed", value, (0.0, 1.0), "m/s"),
    ):
        with pytest.raises(
            InvalidValueError, match=r"speed is .* m/s; allowed: a number or numbers\."
        ) as caught:
            convert()
        assert caught.value.value is value
        assert caught.value.unit == "m/s"


@pytest.mark.parametrize(
    "value", [3, 3.0, np.float32(3), np.int8(3), np.uint64(3), np.array(3), np.array(3, dtype=np.float16)]
)
def test_any_kind_of_number_becomes_the_same(value: Any) -> None:
    numbers = as_numbers("speed", value)
    assert numbers.dtype == np.float64
    assert numbers.shape == ()
    assert numbers == 3.0
    assert within("speed", value, (3.0, 3.0), "") == 3.0
    assert type(within("speed", value, (0.0, 5.0), "")) is float


def test_numbers_keep_their_shape_and_not_their_memory() -> None:
    given = np.array([[1, 2, 3], [4, 5, 6]])
    for value in (given, given.tolist(), tuple(map(tuple, given.tolist()))):
        found = shaped("table", value, (2, 3))
        np.testing.assert_array_equal(found, given)
        assert found.dtype == np.float64
    own = np.array([1.0, 2.0])
    as_numbers("copy", own)[:] = 7.0
    np.testing.assert_array_equal(own, [1.0, 2.0])


@pytest.mark.parametrize("value", [1.0, [1.0, 2.0], [[1.0, 2.0, 3.0]], [], np.zeros((3, 1))])
def test_other_shape_is_refused_with_the_expected_one(value: Any) -> None:
    with pytest.raises(ShapeError, match=r"normal has shape \(.*\); expected \(3,\)"):
        shaped("normal", value, (3,))


@pytest.mark.parametrize("value", [[0.5], [0.5, 0.5], np.zeros((1, 1)), []])
def test_bounded_value_is_one_number(value: Any) -> None:
    with pytest.raises(ShapeError, match=r"share has shape \(.*\); expected \(\)"):
        within("share", value, (0.0, 1.0), "")


def test_bounds_belong_to_what_is_allowed_and_are_named_where_they_are_passed() -> None:
    bounds = (-0.25, 1e5)
    for value in (-0.25, 0, 1e5):
        assert within("force", value, bounds, "N") == value
    for value in (np.nextafter(-0.25, -1.0), np.nextafter(1e5, 1e6), NAN, INFINITY, -INFINITY):
        with pytest.raises(InvalidValueError, match=r"force is .* N; allowed: -0\.25 to 100000\.") as caught:
            within("force", value, bounds, "N")
        assert caught.value.allowed == "-0.25 to 100000"


@pytest.mark.parametrize("shape", [(), (3,), (1, 3), (40,), (2, 40)])
@pytest.mark.parametrize("bad", [NAN, INFINITY, -INFINITY, 1e308, -2 * LARGEST])
def test_number_that_cannot_be_computed_with_is_refused_wherever_it_stands(
    shape: tuple[int, ...], bad: float
) -> None:
    numbers = np.full(shape, LARGEST / 100)
    check_finite("speed", numbers)
    numbers.flat[numbers.size // 2] = bad
    with pytest.raises(InvalidValueError if np.isfinite(bad) else NonFiniteError, match="speed is"):
        finite("speed", numbers)


@pytest.mark.parametrize("value", [10**400, np.longdouble("1e4000"), [10**400, 1.0]])
def test_number_beyond_float64_is_refused(value: Any) -> None:
    with pytest.raises((InvalidValueError, NonFiniteError)):
        finite("speed", value)


@pytest.mark.parametrize(
    "value", [None, 1, b"a", ["a"], np.array("a"), np.array(["a", "b"]), {}, "c", object()]
)
def test_word_that_is_none_of_the_choices_is_refused(value: Any) -> None:
    with pytest.raises(UnknownNameError, match=r"unknown mode .* Valid: a, b\."):
        choice("mode", value, ("a", "b"))
    assert choice("mode", np.str_("a"), ("a", "b")) == "a"


@pytest.mark.parametrize("value", [-1, 11, 2.0, True, np.timedelta64(3), "3", None, 10**400, np.array(3)])
def test_whole_number_out_of_bounds_or_of_another_kind_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValueError, match="a whole number, at least 0, at most 10"):
        whole("count", value, 0, 10)
    assert [whole("count", number, 0, 10) for number in (0, np.int8(3), 10)] == [0, 3, 10]


def test_seed_has_at_most_128_bits_as_those_of_numpy() -> None:
    entropy = np.random.SeedSequence().entropy
    assert random_seed("seed", entropy) == entropy
    for value in (2**128, -1, 1.0, True, None, [1]):
        with pytest.raises(InvalidValueError, match="seed is"):
            random_seed("seed", value)


def test_flags_texts_generators_and_components_are_of_their_kind() -> None:
    assert flag("wanted", np.True_) is True
    assert text("name", "a") == "a"
    assert components("mass", [1, 2, 3], 3, (0.0, 3.0), "kg") == (1.0, 2.0, 3.0)
    refused: list[Any] = [
        lambda: flag("wanted", 1),
        lambda: text("name", ""),
        lambda: random_generator("rng", 0),
        lambda: components("mass", [1, 2], 3, (0.0, 3.0), "kg"),
        lambda: components("mass", [1, 2, 4], 3, (0.0, 3.0), "kg"),
    ]
    for call in refused:
        with pytest.raises(InvalidValueError):
            call()
