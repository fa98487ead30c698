"""Tables of an audit."""

import math
from collections.abc import Iterable, Sequence

from prp_gym.comparison.audit import Audit, Finding
from prp_gym.evaluation.rollout import engine_suffix
from prp_gym.tables import ABSENT, Cell, ResultTable, TableColumn
from prp_gym.tables.column import interval_column, text_column
from prp_gym.tables.matrix import id_cell

_CONDITION = (text_column("environment"), text_column("scenario"))
_CRITERIA = (
    *(*_CONDITION, text_column("criterion"), TableColumn("policies")),
    TableColumn("rank corre\u00adlation γ with score"),
    interval_column("95 % interval"),
    TableColumn("cases distin\u00adguished", ("%",)),
    TableColumn("γ over all cases"),
    TableColumn("Spear\u00adman's corre\u00adlation"),
    TableColumn("bad among the best by score"),
    text_column("score agrees"),
)


def audit_table(audits: Sequence[Audit]) -> ResultTable:
    """The correlation of the score with every criterion."""
    title = f"score against the criteria of the tasks{engine_suffix(item.engine for item in audits)}"
    rows = [_finding(item, finding) for item in audits for finding in item.findings]
    return ResultTable.of(title, _CRITERIA, rows)


def _finding(item: Audit, finding: Finding) -> tuple[Cell | str, ...]:
    holds = Cell("yes", True, "good") if finding.holds else Cell("NO", False, "bad")
    return (
        *(id_cell(item.environment_id), item.scenario, finding.metric, Cell.of(len(item.policies))),
        *_correlation(finding),
        Cell.number(100.0 * finding.counted, ".0f"),
        Cell.number(finding.unfiltered, ".2f"),
        Cell.number(finding.spearman, ".2f"),
        Cell.of(len(finding.offenders)) if finding.required else ABSENT,
        holds if finding.required else Cell("reported", None),
    )


def unaware_table(audits: Iterable[Audit], names: Sequence[str]) -> ResultTable:
    """Scores and ranks of the policies that do not attempt the task."""
    title = "score (rank among all policies) of policies that do not attempt the task"
    columns = (
        *(*_CONDITION, TableColumn("best policy")),
        *(TableColumn(name, parts=("score", "rank")) for name in names),
    )
    rows: list[tuple[Cell | str, ...]] = []
    for item in audits:
        ranked = sorted(item.scores, reverse=True)
        scores = dict(zip(item.policies, item.scores, strict=True))
        cells = [_ranked(scores[name], ranked) if name in scores else ABSENT for name in names]
        rows.append((id_cell(item.environment_id), item.scenario, Cell.number(ranked[0]), *cells))
    return ResultTable.of(title, columns, rows)


def _ranked(score: float, scores: Sequence[float]) -> Cell:
    """A score with its rank among all scores, the highest of which come first."""
    rank = scores.index(score) + 1
    return Cell(f"{score:.3f} ({rank})", (score, rank))


def _correlation(finding: Finding) -> tuple[Cell, Cell]:
    value, low, high = finding.correlation
    if math.isnan(value):
        return ABSENT, ABSENT
    return Cell.number(value, ".2f"), Cell(f"{low:.2f} {high:.2f}", (low, high))
