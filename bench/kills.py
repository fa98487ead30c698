"""`make kills`: commands that are killed at random moments go on to the same end and leave nothing."""

import random
import signal
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.kill_case import CASES, OUTPUT
from bench.kill_trial import KillTrial, in_new_folder, run_to_end
from prp_gym.errors import PRPError, UnknownNameError

_SHARE_OF_TERM = 0.3
_PAST_THE_END = 1.05  # of the duration of an uninterrupted command, up to which signals are sent


@dataclass(frozen=True)
class KillTally:
    """The trials of one command.

    Attributes:
        name: name of the command.
        seconds: duration of the uninterrupted command.
        numbers: signals that were sent.
        faults: what was wrong, by trial.
    """

    name: str
    seconds: float
    numbers: Sequence[signal.Signals]
    faults: Sequence[Sequence[str]]


def kill_often(name: str, count: int, seed: int, console: Console) -> KillTally:
    """Interrupt a command at random moments, each time until its end.

    Args:
        name: command, a key of `CASES`.
        count: number of trials.
        seed: seed of moments and signals.
        console: where faults are printed as they are found.

    Raises:
        UnknownNameError: there is no such command.
    """
    if name not in CASES:
        raise UnknownNameError("command", name, CASES)
    case, rng = CASES[name], random.Random(f"{name} {seed}")
    numbers, faults = [], []
    with tempfile.TemporaryDirectory(prefix="prp_gym_kills_") as reference:
        start = time.monotonic()
        _, wrong = run_to_end((*case.arguments, "--output", OUTPUT), Path(reference))
        seconds = time.monotonic() - start
        if wrong:
            console.print(f"{name}, uninterrupted: {'; '.join(wrong)}", highlight=False, markup=False)
            return KillTally(name, seconds, (), [wrong])
        for index in range(count):
            number = signal.SIGTERM if rng.random() < _SHARE_OF_TERM else signal.SIGKILL
            trial = KillTrial(case, number, rng.uniform(0.0, _PAST_THE_END * seconds))
            numbers.append(number)
            faults.append(in_new_folder(trial, Path(reference)))
            if faults[-1]:
                told = f"{name} {index}, {number.name} after {trial.delay:.2f} s: {'; '.join(faults[-1])}"
                console.print(told, highlight=False, markup=False)
    return KillTally(name, seconds, numbers, faults)


def tally_table(tallies: Sequence[KillTally]) -> Table:
    """One row for each command."""
    faulty = sum(bool(own) for tally in tallies for own in tally.faults)
    total = sum(len(tally.numbers) for tally in tallies)
    table = Table(title=f"{total} interruptions, {faulty} with a fault", title_justify="left")
    for header in ("command", "uninterrupted [s]", "SIGKILL", "SIGTERM", "with a fault"):
        table.add_column(header, justify="left" if header == "command" else "right")
    for tally in tallies:
        killed = sum(number == signal.SIGKILL for number in tally.numbers)
        counts = (killed, len(tally.numbers) - killed, sum(bool(own) for own in tally.faults))
        table.add_row(tally.name, f"{tally.seconds:.1f}", *map(str, counts))
    return table


app = typer.Typer(add_completion=False)


@app.command()
def main(
    count: Annotated[int, typer.Option(min=1, help="Interruptions of all commands together.")] = 150,
    seed: Annotated[int, typer.Option(help="Seed of moments and signals.")] = 0,
    command: Annotated[
        list[str] | None, typer.Option(help=f"Command: {', '.join(CASES)}; repeatable. Default: all.")
    ] = None,
) -> None:
    """Kill commands at random moments, let them go on to the end, and compare them with uninterrupted ones.

    The exit code is 1 if one of them has other results, a torn file, or left anything behind.
    """
    console = Console(width=150)
    names = command or list(CASES)
    shares = [count // len(names) + (index < count % len(names)) for index in range(len(names))]
    try:
        tallies = [
            kill_often(name, share, seed, console) for name, share in zip(names, shares, strict=True) if share
        ]
    except PRPError as error:
        console.print(str(error), markup=False, highlight=False)
        raise typer.Exit(1) from None
    console.print(tally_table(tallies))
    raise typer.Exit(int(any(own for tally in tallies for own in tally.faults)))


if __name__ == "__main__":
    app()
