"""`make bench`: the speed of the suite compared with its peers, in one run."""

import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from bench import costs, goals, machine, memory, peers, single, training, vector
from bench.report import PARTS, machine_text, write_page
from bench.rounds import FREE, FULL, QUICK, REACHER, Effort, race
from bench.sheets import rich_table, sheets
from prp_gym.artifacts import prepare_folder, write_json
from prp_gym.console.consoles import make_console
from prp_gym.errors import UnknownNameError

_RESET_SIZES = (1, 64, 1024)
_QUICK_RESET_SIZES = (1, 4)
_WIDTH = 170  # columns; wide enough for every cell


def measure_single(effort: Effort) -> list[dict[str, Any]]:
    """Measure single environments."""
    return [one.describe() for one in race(single.contenders(effort), effort.rounds, effort.single_seconds)]


def measure_vector(effort: Effort) -> list[dict[str, Any]]:
    """Measure vector environments."""
    return [one.describe() for one in race(vector.contenders(effort), effort.vector_rounds, effort.seconds)]


def measure_peers(effort: Effort) -> dict[str, Any]:
    """Measure peers together with this suite and Reacher-v5."""
    found, described = peers.contenders()
    references = [
        one
        for one in single.contenders(effort)
        if one.label.kind == "single"
        and one.label.environment in (REACHER, FREE)
        and one.label.control_frequency == min(single.FREQUENCIES)
    ]
    rates = race([*found, *references], effort.vector_rounds, 2 * effort.seconds)
    return {"rates": [one.describe() for one in rates], "peers": described}


def measure_training(effort: Effort) -> dict[str, list[dict[str, Any]]]:
    """Measure training."""
    found = {}
    for recipe in training.RECIPES[: effort.recipes]:
        contenders, shares = training.contenders(recipe, effort)
        rounds = min(effort.vector_rounds, training.ROUNDS)
        found[recipe.name] = [
            {**one.describe(), "shares": shares[one.label].describe()}
            for one in race(contenders, rounds, effort.seconds)
        ]
    return found


def measure_costs(effort: Effort) -> dict[str, Any]:
    """Measure the cost of steps and resets."""
    sizes = _QUICK_RESET_SIZES if effort is QUICK else _RESET_SIZES
    return {"steps": costs.split_steps(effort), "resets": costs.time_resets(effort, sizes)}


def measure_evaluate(effort: Effort) -> dict[str, float]:
    """Measure the evaluation of all baselines, written to a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "prp_gym.cli.main", "evaluate", "--output", folder]
        start = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        return {"seconds": time.perf_counter() - start}


MEASURES: Mapping[str, Callable[[Effort], Any]] = {
    "single": measure_single,
    "vector": measure_vector,
    "peers": measure_peers,
    "costs": measure_costs,
    "memory": memory.measure,
    "training": measure_training,
    "evaluate": measure_evaluate,
}


def main(
    quick: Annotated[bool, typer.Option(help="A short run that only checks that everything works.")] = False,
    part: Annotated[list[str] | None, typer.Option(help="Part to measure; repeatable. Default: all.")] = None,
    with_evaluate: Annotated[
        bool, typer.Option(help="Measure `make evaluate` too, except in a quick run.")
    ] = True,
    output: Annotated[Path, typer.Option(help="Folder for bench.json.")] = Path("results/bench"),
    docs: Annotated[
        Path, typer.Option(help="Folder of the page, which is written if no part is left out.")
    ] = Path("docs"),
) -> None:
    """Measure the suite and its peers, and write tables, bench.json, and the page with its figure."""
    chosen = part or [name for name in MEASURES if name != "evaluate" or (with_evaluate and not quick)]
    for name in chosen:
        if name not in MEASURES:
            raise UnknownNameError("part", name, MEASURES)
    prepare_folder(output)
    effort = QUICK if quick else FULL
    command = shlex.join(["python", "-m", "bench", *sys.argv[1:]])
    results = {**machine.describe(command), "effort": asdict(effort)}
    started = time.perf_counter()
    for name in chosen:
        make_console(stderr=True).print(f"{time.perf_counter() - started:5.0f} s  {name}", highlight=False)
        results[name] = MEASURES[name](effort)
    results["duration_seconds"] = time.perf_counter() - started
    results["goals"] = [goals.describe(goal) for goal in goals.goals(results)]
    write_json(output / "bench.json", results)
    show(results)
    if set(PARTS) <= set(results):
        write_page(results, docs)


def show(results: Mapping[str, Any]) -> None:
    """Print the tables."""
    console = make_console(least=_WIDTH)
    console.print(machine_text(results), highlight=False)
    for sheet in sheets(results):
        console.print(rich_table(sheet))


if __name__ == "__main__":
    typer.run(main)
