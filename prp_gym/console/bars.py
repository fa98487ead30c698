"""`Bars`: progress in a terminal, as bars that leave nothing behind."""

import math
from collections.abc import Sequence

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, ProgressColumn, Task, TaskID, TextColumn
from rich.progress import Progress as RichProgress
from rich.table import Column
from rich.text import Text

from prp_gym.console.activity import Activity
from prp_gym.console.progress import duration, time_left

_BAR_WIDTH, _NAME_WIDTH = 10, 26  # columns, so that all fit into 80
_MOST_BARS = 8  # of work that is under way


class _AmountColumn(MofNCompleteColumn):
    """What is done of the total, if that is known."""

    def render(self, task: Task) -> Text:
        """The cell of one bar."""
        return Text("") if task.total is None else super().render(task)


class _TimeColumn(ProgressColumn):
    """Elapsed time, and the time that is left as soon as it is known."""

    def render(self, task: Task) -> Text:
        """The cell of one bar."""
        if not task.fields.get("timed"):
            return Text("")
        elapsed = task.elapsed or 0.0
        total = math.inf if task.total is None else task.total
        left = time_left(elapsed, task.completed, task.fields["before"], total)
        return Text(duration(elapsed) + ("" if math.isnan(left) else f", {duration(left)} left"))


class Bars:
    """A bar of all the work with the time that is left, and one for every piece that is under way.

    Args:
        console: console of the terminal.
        label: what is done, such as "evaluating".
        total: amount of work; infinite if it is not known.
        done: amount that an interrupted run has done before.
    """

    def __init__(self, console: Console, label: str, total: float = math.inf, done: float = 0.0) -> None:
        width = _NAME_WIDTH + max(0, console.width - 80)
        named = Column(no_wrap=True, overflow="ellipsis", max_width=width)
        columns = (
            TextColumn("{task.description}", table_column=named),
            BarColumn(_BAR_WIDTH),
            _AmountColumn(table_column=Column(no_wrap=True)),
            _TimeColumn(table_column=Column(no_wrap=True)),
        )
        self._bars = RichProgress(*columns, console=console, transient=True)
        whole = None if math.isinf(total) else total
        self._whole = self._bars.add_task(label, total=whole, completed=int(done), before=done, timed=True)
        self._running: dict[str, TaskID] = {}

    def __enter__(self) -> "Bars":
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()

    def begin(self, done: float) -> None:
        """See `Progress.begin`."""
        self._bars.update(self._whole, completed=done, before=done)

    def advance(self, amount: float) -> None:
        """See `Progress.advance`."""
        self._bars.advance(self._whole, amount)

    def reach(self, done: float) -> None:
        """See `Progress.reach`."""
        self._bars.update(self._whole, completed=done)

    def run(self, activities: Sequence[Activity]) -> None:
        """See `Progress.run`."""
        shown = {item.name: item for item in activities[:_MOST_BARS]}
        for name in [name for name in self._running if name not in shown]:
            self._bars.remove_task(self._running.pop(name))
        for name, item in shown.items():
            if name not in self._running:
                self._running[name] = self._bars.add_task(f"  {name}", total=None)
            if not math.isnan(item.share):
                self._bars.update(self._running[name], total=100, completed=round(100 * item.share))
