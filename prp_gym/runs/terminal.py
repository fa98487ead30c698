"""Tables by environment and controller, and the console of the commands."""

from collections.abc import Iterable, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.console.consoles import make_console

__all__ = ["make_console", "make_matrix"]


def make_matrix(title: str, controllers: Iterable[str], rows: Iterable[tuple[str, Sequence[str]]]) -> Table:
    """A table of environments by controllers, whose names are broken at underscores.

    Args:
        title: title of the table.
        controllers: names of the columns.
        rows: an environment's id with a cell for each controller.
    """
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=0)
    table.add_column("environment", no_wrap=True)
    for name in controllers:
        table.add_column(name.replace("_", "\n"), justify="center", no_wrap=True)
    for environment_id, cells in rows:
        table.add_row(environment_id.removeprefix("PRP-").removesuffix("-v0"), *cells)
    return table
