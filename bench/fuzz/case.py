"""One case: a call under a time limit, and what was wrong with its outcome."""

import signal
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from prp_gym.errors import PRPError, shortened

UNTYPED, SILENT_NAN, HANG, LITTER = "untyped", "NaN", "hangs", "litter"
KINDS = (UNTYPED, SILENT_NAN, HANG, LITTER)

LIMIT = 20.0
"""Time in which a case must end [s]."""

_DEPTH = 6  # of the parts of a result that are searched for NaN


@dataclass(frozen=True)
class Fault:
    """What was wrong with a case.

    Attributes:
        kind: one of `KINDS`.
        where: error and line of the package, by which equal faults are recognised.
        example: arguments of the case.
    """

    kind: str
    where: str
    example: str


class _TimeIsUpError(BaseException):
    """Raised in a case that takes too long; no handler of the package catches it."""


def run_case(call: Callable[[Any], object], arguments: Any) -> Fault | None:
    """Run a case.

    Args:
        call: function under test.
        arguments: its one argument, drawn by a strategy.

    Returns:
        What was wrong; None where the call returned finite numbers or raised an error of the package.
    """
    begin = time.perf_counter()
    try:
        with _limited(LIMIT), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", DeprecationWarning)
            result = call(arguments)
    except PRPError as error:
        return _message_fault(error, arguments)
    except _TimeIsUpError as error:
        return Fault(HANG, _line(error), shortened(arguments, 400))
    except BaseException as error:
        return Fault(UNTYPED, f"{type(error).__name__} at {_line(error)}", _example(arguments, error))
    if time.perf_counter() - begin > LIMIT:
        return Fault(HANG, "a call that cannot be interrupted", shortened(arguments, 400))
    return Fault(SILENT_NAN, "result", shortened(arguments, 400)) if holds_nan(result) else None


def holds_nan(value: Any, depth: int = _DEPTH) -> bool:
    """Whether NaN is anywhere in a result."""
    if isinstance(value, (float, np.floating)):
        return bool(np.isnan(value))
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "fc" and bool(np.isnan(value).any())
    if depth == 0 or isinstance(value, (str, bytes)):
        return False
    if isinstance(value, Mapping):
        return any(holds_nan(part, depth - 1) for part in value.values())
    if isinstance(value, (tuple, list)):
        return any(holds_nan(part, depth - 1) for part in value)
    if is_dataclass(value) and not isinstance(value, type):
        return any(holds_nan(getattr(value, entry.name), depth - 1) for entry in fields(value))
    return False


def _message_fault(error: PRPError, arguments: Any) -> Fault | None:
    """What is wrong with an error of the package: a message that is missing or endless."""
    if 0 < len(str(error)) < 20_000:
        return None
    return Fault(UNTYPED, f"message of {type(error).__name__}", shortened(arguments, 400))


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    def stop(*_: object) -> None:
        raise _TimeIsUpError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _line(error: BaseException) -> str:
    """The last line of the package that an error passed."""
    own = [f for f in traceback.extract_tb(error.__traceback__) if "prp_gym" in f.filename]
    own = own or traceback.extract_tb(error.__traceback__)
    return f"{own[-1].filename.rpartition('prp_gym/')[-1]}:{own[-1].lineno}" if own else "nowhere"


def _example(arguments: Any, error: BaseException) -> str:
    return f"{shortened(arguments, 400)}: {shortened(str(error), 200)}"
