"""Comparisons as tables for the terminal."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.comparison.effort import Effort
from prp_gym.comparison.statistics import Aggregate, PairwiseComparison, summarise, training_spread
from prp_gym.comparison.values import AGENT, FLOOR, Condition, Entry
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.statistics import Estimate
from prp_gym.evaluation.table import Row, evaluation_table, score_table
from prp_gym.robot.arrays import Array

_ABSENT = "-"
_WIDEST_NAME = 28  # with it the widest table of an evaluation holds in 120 columns
_SEPARATORS = " _-"
_THOUSAND, _MILLION = 1e3, 1e6


def short_id(environment_id: str) -> str:
    """An environment's id without the prefix and version of the suite's ids."""
    return environment_id.removeprefix("PRP-").removesuffix("-v0")


def fold(name: str, width: int = _WIDEST_NAME) -> str:
    """A name in lines of a width, broken after a space, an underscore or a hyphen where there is one."""
    lines = []
    while len(name) > width:
        breaks = [index + 1 for index in range(width) if name[index] in _SEPARATORS]
        end = width if name[width] == " " or not breaks else breaks[-1]
        lines.append(name[:end].rstrip())
        name = name[end:].lstrip()
    return "\n".join([*lines, name])


def condition_table(condition: Condition, seed: int) -> Table:
    """The policies under a condition with medians of the metrics, best score first.

    Args:
        condition: environment and scenario with their policies.
        seed: random seed of the bootstrap.
    """
    title = f"{condition.environment_id}, scenario {condition.scenario}"
    return evaluation_table(
        title, condition_rows(condition, seed), scoring_of(condition.environment_id).columns, "policy"
    )


def condition_scores(condition: Condition, seed: int) -> Table:
    """Scores and failures of the policies under a condition, best score first.

    Args:
        condition: environment and scenario with their policies.
        seed: random seed of the bootstrap.
    """
    title = f"{condition.environment_id}, scenario {condition.scenario}: scores"
    return score_table(title, condition_rows(condition, seed), "policy")


def condition_rows(condition: Condition, seed: int) -> list[Row]:
    """The rows of a condition's tables, without controllers with other gains.

    Args:
        condition: environment and scenario with their policies.
        seed: random seed of the bootstrap.
    """
    return [_row(entry, len(condition.seeds), seed) for entry in condition.entries]


def _row(entry: Entry, episodes: int, seed: int) -> Row:
    median = {name: _median(values) for name, values in entry.metrics.items()}
    summary = summarise(entry, seed)
    return Row(fold(entry.policy), episodes, summary, median, entry.compute_time, entry.kind == FLOOR)


def _median(values: Array) -> Array:
    """Median of the defined values over rows and episodes: (rows, episodes, components) -> (components)."""
    columns = values.reshape(-1, values.shape[-1]).T
    kept = [column[~np.isnan(column)] for column in columns]
    return np.array([np.median(column) if len(column) else np.nan for column in kept])


def pairwise_table(pairwise_comparisons: Iterable[PairwiseComparison]) -> Table:
    """The best controller against the best agent under every condition, one line each."""
    table = _make("best controller against best agent", ("environment", "best controller,\nbest agent"))
    _add(table, "score", "95 %\ninterval", "paired\ndiffer-\nence", "95 %\ninterval", "P(agent\nbetter)")
    _add(table, "dis-\njoint\ninter-\nvals", "better")
    for pairwise in pairwise_comparisons:
        difference, controller, agent = pairwise.difference, pairwise.controller_score, pairwise.agent_score
        table.add_row(short_id(pairwise.environment_id), fold(pairwise.controller), *_score(controller))
        table.add_row(
            f"  {pairwise.scenario}",
            fold(pairwise.agent),
            *_score(agent),
            f"{difference.value:+.3f}",
            f"{difference.low:+.3f} {difference.high:+.3f}",
            f"{pairwise.probability:.2f}",
            "yes" if pairwise.apart else "no",
            pairwise.verdict,
        )
    return table


def spread_table(conditions: Iterable[Condition]) -> Table:
    """Spread of the agents' scores over training seeds: median and range."""
    table = _make("agents by training seed", ("environment", "agent", "action mode"))
    _add(table, "training\nseeds", "median\nscore", "range")
    for condition in conditions:
        for entry in condition.of_kind(AGENT):
            spread = training_spread(entry)
            table.add_row(
                f"{short_id(condition.environment_id)}, {condition.scenario}",
                fold(entry.policy),
                fold(entry.mode),
                str(len(entry.training_seeds)),
                f"{spread.median:.3f}",
                f"{spread.low:.3f}-{spread.high:.3f}",
            )
    return table


def aggregate_table(aggregates: Iterable[Aggregate]) -> Table:
    """Families of policies over their tasks."""
    table = _make("score over all tasks", ("scenario", "policies"))
    _add(table, "tasks", "score", "95 %\ninterval", "best controller\non these tasks")
    for item in aggregates:
        reference = _ABSENT if math.isnan(item.reference.value) else f"{item.reference.value:.3f}"
        family = fold(item.family, 50)
        table.add_row(item.scenario, family, str(item.tasks), *_score(item.score), reference)
    return table


def effort_table(efforts: Sequence[Effort]) -> Table:
    """Training or tuning until the score of the best controller in the same scenario was reached."""
    table = _make(
        "learning effort: until the score of the best controller is reached", ("environment", "policy")
    )
    _add(table, "score to\nreach", "best\nscore", "reached\nby", "steps", "simulated\ns", "wall\nmin")
    _add(table, "total\nsimu-\nlated\ns", "viola-\ntions")
    for item in efforts:
        table.add_row(
            fold(f"{short_id(item.environment_id)}, {item.scenario}", 18),
            fold(item.policy, 26),
            f"{item.goal:.3f}",
            f"{item.best:.3f}",
            f"{item.reached} of {item.members}",
            _count(item.reach.steps),
            _count(item.reach.simulated_seconds),
            _count(item.reach.wall_minutes),
            _count(item.budget_seconds),
            _count(item.violations),
        )
    return table


def _make(title: str, headers: Iterable[str]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for header in headers:
        table.add_column(header, no_wrap=True, vertical="bottom")
    return table


def _add(table: Table, *headers: str) -> None:
    for header in headers:
        table.add_column(header, justify="right", no_wrap=True, vertical="bottom")


def _score(estimate: Estimate) -> tuple[str, str]:
    return f"{estimate.value:.3f}", f"{estimate.low:.3f}-{estimate.high:.3f}"


def _count(value: float) -> str:
    """A quantity in a few characters, with k for thousands and M for millions."""
    if math.isnan(value):
        return _ABSENT
    if math.isinf(value):
        return "never"
    if value >= _MILLION:
        return f"{value / _MILLION:.3g} M"
    return f"{value / _THOUSAND:.3g} k" if value >= _THOUSAND else f"{value:.3g}"
