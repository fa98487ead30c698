"""`make bench-engines`: the compiled engine compared with MuJoCo and with Reacher-v5.

Every program runs in a process of its own, in turn with the others, and is timed by the processor time that
the process takes, so that other programs of the machine disturb the ratios little. The table stands on
docs/performance.md; the results are stored beside this file.
"""

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import date
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from bench import machine
from bench.cores import count_cores
from bench.engine_programs import FORCE, SIZE, Measured, Program, measure, surroundings
from bench.engine_training import PARTS
from bench.names import count_text
from bench.rounds import CONTACT, FREE, REACHER
from bench.sheets import Sheet, markdown, rich_table
from prp_gym.artifacts import write_file, write_json
from prp_gym.console.consoles import make_console
from prp_gym.tasks.setup import COMPILED, MUJOCO

STORED = Path(__file__).with_name("engines.json")
"""The results that the page shows."""

HEADING = "## The compiled engine\n"
"""Start of the section of the page, which goes on to its end."""

_PAGE = Path("docs/performance.md")
_SECTION = Path(__file__).with_name("engines.md")
_ROUNDS, _SECONDS = 3, 1.0
_WIDTH = 190  # columns; wide enough for every cell


@dataclass(frozen=True)
class Comparison:
    """A ratio of rates.

    Attributes:
        what: what is compared, as the table tells it.
        program: program whose rate is the numerator.
        reference: program whose rate is the denominator.
        goal: least ratio that was aimed at.
    """

    what: str
    program: Program
    reference: Program
    goal: float


def comparisons() -> Iterator[Comparison]:
    """All comparisons, in the order of the table."""
    yield from _single()
    yield from _vector()
    for scenario in ("randomized", "realistic"):
        for environment in (FREE, CONTACT, FORCE):
            today = Program("evaluate", environment, MUJOCO, scenario, with_numpy=True)
            what = "episodes of all traced controllers with all metrics, against MuJoCo and NumPy"
            yield Comparison(what, Program("evaluate", environment, COMPILED, scenario), today, 15.0)
            what = "the same with MuJoCo's physics, against MuJoCo and NumPy"
            yield Comparison(what, Program("evaluate", environment, MUJOCO, scenario), today, 2.0)
    for environment, goal in ((FREE, 1.0), (CONTACT, 4.0), (FORCE, 4.0)):
        one, other = (Program("held", environment, engine) for engine in (COMPILED, MUJOCO))
        yield Comparison("step of an action mode, N = 8, 20 Hz, against MuJoCo", one, other, goal)
    for environment in (FREE, CONTACT, FORCE):
        one, other = (Program(kind, environment, COMPILED) for kind in ("gradient", "scores"))
        what = "scores of 500 periods with their derivatives by all settings, against scores alone"
        yield Comparison(what, one, other, 1.0 / 15.0)
    for environment in (CONTACT, FORCE):
        today, mujoco, compiled = trainings(environment)
        what = "training by PPO, rollout and update, against MuJoCo and NumPy"
        yield Comparison(what, compiled, today, 4.0)
        yield Comparison("the same with MuJoCo's physics, against MuJoCo and NumPy", mujoco, today, 0.0)


def trainings(environment: str) -> tuple[Program, Program, Program]:
    """Training in the scenario of the recipes: MuJoCo and NumPy, MuJoCo, the compiled engine."""
    mujoco, compiled = (
        Program("training", environment, engine, "realistic") for engine in (MUJOCO, COMPILED)
    )
    return replace(mujoco, with_numpy=True), mujoco, compiled


def _single() -> Iterator[Comparison]:
    """One environment beside Reacher-v5."""
    for without_clock, how, goal in ((False, "as shipped", 2.5), (True, "clock off for both", 2.0)):
        reacher = Program("single", REACHER, "", "", without_clock)
        what = f"step, N = 1, MuJoCo's physics, against Reacher-v5, {how}"
        yield Comparison(what, Program("single", FREE), reacher, goal)
    reacher = Program("single", REACHER, "", "")
    yield Comparison("step, N = 1, against Reacher-v5", Program("single", FREE, COMPILED), reacher, 8.0)
    for environment in (FREE, CONTACT, FORCE):
        one, other = Program("reset", environment), Program("reset", REACHER, "", "")
        yield Comparison("reset, N = 1, MuJoCo's physics, against Reacher-v5", one, other, 0.0)


def _vector() -> Iterator[Comparison]:
    """Many environments beside MuJoCo's."""
    for environment in (FREE, CONTACT, FORCE):
        one, other = (Program("vector", environment, engine) for engine in (COMPILED, MUJOCO))
        yield Comparison(f"step, N = {SIZE}, against MuJoCo, one thread", one, other, 15.0)
    for all_cores, where in ((False, "on one core"), (True, "on all cores")):
        for environment in (FREE, CONTACT, FORCE):
            one = Program("vector", environment, COMPILED, all_cores=all_cores)
            bare = Program("bare", environment, all_cores=all_cores)
            yield Comparison(f"step, N = {SIZE}, against bare mj_step {where}", one, bare, 10.0)


