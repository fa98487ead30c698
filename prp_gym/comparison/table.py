"""Comparisons as tables."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from prp_gym.comparison.effort import Effort
from prp_gym.comparison.statistics import Aggregate, PairwiseComparison, summarise, training_spread
from prp_gym.comparison.values import AGENT, FLOOR, Condition, Entry
from prp_gym.evaluation.rollout import condition_name
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.statistics import Estimate
from prp_gym.evaluation.table import Row, evaluation_table, score_table
from prp_gym.robot.arrays import Array
from prp_gym.tables import ABSENT, Cell, ResultTable, TableColumn
from prp_gym.tables.column import interval_column, text_column
from prp_gym.tables.matrix import id_cell

_WIDEST_NAME, _NARROW = 28, 16  # characters of a name in one line
_ENVIRONMENT, _SCENARIO = text_column("environment"), text_column("scenario")
_AGENT = text_column("agent", _WIDEST_NAME)
_SCORE = (TableColumn("score"), interval_column("95 % interval"))
_BLANK = Cell("", None)  # in the line of the controller, whose comparison is in that of the agent
_THOUSAND, _MILLION = 1e3, 1e6


def condition_table(condition: Condition, seed: int) -> ResultTable:
    """The policies under a condition with medians of the metrics, best score first.

    Args:
        condition: environment and scenario with their policies.
        seed: random seed of the bootstrap.
    """
    title = _title(condition)
    return evaluation_table(
        title, condition_rows(condition, seed), scoring_of(condition.environment_id).columns, "policy"
    )


def condition_scores(condition: Condition, seed: int) -> ResultTable:
    """Scores and failures of the policies under a condition, best score first.

    Args:
        condition: environment and scenario with their policies.
        seed: random seed of the bootstrap.
    """
    return score_table(f"{_title(condition)}: scores", condition_rows(condition, seed), "policy")


def _title(condition: Condition) -> str:
    return condition_name(condition.environment_id, condition.scenario, condition.engine)


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
    return Row(entry.policy, episodes, summary, median, entry.compute_time, entry.kind == FLOOR)


def _median(values: Array) -> Array:
    """Median of the defined values over rows and episodes: (rows, episodes, components) -> (components)."""
    columns = values.reshape(-1, values.shape[-1]).T
    kept = [column[~np.isnan(column)] for column in columns]
    return np.array([np.median(column) if len(column) else np.nan for column in kept])


def pairwise_table(pairwise_comparisons: Iterable[PairwiseComparison]) -> ResultTable:
    """The best controller against the best agent under every condition, one line each."""
    columns = (
        *(
            _ENVIRONMENT,
            _SCENARIO,
            text_column("best con\u00adtroller, then best agent", _NARROW),
            *_SCORE,
        ),
        TableColumn("agent minus con\u00adtroller"),
        interval_column("95 % interval of the differ\u00adence"),
        TableColumn("proba\u00adbility that agent is better"),
        text_column("dis\u00adjoint inter\u00advals"),
        text_column("better"),
    )
    rows: list[tuple[Cell | str, ...]] = []
    for pairwise in pairwise_comparisons:
        difference, where = pairwise.difference, (id_cell(pairwise.environment_id), pairwise.scenario)
        rows.append((*where, pairwise.controller, *_score(pairwise.controller_score), *(_BLANK,) * 5))
        found = (
            Cell.number(difference.value, "+.3f"),
            Cell(f"{difference.low:+.3f} {difference.high:+.3f}", (difference.low, difference.high)),
            Cell.number(pairwise.probability, ".2f"),
            "yes" if pairwise.apart else "no",
            pairwise.verdict,
        )
        rows.append((*where, pairwise.agent, *_score(pairwise.agent_score), *found))
    return ResultTable.of("best controller against best agent", columns, rows)


def spread_table(conditions: Iterable[Condition]) -> ResultTable:
    """Spread of the agents' scores over training seeds: median and range."""
    columns = (
        *(_ENVIRONMENT, _SCENARIO, _AGENT, text_column("action mode", _WIDEST_NAME)),
        *(TableColumn("training seeds"), TableColumn("median score")),
        TableColumn("range of scores", parts=("low", "high")),
    )
    rows = []
    for condition in conditions:
        for entry in condition.of_kind(AGENT):
            spread = training_spread(entry)
            rows.append(
                (
                    *(id_cell(condition.environment_id), condition.scenario, entry.policy, entry.mode),
                    *(Cell.of(len(entry.training_seeds)), Cell.number(spread.median)),
                    Cell(f"{spread.low:.3f}-{spread.high:.3f}", (spread.low, spread.high)),
                )
            )
    return ResultTable.of("agents by training seed", columns, rows)


def aggregate_table(aggregates: Iterable[Aggregate]) -> ResultTable:
    """Families of policies over their tasks."""
    columns = (
        *(_SCENARIO, text_column("policies", 50), TableColumn("tasks"), *_SCORE),
        TableColumn("score of best controller on these tasks"),
    )
    rows = [
        (
            *(item.scenario, item.family, Cell.of(item.tasks)),
            *(*_score(item.score), Cell.number(item.reference.value)),
        )
        for item in aggregates
    ]
    return ResultTable.of("score over all tasks", columns, rows)


def effort_table(efforts: Sequence[Effort]) -> ResultTable:
    """Training or tuning until the score of the best controller in the same scenario was reached."""
    columns = (
        *(_ENVIRONMENT, _SCENARIO, text_column("policy", _WIDEST_NAME)),
        *(TableColumn("score to reach"), TableColumn("best score"), text_column("reached by")),
        *(
            TableColumn("steps"),
            TableColumn("simu\u00adlated time", ("s",)),
            TableColumn("wall time", ("min",)),
        ),
        TableColumn("simu\u00adlated time in all", ("s",)),
        TableColumn("viola\u00adtions in all"),
    )
    rows = [
        (
            *(id_cell(item.environment_id), item.scenario, item.policy),
            *(Cell.number(item.goal), Cell.number(item.best), f"{item.reached} of {item.members}"),
            *(_count(item.reach.steps), _count(item.reach.simulated_seconds)),
            *(_count(item.reach.wall_minutes), _count(item.budget_seconds), _count(item.violations)),
        )
        for item in efforts
    ]
    return ResultTable.of("learning effort: until the score of the best controller is reached", columns, rows)


def _score(estimate: Estimate) -> tuple[Cell, Cell]:
    interval = Cell(f"{estimate.low:.3f}-{estimate.high:.3f}", (estimate.low, estimate.high))
    return Cell.number(estimate.value), interval


def _count(value: float) -> Cell:
    """A quantity in a few characters, with k for thousands and M for millions."""
    return ABSENT if math.isnan(value) else Cell(_short(value), value)


def _short(value: float) -> str:
    if math.isinf(value):
        return "never"
    if value >= _MILLION:
        return f"{value / _MILLION:.3g} M"
    return f"{value / _THOUSAND:.3g} k" if value >= _THOUSAND else f"{value:.3g}"
