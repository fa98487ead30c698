"""A small share of the fuzzing finds nothing, and the fuzzing finds every kind of fault that it counts."""

import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from bench.fuzz.__main__ import main
from bench.fuzz.case import HANG, LITTER, SILENT_NAN, UNTYPED, run_case
from bench.fuzz.runner import run_target
from bench.fuzz.strange import POOL
from bench.fuzz.target import Prepared, Target
from bench.fuzz.targets import TARGETS
from prp_gym.errors import InvalidValueError

_SLOW = ("commands", "files", "overrides", "weights", "keywords")
_CASES = 25  # of a class; with them the tests take some seconds


@pytest.mark.parametrize("target", [t for t in TARGETS if t.name not in _SLOW], ids=lambda t: str(t.name))
def test_strange_arguments_meet_typed_errors_or_finite_results(target: Target) -> None:
    outcome = run_target(target, _CASES, first_seed=1)
    assert outcome.cases == _CASES
    assert outcome.faults == {}


def _raise(error: BaseException) -> None:
    raise error


def _warn(_: object) -> None:
    warnings.warn("overflow", RuntimeWarning, stacklevel=2)


@pytest.mark.parametrize(
    ("call", "kind"),
    [
        (lambda _: _raise(TypeError("untyped")), UNTYPED),
        (lambda _: _raise(SystemExit(1)), UNTYPED),
        (_warn, UNTYPED),
        (lambda _: {"a": [(np.array([1.0, np.nan]),)]}, SILENT_NAN),
        (lambda _: float("nan"), SILENT_NAN),
        (lambda _: time.sleep(60.0), HANG),
    ],
)
def test_fault_is_recognised(call: Any, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.fuzz.case.LIMIT", 0.2)
    fault = run_case(call, "arguments")
    assert fault is not None
    assert (fault.kind, fault.example[:11]) == (kind, "'arguments'")


@pytest.mark.parametrize("call", [lambda _: 1.0, lambda _: _raise(InvalidValueError("a", 1, "b"))])
def test_finite_result_and_typed_error_are_no_faults(call: Any) -> None:
    assert run_case(call, POOL) is None


def test_file_that_is_left_behind_is_litter() -> None:
    def prepare(_: Path) -> Prepared:
        return Prepared(st.just(None), lambda _: Path("left").write_text("x"))

    outcome = run_target(Target("writer", prepare), 1, first_seed=0)
    assert outcome.row == ("writer", 1, 0, 0, 0, 1)
    assert (LITTER, "left") in outcome.faults


def test_equal_seeds_give_equal_cases() -> None:
    seen: list[list[int]] = []
    for _ in range(2):
        drawn: list[int] = []
        target = Target("draws", lambda _, drawn=drawn: Prepared(st.integers(0, 2**40), drawn.append))  # type: ignore[misc]
        run_target(target, 20, first_seed=3)
        seen.append(drawn)
    assert seen[0] == seen[1]


def test_command_prints_a_row_for_each_class(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--cases", "10", "--only", "models", "--only", "parameters"]) == 0
    printed = capsys.readouterr().out
    assert "| class | cases | untyped | NaN | hangs | litter |" in printed
    assert "| total | 10 | 0 | 0 | 0 | 0 |" in printed
