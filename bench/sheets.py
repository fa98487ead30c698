"""Tables of the benchmark, made from its results alone."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich.table import Table

from bench.goals import AS_SHIPPED, WITHOUT_CLOCK, goals
from bench.names import contender_name, count_text, frequency_text, is_as_shipped, substeps
from bench.rounds import ALL_CORES, Label, find, ratios
from bench.single import CONDITIONS
from prp_gym.robot.arrays import Array

Results = Mapping[str, Any]
Rows = Sequence[Mapping[str, Any]]

NOT_MEASURED = "-"
_LIBRARIES = ("mujoco", "gymnasium", "numpy")
_CLOCKS = ((AS_SHIPPED, True), (WITHOUT_CLOCK, False))


@dataclass(frozen=True)
class Sheet:
    """A table.

    Attributes:
        name: Name in the page's template.
        title: Title for people.
        headers: Headers of the columns, of which the first holds names.
        rows: Cells of all rows.
        texts: Number of leading columns that hold text; the others hold numbers.
    """

    name: str
    title: str
    headers: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: int = 1


def markdown(sheet: Sheet) -> str:
    """The table in Markdown."""
    lines = [
        _line(sheet.headers),
        "|" + " --- |" * sheet.texts + " ---: |" * (len(sheet.headers) - sheet.texts),
    ]
    return "\n".join([*lines, *map(_line, sheet.rows)]) + "\n"


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def rich_table(sheet: Sheet) -> Table:
    """The table for a terminal."""
    table = Table(title=sheet.title, title_justify="left")
    for index, header in enumerate(sheet.headers):
        table.add_column(header, justify="left" if index < sheet.texts else "right")
    for row in sheet.rows:
        table.add_row(*row)
    return table


def goal_sheet(results: Results) -> Sheet:
    """Goals, the values reached, and whether they meet the goals."""
    rows = []
    for goal in goals(results):
        sign = "at least" if goal.at_least else "at most"
        unit = "" if goal.unit == "times" else f" {goal.unit}"
        digits = 2 if goal.unit == "times" else 0 if goal.unit == "s" else 1
        span = f"{goal.lowest:.{digits}f} to {goal.highest:.{digits}f}"
        rows.append(
            (
                goal.what,
                goal.how,
                f"{sign} {goal.target:g}{unit}",
                f"{goal.reached:.{digits}f}{unit}",
                span if goal.lowest != goal.highest else "",
                "met" if goal.met else "missed",
            )
        )
    return Sheet(
        "goals",
        "goals",
        ("comparison", "clock", "goal", "reached", "range over rounds", "result"),
        tuple(rows),
        2,
    )


def _by_clock(rows: Rows) -> dict[tuple[Any, ...], dict[bool, Mapping[str, Any]]]:
    """Rows with and without the clock, by everything else."""
    found: dict[tuple[Any, ...], dict[bool, Mapping[str, Any]]] = {}
    for row in rows:
        key = tuple(row[n] for n in ("kind", "environment", "control_frequency", "num_envs", "threads"))
        found.setdefault(key, {})[row["clock"]] = row
    return found


def _rate(row: Mapping[str, Any] | None) -> str:
    return NOT_MEASURED if row is None else count_text(row["median"])


def _span(row: Mapping[str, Any]) -> str:
    return f"{count_text(row['lowest'])} to {count_text(row['highest'])}"


def single_sheet(name: str, title: str, rows: Rows, peers: Rows = ()) -> Sheet:
    """Loops on one core, with and without MuJoCo's clock."""
    cells = []
    for by_clock in _by_clock(rows).values():
        shown = next(row for row in by_clock.values() if is_as_shipped(row) or len(by_clock) == 1)
        cells.append(
            (
                contender_name(shown),
                shown["environment"],
                frequency_text(shown),
                substeps(shown, peers),
                _rate(shown),
                _span(shown),
                _rate(by_clock.get(not shown["clock"])),
            )
        )
    headers = ("loop", "environment", "control", "substeps", "steps/s as shipped", "range over rounds")
    return Sheet(name, title, (*headers, "with the opposite clock setting"), tuple(cells), 2)


def peer_sheet(results: Results) -> Sheet:
    """Peers of other projects, and the reason for those that did not run."""
    part = results["peers"]
    sheet = single_sheet("peers", "peers, one core", part["rates"], part["peers"])
    missing = [_missing(peer) for peer in part["peers"] if peer["reason"]]
    used = {peer["environment"]: _versions(peer["versions"]) for peer in part["peers"]}
    here = _versions({name: results["versions"][name] for name in _LIBRARIES})
    rows = tuple((*row, used.get(row[1], here)) for row in (*sheet.rows, *missing))
    return Sheet(sheet.name, sheet.title, (*sheet.headers, "versions"), rows, 2)


def _versions(versions: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in versions.items())


def _missing(peer: Mapping[str, Any]) -> tuple[str, ...]:
    control, reason = f"{peer['control_frequency']:g} Hz", f"not measured: {peer['reason']}"
    return ("single environment", peer["environment"], control, str(peer["substeps"]), reason, "", "")


