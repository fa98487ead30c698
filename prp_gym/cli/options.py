"""Options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

from prp_gym.checks import choice
from prp_gym.figures.figure_file import SUFFIXES
from prp_gym.plugins import load_plugins
from prp_gym.tables.formats import FORMATS, TERMINAL


def _load(modules: list[str] | None) -> list[str] | None:
    load_plugins(modules or [])
    return modules


def _check_format(value: str) -> str:
    return choice("--format", value, FORMATS)


def _check_kind(value: str) -> str:
    return choice("--figures", value, [suffix[1:] for suffix in SUFFIXES])


Plugins = Annotated[
    list[str] | None,
    typer.Option(
        "--plugin",
        help="Module that declares tasks, controllers or the like and is not installed as a plugin, also one "
        "of the current folder; repeatable.",
        callback=_load,
        is_eager=True,  # names that a plugin declares may stand in other options
    ),
]
Environments = Annotated[list[str] | None, typer.Option(help="Environment id; repeatable. Default: all.")]
ControllerNames = Annotated[
    list[str] | None,
    typer.Option(
        "--baseline",
        help="Controller, or your own as path/to/file.py:Name or package.module:Name; repeatable. "
        "Default: all.",
    ),
]
Gains = Annotated[
    str, typer.Option(help="Gains of the controllers: the name of a gain set, or a TOML file of settings.")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="Setting of the controllers in place of that of their gains, with a value in TOML, such as "
        "stiffness=200; repeatable.",
    ),
]
FirstSeed = Annotated[int, typer.Option(help="Seed of the first episode.")]
ParallelWorkers = Annotated[
    int,
    typer.Option(
        help="Parallel workers; 1: this process alone, 0: as many as there are cores. "
        "Compute times are those of a busy machine unless 1."
    ),
]
Backend = Annotated[
    str, typer.Option(help="loky: processes; ray: the cluster at RAY_ADDRESS, or a local one.")
]
Fresh = Annotated[
    bool, typer.Option("--fresh", help="Run also the jobs that an interrupted run has finished.")
]

Output = Annotated[
    Path | None,
    typer.Option(help="Folder of the results, used as it is. Default: results/<command>/<date and time>."),
]
RunName = Annotated[
    str, typer.Option("--name", help="Name that is added to the default folder's date and time.")
]
TableFormat = Annotated[
    str,
    typer.Option(
        "--format",
        help=f"Form of the tables: {', '.join(FORMATS)}. With any but {TERMINAL}, only the tables go to "
        "standard output.",
        callback=_check_format,
    ),
]
FigureKind = Annotated[
    str,
    typer.Option("--figures", help="Kind of the figures: png; svg or pdf for papers.", callback=_check_kind),
]
