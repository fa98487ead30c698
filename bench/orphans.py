"""`python -m bench.orphans`: how long workers outlive a command that is asked to end, or is killed."""

import signal
import tempfile
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.tagged_process import TaggedProcess

LIMIT = 2.0  # s
WITH_WORKERS = {
    "evaluate": (
        *("evaluate", "--env", "PRP-JointRegulation-v0", "--baseline", "joint_pd", "--episodes", "3000"),
        *("--baseline", "joint_inverse_dynamics", "--scenario", "randomized", "--jobs", "2"),
    ),
    "compare": (
        *("compare", "--env", "PRP-JointRegulation-v0", "--baseline", "joint_pd", "--episodes", "3000"),
        *("--scenario", "randomized", "--jobs", "2"),
    ),
    "train": (
        *("train", "PRP-JointRegulation-v0", "--seeds", "2", "--jobs", "2", "--eval-episodes", "2"),
        *("--set", "n_timesteps=2000000", "--no-tensorboard"),
    ),
}
"""Commands that run for minutes with two workers."""

_PROCESSES = 4  # the command, two workers, and the tracker of their resources


def seconds_of_orphans(name: str, number: signal.Signals, delay: float, folder: Path) -> tuple[float, str]:
    """Seconds until a command and its workers have ended after a signal, and what it wrote to standard error.

    Args:
        name: command, a key of `WITH_WORKERS`.
        number: signal that the command gets.
        delay: seconds between the start of the workers and the signal.
        folder: working folder.
    """
    command = TaggedProcess(WITH_WORKERS[name], folder, {})
    try:
        command.wait_for_workers(_PROCESSES)
        time.sleep(delay)
        command.end(number)
        return command.seconds_to_end(10.0), command.errors()
    finally:
        command.close()


def _in_new_folder(name: str, number: signal.Signals, delay: float) -> float:
    with tempfile.TemporaryDirectory(prefix="prp_gym_orphans_") as folder:
        return seconds_of_orphans(name, number, delay, Path(folder))[0]


app = typer.Typer(add_completion=False)


@app.command()
def main(
    tries: Annotated[int, typer.Option(min=1, help="Tries of each command and signal.")] = 20,
    command: Annotated[
        list[str] | None, typer.Option(help=f"Command: {', '.join(WITH_WORKERS)}; repeatable. Default: all.")
    ] = None,
) -> None:
    """Send SIGTERM and SIGKILL to commands with two workers; exit code 1 if one lives longer than 2 s."""
    table = Table(title=f"{tries} tries each; seconds until no process is alive", title_justify="left")
    for header in ("command", "signal", "median", "longest", f"longer than {LIMIT:g} s"):
        table.add_column(header, justify="left" if header in ("command", "signal") else "right")
    late = 0
    for name in command or WITH_WORKERS:
        for number in (signal.SIGTERM, signal.SIGKILL):
            took = sorted(_in_new_folder(name, number, 0.2 * (index % 10)) for index in range(tries))
            over = sum(seconds > LIMIT for seconds in took)
            late += over
            figures = (f"{took[len(took) // 2]:.2f}", f"{took[-1]:.2f}", f"{over} of {tries}")
            table.add_row(name, number.name, *figures)
    Console(width=120).print(table)
    raise typer.Exit(int(late > 0))


if __name__ == "__main__":
    app()
