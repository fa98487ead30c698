"""`docs/performance.md`, made from the results of the benchmark alone."""

import json
import tomllib
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from string import Template
from typing import Any

from bench.engines import STORED, section
from bench.figures import memory_numbers, numbers
from bench.goals import Goal, goals
from bench.plot import draw
from bench.sheets import Sheet, markdown, sheets
from bench.single import ACTION_COUNT, ACTION_SHARE
from prp_gym.artifacts import write_file

Results = Mapping[str, Any]

PARTS = ("single", "vector", "peers", "training", "costs", "memory")
"""Parts without which the page is not written."""

_HERE = Path(__file__).parent
_EFFORT = ("rounds", "vector_rounds", "single_seconds", "seconds", "duration")
_VERSIONS = ("python", "prp-gym", "gymnasium", "mujoco", "numpy", "stable_baselines3", "torch")


def write_page(results: Results, folder: Path) -> None:
    """Write `performance.md` and `images/throughput.png`.

    Raises:
        OutputError: the folder cannot be written to.
    """
    write_file(folder / "images" / "throughput.png", draw(results["vector"]))
    write_file(folder / "performance.md", page(results).encode())


def page(results: Results) -> str:
    """The page as Markdown."""
    texts: dict[str, str] = {}
    for name, group in groupby(sheets(results), key=lambda sheet: sheet.name):
        texts[name] = "\n".join(map(_titled if name == "vector" else markdown, group)).rstrip()
    effort = results["effort"]
    facts = {
        "machine": machine_text(results),
        "missed": missed_text(goals(results), numbers(results)),
        "engines": section(json.loads(STORED.read_text(encoding="utf-8"))),
        "action_share": f"{ACTION_SHARE:g}",
        "action_count": str(ACTION_COUNT),
        **{name: f"{effort[name]:g}" for name in _EFFORT},
        **memory_numbers(results),
    }
    return Template((_HERE / "page.md").read_text(encoding="utf-8")).substitute(texts | facts)


def _titled(sheet: Sheet) -> str:
    return f"### {sheet.title}\n\n{markdown(sheet)}"


def machine_text(results: Results) -> str:
    """Machine and versions as a part of a sentence."""
    machine, versions = results["machine"], results["versions"]
    load = ", ".join(f"{value:.2f}" for value in machine["load_average"])
    listed = ", ".join(f"{name} {versions[name]}" for name in _VERSIONS)
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']} {machine['architecture']},"
        f" load average {load} at the start; {listed}"
    )


def missed_text(measured: Sequence[Goal], facts: Mapping[str, str]) -> str:
    """Explanations of what limits the missed goals."""
    missed = [goal for goal in measured if not goal.met]
    if not missed:
        return "Every goal is met."
    limits = tomllib.loads((_HERE / "limits.toml").read_text(encoding="utf-8"))
    parts = []
    for key, group in groupby(missed, key=lambda goal: goal.key):
        hows: dict[str, list[str]] = {}
        for goal in group:
            hows.setdefault(goal.what, []).append(goal.how)
        what = "; ".join(f"{name} ({' and '.join(found)})" for name, found in hows.items())
        text = " ".join(Template(limits[key]).substitute(facts).split())
        parts.append(f"**Missed: {what}.** {text}")
    return "\n\n".join(parts)
