"""`make mutants-reproduce`: which deliberate defects does `prp-gym reproduce` alone notice?

Each defect is put into a copy of the tree, and the runs of the reproduction that it can reach are simulated
and judged, up to the first check that fails.
"""

import tempfile
import time
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from bench.judge_runs import FAILED
from bench.mutants import (
    BROKEN,
    LATE,
    NOTICED,
    SURVIVED,
    Defect,
    Outcome,
    applied,
    choose,
    copy_tree,
    locate,
    run_module,
    score_table,
)
from prp_gym.errors import InvalidValueError, PRPError

LIST = Path(__file__).with_name("mutants_reproduce.toml")
GOAL = 0.95
"""Share of the defects that the reproduction should notice."""

_LIMIT = 300.0  # [s]: of the runs of one defect


@dataclass(frozen=True)
class ReachableDefect:
    """A deliberate defect with the runs of the reproduction that it can reach.

    Attributes:
        defect: change of the code for the worse.
        runs: names of runs, of which at least one must have a check that fails.
    """

    defect: Defect
    runs: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name by which the defect is chosen."""
        return self.defect.name

    @classmethod
    def from_table(cls, name: str, table: Mapping[str, Any]) -> "ReachableDefect":
        """One table of `mutants_reproduce.toml`."""
        defect = Defect(name, table["package"], table["old"], table["new"], ())
        return cls(defect, tuple(table["runs"]))


def load_reachable(path: Path = LIST) -> list[ReachableDefect]:
    """All defects, in the order of the file."""
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    return [ReachableDefect.from_table(name, table) for name, table in tables.items()]


def judge_tree(tree: Path, runs: Sequence[str], limit: float = _LIMIT) -> tuple[int | None, str]:
    """Simulate and judge runs in a tree up to the first check that fails.

    Returns:
        What the program returned, None past the limit [s]; and the last line that it wrote.
    """
    done = run_module(tree, ["bench.judge_runs", *runs], limit)
    if done is None:
        return None, f"more than {limit:g} s"
    lines = (done.stdout or done.stderr).strip().splitlines() or ["no output"]
    crashed = done.returncode == FAILED and not done.stdout
    return -1 if crashed else done.returncode, lines[-1]


def try_reachable(item: ReachableDefect, tree: Path) -> Outcome:
    """Whether a check of the runs that a defect can reach notices it.

    Args:
        item: defect that is put into the tree meanwhile.
        tree: root of a copy in which every check passes.
    """
    start = time.perf_counter()
    with applied(item.defect, tree):
        code, witness = judge_tree(tree, item.runs)
    result = {0: SURVIVED, FAILED: NOTICED, None: LATE}.get(code, BROKEN)
    return Outcome(item.name, result, time.perf_counter() - start, witness)


Only = Annotated[list[str] | None, typer.Option("--only", help="Name of a defect; may be repeated.")]
Check = Annotated[bool, typer.Option("--check/--no-check", help="Judge the runs without a defect first.")]

app = typer.Typer(add_completion=False)


@app.command()
def main(only: Only = None, check: Check = True) -> None:
    """Put deliberate defects into a copy of the tree and say which the reproduction notices."""
    console = Console(width=150)
    try:
        known = {item.name: item for item in load_reachable()}
        items = [known[d.name] for d in choose([item.defect for item in known.values()], only or ())]
        for item in items:
            locate(item.defect)
        outcomes = _try_in_a_copy(items, check, console)
    except PRPError as error:
        console.print(str(error), markup=False, highlight=False)
        raise typer.Exit(1) from None
    console.print(score_table([item.defect for item in items], outcomes))
    if sum(outcome.result == NOTICED for outcome in outcomes) < GOAL * len(outcomes):
        raise typer.Exit(1)


def _try_in_a_copy(items: Sequence[ReachableDefect], check: bool, console: Console) -> list[Outcome]:
    with tempfile.TemporaryDirectory(prefix="prp_gym_mutants_") as folder:
        tree = copy_tree(Path(folder, "tree"))
        if check:
            _check_tree(tree, items)
        outcomes = []
        for item in items:
            outcomes.append(try_reachable(item, tree))
            last = outcomes[-1]
            line = f"{last.result:9} {last.seconds:5.0f} s  {last.name}: {last.witness}"
            console.print(line, markup=False, highlight=False)
        return outcomes


def _check_tree(tree: Path, items: Sequence[ReachableDefect]) -> None:
    """Without a defect every check must pass or be explained, or it would notice anything."""
    runs = list(dict.fromkeys(run for item in items for run in item.runs))
    code, witness = judge_tree(tree, runs, _LIMIT * len(runs))
    if code:
        raise InvalidValueError("outcome of the checks without a defect", witness, "all pass")


if __name__ == "__main__":
    app()
