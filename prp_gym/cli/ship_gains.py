"""The command `prp-gym ship-gains`."""

from contextlib import closing
from pathlib import Path
from typing import Annotated

import typer

from prp_gym.cli.options import Plugins
from prp_gym.errors import InvalidValueError
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.runs.evaluation_job import make_environment
from prp_gym.runs.result_folder import latest_folder
from prp_gym.runs.search import RESULT
from prp_gym.runs.shipped_gains import searches_folder, ship_result
from prp_gym.runs.terminal import make_console
from prp_gym.tuning.tuned_controller import load_tuned_controller


def ship_gains_command(
    searches: Annotated[
        Path | None,
        typer.Option(help="Folder of the searches. Default: that of the latest `prp-gym tune-all`."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder for their records. Default: that of the package.")
    ] = None,
    plugin: Plugins = None,
) -> None:
    """Make the results of `tune-all` the `tuned` gains of their controllers, and keep their records.

    The gains are written into the data files of the controllers, each with the search that found it and its
    validation. Where a search found nothing better than its start, the gains stay as they are.
    """
    given = latest_folder("tune-all") if searches is None else searches
    results = sorted(given.glob(f"*/{RESULT}"))
    if not results:
        raise InvalidValueError("--searches", str(given), f"a folder of searches, each with a {RESULT}")
    for path in results:
        load_tuned_controller(path)  # so that a damaged one is refused before anything is written
    folder = searches_folder() if output is None else output
    console = make_console()
    with FolderLock(folder).hold():
        for path in results:
            found = load_tuned_controller(path)
            with closing(
                make_environment(found.environment, found.scenarios[0], found.control_frequency)
            ) as env:
                shipped = ship_result(path, env, folder)
            checked = found.validation
            told = "gains kept" if shipped.gains is None else f"written to {shipped.gains.name}"
            console.print(
                f"{found.environment} {found.controller}: {checked.score_of_start:.4f} -> "
                f"{checked.score:.4f}, {told}",
                highlight=False,
            )
    console.print(f"records: {folder}", highlight=False)
