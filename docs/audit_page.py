"""The page on the audit of the rewards, and the summary of the audit's results on which it is based."""

import json
import sys
from pathlib import Path
from typing import Any

from docs.tables import table
from prp_gym.comparison.audit import LEAST_CORRELATION, LEAST_POLICIES, STANDARD_ERRORS
from prp_gym.comparison.audit_jobs import UNAWARE
from prp_gym.tasks.setup import MUJOCO

SUMMARY = Path(__file__).resolve().parent.parent / "bench" / "audit.json"
_DIGITS = 4
_ABSENT = "-"


def audit_page() -> str:
    """The page, from the stored summary."""
    stored = json.loads(SUMMARY.read_text(encoding="utf-8")) if SUMMARY.exists() else {"audits": []}
    audits = stored["audits"]
    text = (
        "# Audit of the rewards\n\nA score is worth something if it ranks policies as a control engineer"
        " would. `make audit` runs, for every task in scenario `realistic`, all controllers with each of"
        " their gain sets, the intended ones with random gains, the trained agents, the floors, and policies"
        " that exploit"
        " a reward instead of doing the task; then it compares their mean scores with criteria that are not"
        " the reward's own signals. [Metrics](metrics.md#criteria-of-the-audit) defines the criteria. The"
        f" correlation is Goodman and Kruskal's γ: of every two policies that a criterion distinguishes,"
        " the share that the score ranks alike less the share that it ranks oppositely. A criterion"
        f" distinguishes two policies if their mean difference over the episodes exceeds {STANDARD_ERRORS:g}"
        " standard errors: what chance alone may have decided says nothing about the score. γ has to exceed"
        f" {LEAST_CORRELATION:g} over at least {LEAST_POLICIES} policies, and no policy of the best tenth by"
        " score may be in the worse half by a criterion. γ over all cases of two policies, however small"
        " their difference, and Spearman's correlation are shown beside it; the latter stays below 1 where"
        " many policies are equally bad. The command fails where a reward contradicts a criterion.\n\n"
    )
    if not audits:
        return text + "No results are stored.\n"
    return f"{text}{_engines(audits)}{_correlations(audits)}\n{_unaware(audits)}"


def _engines(audits: list[dict[str, Any]]) -> str:
    """Which engines other than the reference simulated the episodes."""
    names = sorted({audit.get("engine", MUJOCO) for audit in audits} - {MUJOCO})
    return "".join(f"Simulated with the engine `{name}`.\n\n" for name in names)


def _correlations(audits: list[dict[str, Any]]) -> str:
    rows = []
    for audit in audits:
        for item in audit["findings"]:
            value, low, high = (item["correlation"][name] for name in ("value", "low", "high"))
            verdict = ("yes" if item["holds"] else "**no**") if item["required"] else "reported"
            offenders = str(len(item["offenders"])) if item["required"] else _ABSENT
            cells = (
                f"{_number(value)} ({_number(low)} to {_number(high)})",
                f"{100.0 * item['counted']:.0f} %",
                _number(item["unfiltered"]),
                _number(item["spearman"]),
            )
            policies = str(len(audit["policies"]))
            rows.append((audit["environment_id"], item["metric"], policies, *cells, offenders, verdict))
    headers = (
        "environment",
        "criterion",
        "policies",
        "γ (95 % interval)",
        "cases distinguished",
        "γ over all cases",
        "Spearman",
        "bad among best",
        "holds",
    )
    return table(headers, rows)


def _unaware(audits: list[dict[str, Any]]) -> str:
    """Scores and ranks of the policies that do not attempt a task."""
    rows = []
    for audit in audits:
        scores = dict(zip(audit["policies"], audit["scores"], strict=True))
        ranked = sorted(audit["scores"], reverse=True)
        cells = [
            f"{scores[name]:.3f} ({ranked.index(scores[name]) + 1})" if name in scores else _ABSENT
            for name in UNAWARE
        ]
        rows.append((audit["environment_id"], f"{ranked[0]:.3f}", *cells))
    text = (
        "## Policies that do not attempt the task\n\nMean score, and rank among all policies of the audit."
        " Pushing blindly with the desired force is the controller `force_feedforward`.\n\n"
    )
    names = (f"`{name}`" for name in UNAWARE)
    return text + table(("environment", "best policy", *names), rows)


def _number(value: float | None) -> str:
    return _ABSENT if value is None else f"{value:.2f}"


def main() -> None:
    """Store the summary of the results of `prp-gym audit`, whose path is the argument."""
    audits = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["audits"]
    kept = {"command": "make audit", "audits": [_rounded(audit) for audit in audits]}
    SUMMARY.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _rounded(value: Any) -> Any:
    """Plain values with numbers of few digits, without the criteria of every single policy."""
    if isinstance(value, float):
        return round(value, _DIGITS)
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if isinstance(value, dict):
        return {name: _rounded(item) for name, item in value.items() if name != "values"}
    return value


if __name__ == "__main__":
    main()
