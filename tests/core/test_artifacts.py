"""Files: strict JSON, complete, never half written, and read back as they were."""

import json
import math
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.artifacts import prepare_folder, read_json, to_array, to_plain, write_json
from prp_gym.errors import InvalidValueError, OutputError

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
NUMBERS = st.floats() | st.integers() | st.booleans() | st.none() | st.text(max_size=5)
NESTED = st.recursive(
    NUMBERS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
)


@dataclass(frozen=True)
class Inner:
    gain: Any
    limits: tuple[float, float] = (0.0, math.inf)


@dataclass(frozen=True)
class Outer:
    name: str
    inner: Inner


def strict(text: str) -> Any:
    """The content of a JSON text that uses nothing beyond the standard."""

    def refuse(constant: str) -> Any:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (math.nan, None),
        (math.inf, "inf"),
        (-math.inf, "-inf"),
        (np.float64("nan"), None),
        (np.float32("-inf"), "-inf"),
        (np.array([1.0, math.nan, math.inf]), [1.0, None, "inf"]),
        (np.array(2.5), 2.5),
        (np.zeros((2, 0)), [[], []]),
        (np.array([[1, 2], [3, 4]]), [[1, 2], [3, 4]]),
        ((1, (2.0, "a")), [1, [2.0, "a"]]),
        ("text", "text"),
        ({1: "a", "b": (math.nan,)}, {"1": "a", "b": [None]}),
        (Inner(np.array([1.0, 2.0])), {"gain": [1.0, 2.0], "limits": [0.0, "inf"]}),
        (
            [Outer("x", Inner(math.nan))],
            [{"name": "x", "inner": {"gain": None, "limits": [0.0, "inf"]}}],
        ),
    ],
)
def test_values_become_what_json_knows(value: Any, expected: Any) -> None:
    assert to_plain(value) == expected


@pytest.mark.parametrize(
    ("value", "kind"), [(np.float32(0.5), float), (np.int64(3), int), (np.bool_(True), bool)]
)
def test_numpy_scalars_become_python_s(value: Any, kind: type) -> None:
    assert type(to_plain(value)) is kind
    assert to_plain(value) == value


@PROPERTY
@given(value=NESTED)
def test_plain_values_survive_strict_json(value: Any) -> None:
    plain = to_plain(value)
    assert strict(json.dumps(plain, allow_nan=False)) == plain
    assert to_plain(plain) == plain


@pytest.mark.parametrize(
    "values",
    [
        np.array([1.5, math.nan, math.inf, -math.inf, -0.0, 5e-324, 1 / 3]),
        np.array([[0.1, math.nan], [math.inf, 2.0]]),
        np.full((2, 1), math.nan),
        np.zeros(0),
    ],
)
def test_numbers_read_back_are_those_written(values: Any) -> None:
    back = to_array(strict(json.dumps(to_plain(values), allow_nan=False)))
    assert back.dtype == values.dtype
    assert back.tobytes() == values.tobytes()  # to the last bit, signs of zero included


def test_file_holds_the_content(tmp_path: Path) -> None:
    target = tmp_path / "new" / "folder" / "results.json"
    write_json(target, {"units": ("N·m", "N"), "settles": np.array([0.5, math.inf, math.nan])})
    text = target.read_text(encoding="utf-8")
    assert strict(text) == {"units": ["N·m", "N"], "settles": [0.5, "inf", None]}
    assert "N·m" in text
    assert text.endswith("}\n")
    assert [entry.name for entry in target.parent.iterdir()] == ["results.json"]
    assert stat.S_IMODE(target.stat().st_mode) == 0o644


def test_file_is_replaced(tmp_path: Path) -> None:
    target = tmp_path / "results.json"
    write_json(target, {"first": [1] * 100})
    write_json(target, {"second": 2})
    assert strict(target.read_text(encoding="utf-8")) == {"second": 2}
    assert [entry.name for entry in tmp_path.iterdir()] == ["results.json"]


@pytest.mark.parametrize("content", [{"a": object()}, {"a": {1, 2}}, {"a": 1j}])
def test_content_that_is_no_json_leaves_the_old_file(tmp_path: Path, content: dict[str, Any]) -> None:
    target = tmp_path / "results.json"
    write_json(target, {"old": 1})
    with pytest.raises(TypeError, match="not JSON serializable"):
        write_json(target, content)
    assert strict(target.read_text(encoding="utf-8")) == {"old": 1}
    assert [entry.name for entry in tmp_path.iterdir()] == ["results.json"]


@pytest.mark.parametrize("call", ["os.replace", "os.fsync"])
@pytest.mark.parametrize(
    ("error", "seen"),
    [(OSError("disk full"), OutputError), (KeyboardInterrupt(), KeyboardInterrupt)],
    ids=["error", "interrupt"],
)
def test_writing_that_fails_leaves_the_old_file_and_nothing_else(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    call: str,
    error: BaseException,
    seen: type[BaseException],
) -> None:
    target = tmp_path / "results.json"
    write_json(target, {"old": 1})

    def fail(*_: Any, **__: Any) -> None:
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(call, fail)
        with pytest.raises(seen):
            write_json(target, {"new": 2})
    assert strict(target.read_text(encoding="utf-8")) == {"old": 1}
    assert [entry.name for entry in tmp_path.iterdir()] == ["results.json"]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "Expecting value"),
        (b'{"a": ', "Expecting value"),
        (b'{"a": NaN}', "NaN is not a number of strict JSON"),
        (b"[-Infinity]", "-Infinity is not a number of strict JSON"),
        (b'"\xe9"', "codec can't decode"),
        (b"[" * 100_000, "recursion"),
    ],
)
def test_file_that_is_not_strict_json_is_refused(tmp_path: Path, content: bytes, reason: str) -> None:
    path = tmp_path / "content.json"
    path.write_bytes(content)
    with pytest.raises(InvalidValueError, match=rf"content\.json' is .*{reason}.*; allowed: strict JSON"):
        read_json(path)


def test_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match="No such file"):
        read_json(tmp_path / "nothing.json")


def test_content_reads_back_as_it_was_written(tmp_path: Path) -> None:
    content = {"a": [1, 0.1, None, "inf"], "b": {"c": "é"}}
    write_json(tmp_path / "content.json", content)
    assert read_json(tmp_path / "content.json") == content


def test_folder_is_made_and_left_empty(tmp_path: Path) -> None:
    prepare_folder(tmp_path / "new" / "inner")
    assert list((tmp_path / "new" / "inner").iterdir()) == []


def test_folder_in_the_place_of_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="cannot write to"):
        prepare_folder(tmp_path / "file" / "inner")
    assert (tmp_path / "file").read_text() == "mine"