def vector_sheets(results: Results) -> Iterator[Sheet]:
    """One table per condition: kinds of vector environments by their number N."""
    rows = results["vector"]
    counts = sorted({row["num_envs"] for row in rows})
    conditions = dict.fromkeys((row["environment"], row["control_frequency"]) for row in rows)
    for environment, frequency in sorted(conditions):
        own = [r for r in rows if (r["environment"], r["control_frequency"]) == (environment, frequency)]
        by_name: dict[str, dict[int, str]] = {}
        for (_, _, _, count, _), by_clock in _by_clock(own).items():
            shown = next(row for row in by_clock.values() if is_as_shipped(row))
            other = by_clock.get(not shown["clock"])
            text = f"{_rate(shown)} ({_rate(other)})"
            by_name.setdefault(contender_name(shown), {})[count] = text
        cells = tuple((name, *(found.get(n, "") for n in counts)) for name, found in by_name.items())
        title = f"{environment} at {frequency:g} Hz, steps/s as shipped (opposite clock setting)"
        yield Sheet("vector", title, ("program", *(f"N = {count}" for count in counts)), cells)


def _median(values: Array) -> str:
    return f"{np.median(values):.2f}"


def share_sheet(results: Results) -> Sheet:
    """Rates of environments relative to the bare loop on the same models, in the same rounds."""
    single, vector = results["single"], results["vector"]
    native = [row for row in vector if row["kind"] == "native"]
    conditions = {(row["environment"], row["control_frequency"], row["num_envs"]) for row in native}
    counts = sorted({row["num_envs"] for row in native})
    cells = []
    for (environment, frequency), (how, clock) in itertools.product(CONDITIONS, _CLOCKS):
        bare = Label("bare", environment, frequency, clock=clock)
        shares = [_median(ratios(single, Label("single", environment, frequency), bare))]
        for count in counts:
            own = Label("native", environment, frequency, count, ALL_CORES)
            measured = (environment, frequency, count) in conditions
            other = replace(bare, kind="bare_all_cores")
            shares.append(_median(ratios(vector, own, other)) if measured else NOT_MEASURED)
        scaling = find(vector, replace(bare, kind="bare_all_cores"))["median"] / find(single, bare)["median"]
        cells.append((environment, f"{frequency:g} Hz", how, *shares, f"{scaling:.2f}"))
    headers = ("environment", "control", "clock", "single", *(f"N = {count}" for count in counts))
    title = "rates divided by those of bare mj_step, on one core for the single environment, on all for N"
    return Sheet("shares", title, (*headers, "bare loop, all cores / one core"), tuple(cells), 3)


def training_sheet(results: Results) -> Sheet:
    """Training, and the shares of its time."""
    cells = []
    for recipe, rows in results["training"].items():
        for row in rows:
            shares = (f"{100 * row['shares'][n]:.0f} %" for n in ("train", "env_step", "policy", "other"))
            where = f"{row['environment']} {frequency_text(row)}, {contender_name(row)}"
            clock = "read" if row["clock"] else "stopped"
            cells.append((recipe, where, clock, _rate(row), _span(row), *shares))
    headers = ("training", "environment", "clock", "steps/s", "range over rounds")
    return Sheet(
        "training",
        "training with Stable-Baselines3",
        (*headers, "updates", "environment steps", "policy", "other"),
        tuple(cells),
        3,
    )


def cost_sheet(results: Results) -> Sheet:
    """Cost of the parts of a step."""
    cells = []
    for row in results["costs"]["steps"]:
        seconds = row["seconds"]
        parts = (
            f"{1e6 * seconds[name]:.1f}" for name in ("step", "physics", "task", "wrapper", "controller")
        )
        threads = "all cores" if row["threads"] == 0 else "one core"
        condition = (row["environment"], frequency_text(row), str(row["num_envs"]), threads)
        cells.append((*condition, *parts, row["controller_name"]))
    headers = (
        "environment",
        "control",
        "N",
        "physics on",
        "step",
        "physics",
        "task",
        "wrapper",
        "controller",
    )
    return Sheet(
        "costs", "µs per step of one environment", (*headers, "name of the controller"), tuple(cells)
    )


def reset_sheet(results: Results) -> Sheet:
    """Cost of a reset."""
    cells = []
    for row in results["costs"]["resets"]:
        times = (f"{1e6 * row['seconds'][name]:.0f}" for name in ("all", "one"))
        cells.append((row["environment"], str(row["num_envs"]), *times))
    headers = ("environment", "N", "reset of all, µs per environment", "reset of one, µs")
    return Sheet("resets", "resets", headers, tuple(cells))


def memory_sheet(results: Results) -> Sheet:
    """Memory per environment."""
    cells = tuple(
        (row["environment"], str(row["num_envs"]), f"{row['bytes_per_env'] / 1024:.1f}")
        for row in results["memory"]
    )
    return Sheet("memory", "memory", ("environment", "N", "KiB per environment"), cells)


def _singles(results: Results) -> Iterator[Sheet]:
    yield single_sheet("single", "single environments, one core", results["single"])


def _costs(results: Results) -> Iterator[Sheet]:
    yield cost_sheet(results)
    yield reset_sheet(results)


_BY_PART: Mapping[str, Callable[[Results], Iterator[Sheet]]] = {
    "single": _singles,
    "vector": vector_sheets,
    "peers": lambda results: iter([peer_sheet(results)]),
    "training": lambda results: iter([training_sheet(results)]),
    "costs": _costs,
    "memory": lambda results: iter([memory_sheet(results)]),
}


def sheets(results: Results) -> list[Sheet]:
    """Tables of the parts that a run measured; the goals come first."""
    found = [sheet for part, make in _BY_PART.items() if part in results for sheet in make(results)]
    shares = [share_sheet(results)] if {"single", "vector"} <= set(results) else []
    return [goal_sheet(results), *found, *shares]
