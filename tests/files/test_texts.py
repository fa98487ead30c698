"""Texts in JSON, TOML and YAML: plain values, as the reference parsers read them, and nothing else."""

import json
import math
import time
import tomllib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import DataTextError
from prp_gym.files.file_reader import SETTINGS_SIZE
from prp_gym.files.json_text import parse_json
from prp_gym.files.toml_text import parse_toml
from prp_gym.files.yaml_text import parse_yaml

ROOT = Path(__file__).resolve().parents[2]
RECIPES = sorted((ROOT / "agents").rglob("*.yml"))
NUMBERS = sorted(
    path for folder in ("envs", "baselines", "prp_gym") for path in (ROOT / folder).rglob("*.toml")
)
MANY = SETTINGS_SIZE  # of characters, as many as a file may have
PROPERTY = settings(max_examples=60, deadline=None, derandomize=True)
LEAVES: st.SearchStrategy[Any] = (
    st.none() | st.booleans() | st.integers(-(10**20), 10**20) | st.text(max_size=8)
)
LEAVES |= st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
)


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_recipes_are_read_as_by_the_reference_parser(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert parse_yaml(text) == yaml.safe_load(text)


@pytest.mark.parametrize("path", NUMBERS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_numbers_are_read_as_by_the_reference_parser(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert parse_toml(text) == tomllib.loads(text)


@PROPERTY
@given(value=VALUES)
def test_plain_values_read_back_as_they_were_written(value: Any) -> None:
    assert parse_json(json.dumps(value)) == value
    text = yaml.safe_dump(value, allow_unicode=False)
    assert parse_yaml(text) == yaml.safe_load(text) == value


def test_values_of_yaml_are_those_of_its_reference_parser() -> None:
    values = "1, -2.5, .inf, 1e3, 1.0e+3, 0x1F, 1_000, 1:30, ~, null, on, 'on', \"x\\ty\", 010, +3"
    text = f"a: [{values}]\nb: |\n  x\ny: 2"
    assert parse_yaml(text) == yaml.safe_load(text)
    assert math.isnan(parse_yaml(".nan"))
    assert parse_yaml("") is None


REFUSED: list[tuple[Callable[[str], Any], str, str]] = [
    (parse_yaml, "a: &x [*x]", "line 1 has the anchor '&x'"),
    (parse_yaml, "a: 1\nb: *x", r"line 2 has the alias '\*x'"),
    (parse_yaml, "<<: {a: 1}", "is read as a merge"),
    (parse_yaml, "!!python/object/apply:os.getcwd []", "has the tag .*os.getcwd"),
    (parse_yaml, "a: !!python/name:os.system", "has the tag"),
    (parse_yaml, "a: !!str 3", "has the tag"),
    (parse_yaml, "a: ! 3", "has the tag"),
    (parse_yaml, "%TAG ! tag:x,2000:\n---\n!foo bar", "has the tag"),
    (parse_yaml, "? [a]\n: 3", r"key \[\] is not text"),
    (parse_yaml, "? {a: 1}\n: 3", "key {} is not text"),
    (parse_yaml, "1: 2", "key 1 is not text"),
    (parse_yaml, "yes: 2", "key True is not text"),
    (parse_yaml, "a: 1\na: 2", "key 'a' is given twice"),
    (parse_yaml, "a: 2001-01-01", "is read as a timestamp"),
    (parse_yaml, "---\na\n---\nb", "more than one document"),
    (parse_yaml, "a: \x00", "special characters"),
    (parse_yaml, "a: [1", "line 1"),
    (parse_yaml, "0b_", "is not a number"),
    (parse_yaml, "a: " + "1" * 41, "more than 40 digits"),
    (parse_yaml, "[" * 33 + "]" * 33, "more than 32 levels"),
    (parse_toml, "a = 1\na = 2", "overwrite"),
    (parse_toml, "a = 1979-05-27", "is a date, not a number or text"),
    (parse_toml, "a = [1979-05-27T07:32:00Z]", "is a datetime"),
    (parse_toml, "a = " + "9" * 41, "more than 40 digits"),
    (parse_toml, "a = 0x" + "f" * 41, "more than 40 digits"),
    (parse_toml, "a = " + "[" * 33 + "]" * 33, "more than 32 levels"),
    (parse_toml, ".".join("a" * 34) + " = 1", "more than 32 levels"),
    (parse_toml, ".".join(['"a,=[b"'] * 34) + " = 1", "more than 32 levels"),
    (parse_json, "NaN", "NaN is not a finite number"),
    (parse_json, "[1e999]", "'1e999' is not a finite number"),
    (parse_json, '{"a": {"b": 1, "b": 2}}', "key 'b' is given twice"),
    (parse_json, "9" * 41, "more than 40 digits"),
    (parse_json, "[" * 33 + "]" * 33, "more than 32 levels"),
    (parse_json, "", "Expecting value"),
]


@pytest.mark.parametrize(("parse", "text", "message"), REFUSED)
def test_what_is_more_than_plain_data_is_refused(
    parse: Callable[[str], Any], text: str, message: str
) -> None:
    with pytest.raises(DataTextError, match=message):
        parse(text)


def bomb(levels: int) -> str:
    """A few hundred characters that stand for 10^levels texts."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, levels)]
    return "\n".join(lines)


LONG: list[tuple[Callable[[str], Any], str]] = [
    (parse_yaml, bomb(9)),
    (parse_yaml, "[" * MANY),
    (parse_yaml, "{a: " * (MANY // 4)),
    (parse_yaml, "- " * (MANY // 2)),
    (parse_yaml, '"' + "\\" * (MANY - 1)),
    (parse_toml, "a = " + "[" * MANY),
    (parse_toml, "a = " + "{a = " * (MANY // 5)),
    (parse_toml, ".".join("a" * (MANY // 2)) + " = 1"),
    (parse_toml, '"\\"' * (MANY // 3)),
    (parse_toml, "[" * MANY),
    (parse_json, "[" * MANY),
    (parse_json, '{"a":' * (MANY // 5)),
    (parse_json, '"' + "\\" * (MANY - 1)),
    (parse_json, "9" * MANY),
]


@pytest.mark.parametrize(("parse", "text"), LONG)
def test_text_that_is_made_to_take_long_is_refused_soon(parse: Callable[[str], Any], text: str) -> None:
    before = time.process_time()
    with pytest.raises(DataTextError) as caught:
        parse(text)
    assert time.process_time() - before < 5.0  # up to 0.5 s; what doubles with every level takes for ever
    assert len(str(caught.value)) < 300


@PROPERTY
@given(text=st.text(alphabet="[]{}\"'.,=:#\\\n- a1&*!?|>%@", max_size=40))
def test_any_text_is_read_or_refused(text: str) -> None:
    for parse in (parse_yaml, parse_toml, parse_json):
        with suppress(DataTextError):
            parse(text)