def _measured(program: Program, seconds: float) -> Measured:
    """What a program measures in a process of its own; bare loops on all cores in one for each core."""
    command = [sys.executable, "-m", "bench.engines", "--child", json.dumps(asdict(program))]
    count = count_cores() if program.all_cores and program.kind == "bare" else 1
    processes = [
        subprocess.Popen(
            [*command, "--seconds", str(seconds)],
            stdout=subprocess.PIPE,
            text=True,
            env=surroundings(program),
        )
        for _ in range(count)
    ]
    outputs = [process.communicate()[0] for process in processes]
    for process in processes:
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, process.args)
    found = [Measured(*json.loads(output.splitlines()[-1])) for output in outputs]
    return Measured(sum(one.rate for one in found), found[0].shares)


def row_of(comparison: Comparison, measured: Mapping[Program, Sequence[Measured]]) -> dict[str, Any]:
    """One row of the results."""
    sides = (measured[side] for side in (comparison.program, comparison.reference))
    one, other = (np.array([found.rate for found in side]) for side in sides)
    ratio = one / other
    return {
        "what": comparison.what,
        "environment": comparison.program.environment,
        "scenario": comparison.program.scenario,
        "rate": float(np.median(one)),
        "reference": float(np.median(other)),
        "ratio": float(np.median(ratio)),
        "lowest": float(ratio.min()),
        "highest": float(ratio.max()),
        "goal": comparison.goal,
    }


_ENGINES = {MUJOCO: "MuJoCo", COMPILED: "compiled"}


def training_row(program: Program, measured: Sequence[Measured]) -> dict[str, Any]:
    """The shares of one training."""
    return {
        "environment": program.environment,
        "engine": "MuJoCo and NumPy" if program.with_numpy else _ENGINES[program.engine],
        "rate": float(np.median([found.rate for found in measured])),
        "shares": {
            part: float(np.median([found.shares[part] for found in measured]))
            for part in PARTS
            if part in measured[0].shares
        },
    }


_HEADERS = ("comparison", "environment", "scenario", "ratio", "range", "goal", "result")


def cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    """One row of the table."""
    ratio, goal = row["ratio"], row["goal"]
    result = ("met" if ratio >= goal else "missed") if goal else "-"
    spread = f"{_short(row['lowest'])} to {_short(row['highest'])}"
    aim = f"at least {goal:.2g}" if goal else "-"
    return row["what"], row["environment"], row["scenario"], _short(ratio), spread, aim, result


def _short(ratio: float) -> str:
    return f"{ratio:.1f}" if ratio >= 1.0 else f"{ratio:.2f}"


def sheet(results: Mapping[str, Any]) -> Sheet:
    """The table of all comparisons."""
    return Sheet("engines", "ratios of rates", _HEADERS, tuple(map(cells, results["rows"])), texts=3)


def training_sheet(results: Mapping[str, Any]) -> Sheet:
    """The shares of all trainings."""
    rows = [
        (
            *(row["environment"], row["engine"], count_text(row["rate"])),
            *(f"{100.0 * row['shares'][part]:.0f} %" if part in row["shares"] else "-" for part in PARTS),
        )
        for row in results["training"]
    ]
    headers = ("environment", "engine", "steps/s", *PARTS)
    return Sheet("training", "shares of training by PPO", headers, tuple(rows), texts=2)


def section(results: Mapping[str, Any]) -> str:
    """The section of the page."""
    about = {name: results["machine"][name] for name in ("processor", "cores")}
    about |= {
        "table": markdown(sheet(results)).rstrip(),
        "training": markdown(training_sheet(results)).rstrip(),
        "rounds": results["rounds"],
        "date": results["date"],
    }
    return HEADING + _SECTION.read_text(encoding="utf-8").format(**about)


def write_section(results: Mapping[str, Any], page: Path) -> None:
    """Replace the section of the page, which is its last."""
    before = page.read_text(encoding="utf-8").split(HEADING)[0]
    write_file(page, (before + section(results)).encode())


app = typer.Typer(add_completion=False)


@app.command()
def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds, in which every program runs once.")] = _ROUNDS,
    seconds: Annotated[float, typer.Option(help="Time of a program in a round [s].")] = _SECONDS,
    only: Annotated[str, typer.Option(help="Kind of programs to measure; empty for all.")] = "",
    child: Annotated[str, typer.Option(hidden=True)] = "",
) -> None:
    """Compare the engines, print a table, and show it on docs/performance.md if nothing is left out."""
    if child:
        print(json.dumps(measure(Program(**json.loads(child)), seconds)))
        return
    chosen = [one for one in comparisons() if only in ("", one.program.kind)]
    programs = dict.fromkeys(side for one in chosen for side in (one.program, one.reference))
    measured: dict[Program, list[Measured]] = {program: [] for program in programs}
    for _ in range(rounds):
        for program in programs:
            measured[program].append(_measured(program, seconds))
    results = {
        "rounds": rounds,
        "date": f"{date.today():%-d %B %Y}",
        **machine.describe("python -m bench.engines"),
    }
    results["rows"] = [row_of(one, measured) for one in chosen]
    trained = [one for environment in (CONTACT, FORCE) for one in trainings(environment) if one in measured]
    results["training"] = [training_row(one, measured[one]) for one in trained]
    for table in (sheet(results), *([training_sheet(results)] if trained else [])):
        make_console(least=_WIDTH).print(rich_table(table))
    if not only:
        write_json(STORED, results)
        write_section(results, _PAGE)


if __name__ == "__main__":
    app()
