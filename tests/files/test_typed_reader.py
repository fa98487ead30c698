"""Plain values as dataclasses: every key and type is checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from prp_gym.errors import DataFileError, InvalidValueError
from prp_gym.files.typed_reader import TypedReader


@dataclass(frozen=True)
class Point:
    size: int
    weight: float = 1.0

    def __post_init__(self) -> None:
        if self.size < 1:
            raise InvalidValueError("size", self.size, "at least 1")


@dataclass(frozen=True)
class Whole:
    name: str
    point: Point
    rows: tuple[tuple[int, float], ...]
    values: Mapping[str, float] = field(default_factory=dict)
    choice: str | int | None = None
    loose: Any = None


GOOD: dict[str, Any] = {"name": "a", "point": {"size": 2}, "rows": [[1, 2], [3, 4.5]]}


def read(plain: Any) -> Whole:
    return TypedReader(Path("file.json")).read(Whole, plain, "")


def test_values_have_their_types_and_missing_ones_their_defaults() -> None:
    whole = read({**GOOD, "values": {"x": 1}, "choice": 3, "loose": [None]})
    assert whole == Whole("a", Point(2), ((1, 2.0), (3, 4.5)), {"x": 1.0}, 3, [None])
    assert type(whole.rows[0][1]) is float
    assert read(GOOD) == Whole("a", Point(2), ((1, 2.0), (3, 4.5)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": 1}, "key 'name' is 1; expected text"),
        ({"point": {"size": True}}, "key 'point.size' is True; expected a whole number"),
        ({"point": {"size": 1.0}}, r"key 'point.size' is 1\.0; expected a whole number"),
        ({"point": {}}, "key 'point.size' is missing"),
        ({"point": {"size": 0}}, "key 'point': size is 0; allowed: at least 1"),
        ({"point": {"size": 1, "sise": 2}}, "key 'point.sise' is unknown; did you mean 'size'"),
        ({"point": []}, r"key 'point' is \[\]; expected an object"),
        ({"rows": [[1]]}, r"key 'rows\[0\]' is \[1\]; expected a list of 2 values"),
        ({"rows": {"a": 1}}, "expected a list"),
        ({"rows": [[1, "2"]]}, r"key 'rows\[0\]\[1\]' is '2'; expected a number"),
        ({"values": {"x": None}}, "key 'values.x' is None; expected a number"),
        ({"choice": 1.5}, "key 'choice' is 1.5"),
        ({"x" * 1000: 1}, "is unknown; allowed: choice, loose"),
        ({"name": ["x" * 10_000]}, r"\.\.\..*; expected text"),
    ],
)
def test_key_or_value_of_another_kind_is_refused_with_its_position(
    change: dict[str, Any], message: str
) -> None:
    with pytest.raises(DataFileError, match=message) as caught:
        read({**GOOD, **change})
    assert str(caught.value).startswith("file 'file.json': ")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("plain", [None, [], 3, "x"])
def test_content_that_is_no_object_is_refused(plain: Any) -> None:
    with pytest.raises(DataFileError, match=r"the content is .*; expected an object"):
        read(plain)
