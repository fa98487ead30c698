"""The command `prp-gym reproduce`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from prp_gym.cli.options import Json, Output, Plugins, Quiet
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.reproduction.catalogue import Catalogue, load_catalogue
from prp_gym.reproduction.experiment import Experiment
from prp_gym.reproduction.outcome import FigureOutcome, fill, judge
from prp_gym.reproduction.report import SUMMARY, write_figure, write_index, write_summary
from prp_gym.reproduction.run import RecordedRun, check_names, record_run
from prp_gym.reproduction.table import answers_table, verdict_table

_FAILED = 1


def reproduce_command(
    figure: Annotated[
        list[int] | None, typer.Option(help="Number of a figure; repeatable.", show_default="all")
    ] = None,
    output: Output = Path("results/reproduction"),
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Run the report's experiments again: figures, and closed forms beside what is measured.

    The exit code is 1 if a measured value lies outside its tolerance and outside what an explanation allows.
    """
    catalogue = load_catalogue()
    chosen = catalogue.choose(figure or [])
    for experiment in chosen:
        for name in experiment.runs:
            check_names(catalogue.runs[name])
    terminal = Terminal(quiet, as_json)
    with FolderLock(output).hold():
        outcomes = _reproduce(chosen, catalogue, output, terminal)
        answers = fill(catalogue.answers, outcomes)
        command = shlex.join(["prp-gym", *sys.argv[1:]])
        write_summary(output, outcomes, answers, command)
        write_index(output, outcomes, answers, command)
    if as_json:
        terminal.document(FileReader(RECORD_SIZE).read_json(output / SUMMARY))
    terminal.show(verdict_table(outcomes), answers_table(answers))
    terminal.show(f"figures, tables and explanations: {output / 'index.md'}")
    if any(verdict.word == "FAIL" for outcome in outcomes for verdict in outcome.verdicts):
        raise typer.Exit(_FAILED)


def _reproduce(
    chosen: list[Experiment], catalogue: Catalogue, output: Path, terminal: Terminal
) -> list[FigureOutcome]:
    """Simulate every run once, judge and draw every figure."""
    names = list(dict.fromkeys(name for experiment in chosen for name in experiment.runs))
    recorded: dict[str, RecordedRun] = {}
    outcomes: list[FigureOutcome] = []

    def kept() -> str:
        drawn = f"{len(outcomes)} of {len(chosen)} figures are kept in {output}"
        return f"{drawn}; the same command starts over" if outcomes else ""

    with (
        kept_if_interrupted(kept),
        terminal.progress("reproducing", len(names) + len(chosen), "runs and figures") as progress,
    ):
        for name in names:
            progress.run([Activity(name)])
            recorded[name] = record_run(catalogue.runs[name])
            progress.advance(1)
        for experiment in chosen:
            progress.run([Activity(f"figure {experiment.number}")])
            outcome = judge(experiment, recorded)
            write_figure(output, outcome)
            outcomes.append(outcome)
            progress.advance(1)
    return outcomes
