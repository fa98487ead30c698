"""The part of the page on learned agents that shows what stock algorithms learn."""

from pathlib import Path
from typing import Any

from bench.learn_check import STEPS, goal_text, read_results
from docs.tables import table

PAGE = Path(__file__).with_name("learning.md")
_BEGIN, _END = "<!-- learn-check: begin -->\n", "<!-- learn-check: end -->\n"


def learning_page() -> str:
    """The page as it is, with the present results between its two comments."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(_BEGIN)
    return f"{before}{_BEGIN}\n{_section()}\n{_END}{rest.partition(_END)[2]}"


def _section() -> str:
    """The table of all results, the bad ones too, and the goals."""
    runs = read_results()["runs"]
    if not runs:
        return "No results are stored.\n"
    found: dict[str, dict[str, Any]] = {}
    for run in runs:
        found.setdefault(run["task"], {})[run["algorithm"]] = run
    headers = ["task", "zero torque"]
    for name, steps in STEPS.items():
        headers += [f"{name} untrained", f"{name}, {steps // 1000} k steps", "difference from zero torque"]
    rows = [_row(task, by_algorithm) for task, by_algorithm in found.items()]
    return table(headers, rows) + "\n" + "; ".join(goal_text(runs)) + ".\n"


def _row(task: str, runs: dict[str, dict[str, Any]]) -> list[str]:
    zero = next(iter(runs.values()))["zero_torque"]
    cells = [task, f"{zero:.3f}"]
    for name in STEPS:
        run = runs.get(name)
        difference = "-" if run is None else f"{run['after'] - run['zero_torque']:+.3f}"
        cells += (
            ["-", "-", "-"] if run is None else [f"{run['before']:.3f}", f"{run['after']:.3f}", difference]
        )
    return cells
