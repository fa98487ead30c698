"""The command `prp-gym reproduce`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from prp_gym.cli.options import (
    FigureFormat,
    Json,
    Plugins,
    Quiet,
    RunName,
    RunOutput,
    TableFormat,
)
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.reproduction.catalogue import Catalogue, load_catalogue
from prp_gym.reproduction.experiment import Experiment
from prp_gym.reproduction.outcome import FigureOutcome, fill, judge
from prp_gym.reproduction.report import SUMMARY, write_data, write_index, write_summary
from prp_gym.reproduction.run import RecordedRun, check_names, record_run
from prp_gym.reproduction.table import answers_table, verdict_table
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.tables.formats import TERMINAL

_FAILED = 1


def reproduce_command(
    figure: Annotated[
        list[int] | None, typer.Option(help="Number of a figure; repeatable.", show_default="all")
    ] = None,
    output: RunOutput = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    figure_format: FigureFormat = "png",
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
        for run in experiment.runs:
            check_names(catalogue.runs[run])
    terminal = Terminal.of(quiet, as_json, form)
    folder = ResultFolder.choose("reproduce", output, name, sorted(figure or []), goes_on=False)
    with FolderLock(folder.path).hold(), folder.in_use():
        outcomes = _reproduce(chosen, catalogue, folder.path, figure_format, terminal)
        answers = fill(catalogue.answers, outcomes)
        command = shlex.join(["prp-gym", *sys.argv[1:]])
        write_summary(folder.path, outcomes, answers, command)
        write_index(folder.path, outcomes, answers, command, figure_format)
    content = FileReader(RECORD_SIZE).read_json(folder.path / SUMMARY)
    told = f"figures, tables and explanations: {folder.path / 'index.md'}"
    terminal.report(content, [verdict_table(outcomes), answers_table(answers)], lines=[told])
    if any(verdict.word == "FAIL" for outcome in outcomes for verdict in outcome.verdicts):
        raise typer.Exit(_FAILED)


def _reproduce(
    chosen: list[Experiment], catalogue: Catalogue, output: Path, kind: str, terminal: Terminal
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
            write_data(output, outcome, kind)
            outcomes.append(outcome)
            progress.advance(1)
    return outcomes
