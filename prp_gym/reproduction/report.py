"""Files of a reproduction: figures, their data, `summary.json` and `index.md`."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from prp_gym.artifacts import write_file, write_json
from prp_gym.evaluation.results import describe_run
from prp_gym.figures.figure_file import write_figure
from prp_gym.reproduction.experiment import Answer
from prp_gym.reproduction.figures import draw, table
from prp_gym.reproduction.outcome import FigureOutcome, Verdict, show, unit_of
from prp_gym.reproduction.run import SCENARIO, RecordedRun

Answers = Sequence[tuple[Answer, str]]

SUMMARY = "summary.json"
_HIDDEN_SETTINGS = ("model",)


def write_data(folder: Path, outcome: FigureOutcome, kind: str) -> None:
    """Write a figure, such as `figure_NN.png`, and its data, `figure_NN.csv`.

    Args:
        folder: folder of the files.
        outcome: figure with its runs and checks.
        kind: kind of the figure's file: `png`, `svg` or `pdf`.

    Raises:
        OutputError: the folder cannot be written to.
    """
    name = _name(outcome)
    write_figure(folder / f"{name}.{kind}", draw(outcome))
    write_file(folder / f"{name}.csv", table(outcome).encode())


def _name(outcome: FigureOutcome) -> str:
    return f"figure_{outcome.experiment.number:02d}"


def write_summary(folder: Path, outcomes: Sequence[FigureOutcome], answers: Answers, command: str) -> None:
    """Write `summary.json`: every check and run, the answers, versions and machine.

    Raises:
        OutputError: the folder cannot be written to.
    """
    about = describe_run(command)
    about["versions"] |= {"matplotlib": version("matplotlib")}
    del about["units"]  # of metrics; each check states its own
    checks = [_describe_check(outcome, verdict) for outcome in outcomes for verdict in outcome.verdicts]
    recorded = {name: item for outcome in outcomes for name, item in outcome.recorded.items()}
    runs = {name: _describe_recorded(item) for name, item in recorded.items()}
    texts = {answer.question: {"asks": answer.asks, "answer": text} for answer, text in answers}
    write_json(folder / SUMMARY, {**about, "checks": checks, "runs": runs, "answers": texts})


def _describe_check(outcome: FigureOutcome, verdict: Verdict) -> dict[str, Any]:
    check = verdict.check
    return {
        "figure": outcome.experiment.number,
        "question": check.question,
        "name": check.name,
        "what": check.what,
        "unit": check.unit,
        "run": check.measure.run,
        "measurement": {"name": check.measure.name, **check.measure.arguments},
        "prediction": check.predict.text,
        "predicted": verdict.predicted,
        "measured": verdict.measured,
        "tolerance": verdict.tolerance,
        "reason": check.reason,
        "verdict": verdict.word,
        "explanation": check.explanation,
        "explained_tolerance": check.explained_tolerance,
    }


def _describe_recorded(recorded: RecordedRun) -> dict[str, Any]:
    run = recorded.run
    return {
        "environment": run.environment,
        "scenario": SCENARIO,
        "keywords": _keywords(recorded),
        "options": run.options,
        "baseline": run.controller,
        "gains": run.gains,
        "gains_source": recorded.gains_source,
        "overrides": run.overrides,
        "settings": _settings(recorded),
        "seed": run.seed,
        "diverged": recorded.rollout.diverged,
    }


def _keywords(recorded: RecordedRun) -> dict[str, Any]:
    run = recorded.run
    limit = {"torque_limit": None} if run.unlimited_torque else {}
    times = {"control_frequency": run.control_frequency, "duration": run.duration}
    return {**times, **limit, **run.keywords}


def _settings(recorded: RecordedRun) -> Mapping[str, Any]:
    return {name: value for name, value in recorded.settings.items() if name not in _HIDDEN_SETTINGS}


def write_index(
    folder: Path, outcomes: Sequence[FigureOutcome], answers: Answers, command: str, kind: str
) -> None:
    """Write `index.md`: the answers, then every figure with its runs, checks and explanations.

    Raises:
        OutputError: the folder cannot be written to.
    """
    parts = ["# Reproduction of the report's experiments\n", f"Written by `{command}`.\n", _counts(outcomes)]
    if answers:
        parts.append("## Answers\n")
        parts += [f"**{answer.question} {answer.asks}** {text}\n" for answer, text in answers]
    parts += [_section(outcome, kind) for outcome in outcomes]
    write_file(folder / "index.md", "\n".join(parts).encode())


def _counts(outcomes: Sequence[FigureOutcome]) -> str:
    words = [verdict.word for outcome in outcomes for verdict in outcome.verdicts]
    counts = ", ".join(f"{words.count(word)} {word}" for word in ("pass", "explained", "FAIL"))
    return f"{len(outcomes)} figures, {len(words)} checks: {counts}.\n"


def _section(outcome: FigureOutcome, kind: str) -> str:
    experiment, name = outcome.experiment, _name(outcome)
    parts = [
        f"## Figure {experiment.number}: {experiment.title}\n",
        f"![Figure {experiment.number}]({name}.{kind})\n",
        f"Section {experiment.section} of the report; data: [{name}.csv]({name}.csv).\n",
        *(_setup(recorded) for recorded in outcome.recorded.values()),
        "",
        _checks(outcome.verdicts),
    ]
    if experiment.reading:
        parts.append(f"**The report's figure.** {experiment.reading}\n")
    explanations = [experiment.explanation, *map(_explanation, outcome.verdicts)]
    parts += [f"**Explanation.** {text}\n" for text in explanations if text]
    return "\n".join(parts)


def _explanation(verdict: Verdict) -> str:
    """Explanation of a deviation that it covers; empty without such a deviation."""
    if verdict.word != "explained":
        return ""
    check = verdict.check
    bound = f"up to {show(verdict.widest, digits=2)} [{unit_of(check)}]"
    return f"{check.what}, {bound}: {check.explanation}"


def _setup(recorded: RecordedRun) -> str:
    run = recorded.run
    keywords = ", ".join(f"{name}={value!r}" for name, value in _keywords(recorded).items())
    numbers = {**_settings(recorded), **run.overrides}
    settings = ", ".join(f"{name} {_plain(value)}" for name, value in numbers.items())
    options = f", reset options {dict(run.options)}" if run.options else ""
    return (
        f"- {run.label}: `{run.controller}`, gains `{run.gains}` ({settings}; {recorded.gains_source}), on"
        f" `{run.environment}` ({keywords}{options})"
    )


def _plain(value: Any) -> str:
    return str(value.tolist() if hasattr(value, "tolist") else value)


def _checks(verdicts: Sequence[Verdict]) -> str:
    header = ("question", "quantity", "formula", "prediction", "measured", "tolerance", "verdict")
    rows = [header, ("---",) * len(header), *(_row(verdict) for verdict in verdicts)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n"


def _row(verdict: Verdict) -> tuple[str, ...]:
    check = verdict.check
    cells = (
        check.question,
        f"{check.what} [{unit_of(check)}]",
        check.predict.text,
        show(verdict.predicted),
        show(verdict.measured),
        f"{show(verdict.tolerance, digits=2)}: {check.reason}",
        verdict.word,
    )
    return tuple(cell.replace("|", "\\|") for cell in cells)
