"""The literals in the files of the experiments that this computation explains."""

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FOLDER = Path(__file__).parents[3] / "prp_gym" / "reproduction"
SOURCE = "a second simulation, with Pinocchio"
"""The source that such a literal names."""


def frozen_checks(text: str) -> list[Mapping[str, Any]]:
    """The checks of a file whose numbers come from here."""
    tables = tomllib.loads(text)
    own = [row for figure in tables["figures"] for row in figure["checks"]]
    return [row for row in [*own, *tables.get("checks", [])] if row["predict"].get("source") == SOURCE]


def written(numbers: Array) -> str:
    """Numbers as they stand in a file: eight digits, one or a list."""
    texts = [_number(float(number)) for number in numbers]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"


def _number(value: float) -> str:
    """Eight digits; rounding errors of what should be zero are not written."""
    if abs(value) < 1e-12:
        return "0.0"
    text = f"{value:.8g}"
    return text if any(sign in text for sign in ".e") else f"{text}.0"


def with_literals(text: str, results: Mapping[str, Array]) -> str:
    """A file's text with the numbers of some checks replaced."""
    for name, numbers in results.items():
        pattern = rf'(\nname = "{name}"\n(?:.+\n)*?predict = {{ value = )(.+?)(, source = "{SOURCE}" }})'
        literal = written(numbers)
        text, count = re.subn(pattern, lambda found, new=literal: f"{found[1]}{new}{found[3]}", text)  # type: ignore[misc]
        if count != 1:
            raise ValueError(f"check {name!r} occurs {count} times")
    return text


def chapters(names: Sequence[str] = ()) -> list[Path]:
    """The files of the experiments, or some of them."""
    return [path for path in sorted(FOLDER.glob("*.toml")) if not names or path.name in names]
