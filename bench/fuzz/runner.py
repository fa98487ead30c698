"""Runs the cases of a class and collects what was wrong."""

import os
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings

from bench.fuzz.case import KINDS, LITTER, Fault, run_case
from bench.fuzz.target import Target

WORK = "work"
"""Folder below the current one that a class of cases may fill; everything else that appears is litter."""

_CACHE_OF_TORCH = "torchinductor_"  # one folder for each user, whatever the command
_ROUND = 2_000  # cases of one run of hypothesis, whose tree of choices grows with their number


@dataclass
class Outcome:
    """The result of a class of cases.

    Attributes:
        name: name of the class.
        cases: number of cases that were run.
        seconds: time that they took [s].
        counts: number of faulty cases by kind.
        faults: shortest example of each fault.
    """

    name: str
    cases: int = 0
    seconds: float = 0.0
    counts: Counter[str] = field(default_factory=Counter)
    faults: dict[tuple[str, str], Fault] = field(default_factory=dict)

    def add(self, fault: Fault | None) -> None:
        """Count one case."""
        self.cases += 1
        if fault is None:
            return
        self.counts[fault.kind] += 1
        known = self.faults.get((fault.kind, fault.where))
        if known is None or len(fault.example) < len(known.example):
            self.faults[fault.kind, fault.where] = fault

    @property
    def row(self) -> tuple[Any, ...]:
        """Name, number of cases, and number of faulty ones by kind."""
        return self.name, self.cases, *(self.counts[kind] for kind in KINDS)


def run_target(target: Target, cases: int, first_seed: int) -> Outcome:
    """Run cases of a class in an empty folder.

    Args:
        target: class of cases.
        cases: number of cases.
        first_seed: random seed; equal seeds give equal cases.
    """
    outcome = Outcome(target.name)
    begin = time.perf_counter()
    with empty_folder() as folder:
        prepared = target.prepare(folder / WORK)
        number = 0
        while outcome.cases < cases:
            wanted = min(_ROUND, cases - outcome.cases)

            @seed(first_seed + number)
            @settings(
                max_examples=wanted,
                database=None,
                deadline=None,
                phases=(Phase.generate,),
                suppress_health_check=list(HealthCheck),
            )
            @given(prepared.arguments)
            def collect(arguments: Any) -> None:
                outcome.add(run_case(prepared.call, arguments))

            collect()
            number += 1
        for name in litter(folder):
            outcome.counts[LITTER] += 1
            outcome.faults[LITTER, name] = Fault(LITTER, name, "left behind")
    outcome.seconds = time.perf_counter() - begin
    return outcome


def litter(folder: Path) -> list[str]:
    """Names of what was left beside the folder of the class."""
    return sorted(path.name for path in folder.iterdir() if path.name not in (WORK, "temporary")) + sorted(
        f"temporary/{path.name}"
        for path in (folder / "temporary").iterdir()
        if not path.name.startswith(_CACHE_OF_TORCH)
    )


@contextmanager
def empty_folder() -> Iterator[Path]:
    """An empty current folder with folders for the class and for temporary files."""
    before, temporary = Path.cwd(), tempfile.tempdir
    folder = Path(tempfile.mkdtemp(prefix="prp-gym-fuzz-"))
    (folder / WORK).mkdir()
    (folder / "temporary").mkdir()
    environment = os.environ.get("TMPDIR")
    os.environ["TMPDIR"] = tempfile.tempdir = str(folder / "temporary")
    os.chdir(folder)
    try:
        yield folder
    finally:
        os.chdir(before)
        tempfile.tempdir = temporary
        if environment is None:
            del os.environ["TMPDIR"]
        else:
            os.environ["TMPDIR"] = environment
        shutil.rmtree(folder, ignore_errors=True)
