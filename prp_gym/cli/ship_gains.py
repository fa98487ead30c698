"""The command `prp-gym ship-gains`."""

from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import typer

from prp_gym.cli.options import Json, OutputOfPackage, Plugins, Quiet
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.runs.evaluation_job import make_environment
from prp_gym.runs.result_folder import latest_folder
from prp_gym.runs.search import RESULT
from prp_gym.runs.shipped_gains import Shipped, searches_folder, ship_result
from prp_gym.tuning.tuned_controller import TunedController, load_tuned_controller


def ship_gains_command(
    searches: Annotated[
        Path | None,
        typer.Option(help="Folder of the searches.", show_default="that of the latest prp-gym tune-all"),
    ] = None,
    output: OutputOfPackage = None,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Make the results of `tune-all` the `tuned` gains of their controllers, and keep their records.

    The records are written into the folder of the package unless --output names another. The gains are
    written into the data files of the controllers, each with the search that found it and its validation.
    Where a search found nothing better than its start, the gains stay as they are.
    """
    given = latest_folder("tune-all") if searches is None else searches
    results = sorted(given.glob(f"*/{RESULT}"))
    if not results:
        raise InvalidValueError("--searches", str(given), f"a folder of searches, each with a {RESULT}")
    for path in results:
        load_tuned_controller(path)  # so that a damaged one is refused before anything is written
    folder = searches_folder() if output is None else output
    terminal = Terminal.of(quiet, as_json)
    kept: list[str] = []
    rows: list[dict[str, Any]] = []
    with (
        FolderLock(folder).hold(),
        kept_if_interrupted(lambda: f"the gains of {len(kept)} of {len(results)} searches are written"),
        terminal.progress("writing gains", len(results), "searches") as progress,
    ):
        for path in results:
            found = load_tuned_controller(path)
            name = f"{found.environment} {found.controller}"
            progress.run([Activity(name)])
            with closing(
                make_environment(found.environment, found.scenarios[0], found.control_frequency)
            ) as env:
                shipped = ship_result(path, env, folder)
            rows.append(_row(found, shipped))
            kept.append(name)
            progress.advance(1)
    lines = [*map(_line, rows), f"records: {folder}"]
    terminal.report({"records": str(folder), "searches": rows}, lines=lines)


def _row(found: TunedController, shipped: Shipped) -> dict[str, Any]:
    """What became of one search, for the document."""
    return {
        "environment": found.environment,
        "controller": found.controller,
        "score_of_start": found.validation.score_of_start,
        "score": found.validation.score,
        "written_to": None if shipped.gains is None else shipped.gains.name,
    }


def _line(row: dict[str, Any]) -> str:
    """What became of one search, as a line."""
    told = "gains kept" if row["written_to"] is None else f"written to {row['written_to']}"
    scores = f"{row['score_of_start']:.4f} -> {row['score']:.4f}"
    return f"{row['environment']} {row['controller']}: {scores}, {told}"
