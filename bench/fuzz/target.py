"""`Target`: one class of cases."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hypothesis import strategies as st


@dataclass(frozen=True)
class Prepared:
    """A class of cases that is ready to run.

    Attributes:
        arguments: strategy of the argument of a case.
        call: function under test.
    """

    arguments: st.SearchStrategy[Any]
    call: Callable[[Any], object]


@dataclass(frozen=True)
class Target:
    """One class of cases.

    Attributes:
        name: name in the table and on the command line.
        prepare: makes environments and files once, in a folder of its own.
        share: cases of this class in relation to the others; slow classes get fewer.
    """

    name: str
    prepare: Callable[[Path], Prepared]
    share: float = 1.0
