"""Conversion of keywords and reset options to numbers: other values are refused by name and unit."""

from typing import Any

import numpy as np
import pytest

from prp_gym.checks import as_numbers, shaped, within
from prp_gym.errors import InvalidValueError, ShapeError

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
