"""The command `prp-gym reproduce`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from prp_gym.cli.options import FigureKind, Output, Plugins, RunName, TableFormat
from prp_gym.cli.shown import show_tables
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.reproduction.catalogue import Catalogue, load_catalogue
from prp_gym.reproduction.experiment import Experiment
from prp_gym.reproduction.outcome import FigureOutcome, fill, judge
from prp_gym.reproduction.report import write_data, write_index, write_summary
from prp_gym.reproduction.run import RecordedRun, check_names, record_run
from prp_gym.reproduction.table import answers_table, verdict_table
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.terminal import make_progress
from prp_gym.tables.formats import TERMINAL

_FAILED = 1


def reproduce_command(
    figure: Annotated[list[int] | None, typer.Option(help="Figure; repeatable. Default: all.")] = None,
    output: Output = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    figures: FigureKind = "png",
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
    folder = ResultFolder.choose("reproduce", output, name, sorted(figure or []), goes_on=False)
    with FolderLock(folder.path).hold(), folder.in_use():
        outcomes = _reproduce(chosen, catalogue, folder.path, figures)
        answers = fill(catalogue.answers, outcomes)
        command = shlex.join(["prp-gym", *sys.argv[1:]])
        write_summary(folder.path, outcomes, answers, command)
        write_index(folder.path, outcomes, answers, command, figures)
    notes = [f"figures, tables and explanations: {folder.path / 'index.md'}"]
    show_tables([verdict_table(outcomes), answers_table(answers)], notes, form)
    if any(verdict.word == "FAIL" for outcome in outcomes for verdict in outcome.verdicts):
        raise typer.Exit(_FAILED)


def _reproduce(
    chosen: list[Experiment], catalogue: Catalogue, output: Path, kind: str
) -> list[FigureOutcome]:
    """Simulate every run once, judge and draw every figure, under a progress bar."""
    names = list(dict.fromkeys(name for experiment in chosen for name in experiment.runs))
    recorded: dict[str, RecordedRun] = {}
    outcomes = []
    with make_progress() as progress:
        bar = progress.add_task("simulating", total=len(names) + len(chosen))
        for name in names:
            progress.update(bar, description=f"simulating {name}")
            recorded[name] = record_run(catalogue.runs[name])
            progress.advance(bar)
        for experiment in chosen:
            progress.update(bar, description=f"drawing figure {experiment.number}")
            outcomes.append(judge(experiment, recorded))
            write_data(output, outcomes[-1], kind)
            progress.advance(bar)
    return outcomes
