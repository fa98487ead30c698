"""`make mutants`: do the tests notice deliberate defects? Each is put into a copy of the tree, never here."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_name("mutants.toml")
PACKAGE = "prp_gym"
CODE = ("*.py", "*.toml")
NOTICED, SURVIVED, BROKEN, LATE = "noticed", "survived", "tests did not run", "time limit"
_PARTS = ("prp_gym", "envs", "baselines", "agents", "tests", "bench", "docs")  # of the tree, to be copied
_LIMIT = 300.0  # [s]: of the tests of one defect
_PASSED, _FAILED = 0, 1  # what pytest returns


@dataclass(frozen=True)
class Defect:
    """A deliberate change of the code for the worse.

    Attributes:
        name: by which it is chosen.
        package: dotted name of the package or module in which the old text stands exactly once.
        old: text that it replaces.
        new: text that stands there instead.
        tests: files, relative to the root, of which at least one test must fail.
    """

    name: str
    package: str
    old: str
    new: str
    tests: tuple[str, ...]

    @classmethod
    def from_table(cls, name: str, table: Mapping[str, Any]) -> "Defect":
        """One table of `mutants.toml`."""
        return cls(name, table["package"], table["old"], table["new"], tuple(table["tests"]))


def load_defects(path: Path = LIST) -> list[Defect]:
    """All defects, in the order of the file."""
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    return [Defect.from_table(name, table) for name, table in tables.items()]


def choose(defects: Sequence[Defect], names: Sequence[str]) -> list[Defect]:
    """The defects of the given names, or all without a name.

    Raises:
        UnknownNameError: no defect has one of the names.
    """
    known = {defect.name: defect for defect in defects}
    for name in names:
        if name not in known:
            raise UnknownNameError("defect", name, known)
    return [known[name] for name in names] if names else list(defects)


def files_of(package: str, root: Path = ROOT) -> list[Path]:
    """The code and data files of a package with its subpackages, or the file of a module."""
    path = root.joinpath(*package.split("."))
    if not path.is_dir():
        return [path.with_suffix(".py")]
    folder = path.resolve()  # some packages are links to folders of the root, and links are not followed
    return sorted(file for pattern in CODE for file in folder.rglob(pattern))


def locate(defect: Defect, root: Path = ROOT) -> Path:
    """The file in which a defect's old text stands.

    Raises:
        InvalidValueError: the old text stands nowhere in the package, or more than once.
    """
    found = [(file, _count(file, defect.old)) for file in files_of(defect.package, root)]
    total = sum(count for _, count in found)
    if total != 1:
        what = f"number of passages in {defect.package} with the old text of defect {defect.name!r}"
        raise InvalidValueError(what, total, "1")
    return next(file for file, count in found if count)


def _count(file: Path, text: str) -> int:
    return file.read_text(encoding="utf-8").count(text) if file.is_file() else 0


@contextmanager
def applied(defect: Defect, tree: Path) -> Iterator[Path]:
    """A tree with the defect in it, and without it afterwards.

    Args:
        defect: what is wrong in the meantime.
        tree: root of a copy.

    Yields:
        The file that was changed.
    """
    file = locate(defect, tree)
    right = file.read_text(encoding="utf-8")
    file.write_text(right.replace(defect.old, defect.new), encoding="utf-8")
    try:
        yield file
    finally:
        file.write_text(right, encoding="utf-8")


def copy_tree(target: Path, root: Path = ROOT) -> Path:
    """The code, its tests, and the files of the root that tests read; links stay links."""
    for part in _PARTS:
        shutil.copytree(
            root / part, target / part, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
        )
    for file in root.iterdir():
        if file.is_file():
            shutil.copy2(file, target)
    return target


@dataclass(frozen=True)
class Outcome:
    """What the tests say about a tree.

    Attributes:
        name: of the defect in it.
        result: one of `NOTICED`, `SURVIVED`, `BROKEN` and `LATE`.
        seconds: how long its tests took [s].
        witness: the test that failed first, or the last line that pytest wrote.
    """

    name: str
    result: str
    seconds: float
    witness: str


def run_module(tree: Path, words: Sequence[str], limit: float) -> subprocess.CompletedProcess[str] | None:
    """Run a module as a program in a tree, with the tree's own packages; None past the limit [s].

    Args:
        tree: root of the tree.
        words: name of the module, and its arguments.
        limit: longest time [s].
    """
    command = [sys.executable, "-m", *words]
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        return subprocess.run(
            command, cwd=tree, env=environment, capture_output=True, text=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        return None


def run_tests(tree: Path, tests: Iterable[str], limit: float = _LIMIT) -> tuple[int | None, str]:
    """Run test files of a tree up to the first failure.

    Returns:
        What pytest returned, None past the limit [s]; and the failed test or pytest's last line.
    """
    done = run_module(tree, ["pytest", "-x", "-q", "-p", "no:cacheprovider", *tests], limit)
    if done is None:
        return None, f"more than {limit:g} s"
    lines = [line for line in done.stdout.splitlines() if line.strip()] or ["no output"]
    failed = [line for line in lines if line.startswith(("FAILED ", "ERROR "))]
    return done.returncode, (failed or lines)[-1]


def try_defect(defect: Defect, tree: Path) -> Outcome:
    """Whether the tests declared for a defect notice it.

    Args:
        defect: that is put into the tree meanwhile.
        tree: root of a copy in which all tests pass.
    """
    start = time.perf_counter()
    with applied(defect, tree):
        code, witness = run_tests(tree, defect.tests)
    result = {_PASSED: SURVIVED, _FAILED: NOTICED, None: LATE}.get(code, BROKEN)
    return Outcome(defect.name, result, time.perf_counter() - start, witness)


def try_all(defects: Sequence[Defect], trees: Sequence[Path], console: Console) -> list[Outcome]:
    """Try defects on several copies of the tree at once, one at a time on each; outcomes in order."""
    idle: SimpleQueue[Path] = SimpleQueue()
    for tree in trees:
        idle.put(tree)

    def run(defect: Defect) -> Outcome:
        tree = idle.get()
        try:
            outcome = try_defect(defect, tree)
        finally:
            idle.put(tree)
        console.print(f"{outcome.result:9} {outcome.seconds:5.0f} s  {outcome.name}", highlight=False)
        return outcome

    with ThreadPoolExecutor(len(trees)) as pool:
        return list(pool.map(run, defects))


def score_table(defects: Sequence[Defect], outcomes: Sequence[Outcome]) -> Table:
    """One row a defect, and how many were noticed."""
    noticed = sum(outcome.result == NOTICED for outcome in outcomes)
    table = Table(title=f"{noticed} of {len(outcomes)} defects noticed", title_justify="left")
    for header in ("defect", "package", "result", "s", "noticed by"):
        table.add_column(header, justify="right" if header == "s" else "left", overflow="fold")
    for defect, outcome in zip(defects, outcomes, strict=True):
        package = defect.package.removeprefix(f"{PACKAGE}.")
        witness = outcome.witness.split(" - ")[0].removeprefix("FAILED ").removeprefix("tests/")
        table.add_row(defect.name, package, outcome.result, f"{outcome.seconds:.0f}", witness)
    return table


def check_tree(tree: Path, defects: Sequence[Defect]) -> None:
    """Without a defect all declared tests must pass, or they would notice anything.

    Raises:
        InvalidValueError: a test fails in the tree as it is.
    """
    tests = dict.fromkeys(test for defect in defects for test in defect.tests)
    code, witness = run_tests(tree, tests, _LIMIT * len(tests))
    if code != _PASSED:
        raise InvalidValueError("outcome of the tests without a defect", witness, "all pass")


Only = Annotated[list[str] | None, typer.Option("--only", help="Name of a defect; may be repeated.")]
Jobs = Annotated[int, typer.Option(min=1, help="Defects tried at once.")]
Check = Annotated[bool, typer.Option("--check/--no-check", help="Run the tests without a defect first.")]


app = typer.Typer(add_completion=False)


@app.command()
def main(only: Only = None, jobs: Jobs = 1, check: Check = True) -> None:
    """Put deliberate defects into copies of the tree and say which the tests notice."""
    console = Console(width=150)
    try:
        defects = choose(load_defects(), only or ())
        for defect in defects:
            locate(defect)
        outcomes = _try_in_copies(defects, jobs, check, console)
    except PRPError as error:
        console.print(str(error), markup=False, highlight=False)
        raise typer.Exit(1) from None
    console.print(score_table(defects, outcomes))
    if any(outcome.result != NOTICED for outcome in outcomes):
        raise typer.Exit(1)


def _try_in_copies(defects: Sequence[Defect], jobs: int, check: bool, console: Console) -> list[Outcome]:
    with tempfile.TemporaryDirectory(prefix="prp_gym_mutants_") as folder:
        copies = [Path(folder, str(number)) for number in range(min(jobs, len(defects)))]
        trees = [copy_tree(copy) for copy in copies]
        if check:
            check_tree(trees[0], defects)
        return try_all(defects, trees, console)


if __name__ == "__main__":
    app()
