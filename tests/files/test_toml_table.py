"""A table of a TOML file is replaced, and nothing else of the file changes."""

from pathlib import Path
from typing import Any

import pytest

from prp_gym.errors import InvalidValueError
from prp_gym.files.toml_table import replace_table
from prp_gym.files.toml_text import parse_toml

KEY = ("gains", "tuned", "PRP-Force-v0")
TEXT = """# numbers of a controller
intended = ["PRP-Force-v0"]

[gains.report]
stiffness = 1.0  # as printed

[gains.tuned]
stiffness = 2.0
source = "here"

[gains.tuned."PRP-Force-v0"]
stiffness = 3.0
source = "there"

# about 50 Hz
[gains.tuned_50hz]
stiffness = 4.0
"""
TABLE: dict[str, Any] = {
    "stiffness": [0.1, 1e-09, 2.0],
    "word": 'a "quoted" word, K_P = ω²',
    "on": True,
    "count": 3,
    "target_factor": {"damping": 1.25, "inertia": [0.5, 1.0]},
}


def test_table_is_replaced_and_reads_back_as_it_was_given() -> None:
    changed = replace_table(TEXT, KEY, TABLE)
    expected = parse_toml(TEXT)
    expected["gains"]["tuned"]["PRP-Force-v0"] = TABLE
    assert parse_toml(changed) == expected
    before, _, rest = TEXT.partition('[gains.tuned."PRP-Force-v0"]')
    assert changed.startswith(before)
    assert changed.endswith(rest.partition("\n\n")[2])
    assert replace_table(changed, KEY, TABLE) == changed


def test_new_table_stands_behind_the_last_one_of_its_parent() -> None:
    changed = replace_table(TEXT, ("gains", "tuned", "PRP-Other-v0"), {"stiffness": 5.0})
    assert '"there"\n\n[gains.tuned."PRP-Other-v0"]\nstiffness = 5.0\n\n# about 50 Hz\n' in changed
    assert changed.replace('\n[gains.tuned."PRP-Other-v0"]\nstiffness = 5.0\n', "") == TEXT


def test_table_may_be_the_last_of_its_file() -> None:
    changed = replace_table(TEXT.rstrip(), ("gains", "tuned_50hz", "PRP-Force-v0"), {"stiffness": 5.0})
    assert parse_toml(changed)["gains"]["tuned_50hz"]["PRP-Force-v0"] == {"stiffness": 5.0}


def test_parent_must_be_there() -> None:
    with pytest.raises(InvalidValueError, match=r"a text with the header \[gains\.fast\]"):
        replace_table(TEXT, ("gains", "fast", "PRP-Force-v0"), {})


@pytest.mark.parametrize("value", [None, float("nan"), float("inf"), Path("here"), [None]])
def test_value_that_toml_cannot_hold_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValueError, match="value of 'gain' for TOML"):
        replace_table(TEXT, KEY, {"gain": value})
