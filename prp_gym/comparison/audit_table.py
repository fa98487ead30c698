"""Tables of an audit."""

import math
from collections.abc import Iterable, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.comparison.audit import Audit, Finding
from prp_gym.comparison.table import short_id

_ABSENT = "-"


def audit_table(audits: Iterable[Audit]) -> Table:
    """The correlation of the score with every criterion."""
    table = _make("score against the criteria of the tasks", ("environment", "scenario", "criterion"))
    for header in (
        "policies",
        "rank corre-\nlation γ",
        "95 %\ninterval",
        "Spear-\nman",
        "bad among\nthe best",
        "holds",
    ):
        table.add_column(header, justify="right", no_wrap=True, vertical="bottom")
    for item in audits:
        for finding in item.findings:
            table.add_row(
                short_id(item.environment_id),
                item.scenario,
                finding.metric,
                str(len(item.policies)),
                *_correlation(finding),
                _ABSENT if math.isnan(finding.spearman) else f"{finding.spearman:.2f}",
                str(len(finding.offenders)) if finding.required else _ABSENT,
                ("yes" if finding.holds else "NO") if finding.required else "reported",
            )
    return table


def unaware_table(audits: Iterable[Audit], names: Sequence[str]) -> Table:
    """Scores and ranks of the policies that do not attempt the task."""
    table = _make(
        "score (rank among all policies) of policies that do not attempt the task", ("environment",)
    )
    for name in ("best policy", *names):
        table.add_column(name.replace("_", "\n").replace(" ", "\n"), justify="right", vertical="bottom")
    for item in audits:
        ranked = sorted(item.scores, reverse=True)
        scores = dict(zip(item.policies, item.scores, strict=True))
        cells = [
            f"{scores[name]:.3f} ({ranked.index(scores[name]) + 1})" if name in scores else _ABSENT
            for name in names
        ]
        table.add_row(short_id(item.environment_id), f"{ranked[0]:.3f}", *cells)
    return table


def _correlation(finding: Finding) -> tuple[str, str]:
    value, low, high = finding.correlation
    if math.isnan(value):
        return _ABSENT, _ABSENT
    return f"{value:.2f}", f"{low:.2f} {high:.2f}"


def _make(title: str, headers: Iterable[str]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for header in headers:
        table.add_column(header, no_wrap=True, vertical="bottom")
    return table
