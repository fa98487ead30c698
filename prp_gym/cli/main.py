"""The command `prp-gym`."""

import inspect
import sys
from collections.abc import Callable, Mapping
from importlib.metadata import version
from typing import Annotated

import typer

from prp_gym.cli.audit import audit_command
from prp_gym.cli.compare import compare_command
from prp_gym.cli.evaluate import evaluate_command
from prp_gym.cli.export import export_command
from prp_gym.cli.export_c import export_c_command
from prp_gym.cli.listing import list_command
from prp_gym.cli.plot import plot_command
from prp_gym.cli.record import record_command
from prp_gym.cli.reproduce import reproduce_command
from prp_gym.cli.ship import ship_command
from prp_gym.cli.ship_gains import ship_gains_command
from prp_gym.cli.train import train_command
from prp_gym.cli.tune import tune_command
from prp_gym.cli.tune_all import tune_all_command
from prp_gym.cli.view import view_command
from prp_gym.cli.zoo import zoo_command
from prp_gym.console.legible import write_legibly
from prp_gym.console.terminal import Terminal
from prp_gym.errors import PRPError
from prp_gym.processes.interruption import Interruption, interruptible

_USAGE_ERROR = 2

COMMANDS: Mapping[str, Callable[..., None]] = {
    "audit": audit_command,
    "compare": compare_command,
    "evaluate": evaluate_command,
    "export": export_command,
    "export-c": export_c_command,
    "list": list_command,
    "plot": plot_command,
    "record": record_command,
    "reproduce": reproduce_command,
    "ship": ship_command,
    "ship-gains": ship_gains_command,
    "train": train_command,
    "tune": tune_command,
    "tune-all": tune_all_command,
    "view": view_command,
    "zoo": zoo_command,
}
"""The functions of the commands by name."""

app = typer.Typer(
    name="prp-gym",
    help="Gymnasium environments and classical baselines for the PRP arm.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"prp-gym {version('prp-gym')}")
        raise typer.Exit


@app.callback()
def common(
    _: Annotated[
        bool, typer.Option("--version", help="Show the version.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Gymnasium environments and classical baselines for the PRP arm."""


def _paragraphs(text: str | None) -> str:
    """A docstring without the line breaks inside its paragraphs, which a terminal sets anew."""
    return "\n\n".join(" ".join(part.split()) for part in inspect.cleandoc(text or "").split("\n\n"))


for _name, _command in COMMANDS.items():
    app.command(_name, help=_paragraphs(_command.__doc__))(_command)


def main() -> None:
    """Run the command.

    An error of this package ends with its message and exit code 2. SIGINT, SIGTERM and SIGHUP end with a
    message that says what was kept, and with exit code 130, 143 or 129.
    """
    write_legibly()
    with interruptible():
        try:
            app()
        except PRPError as error:
            Terminal().fail(f"error: {error}")
            sys.exit(_USAGE_ERROR)
        except OSError as error:  # of standard output, for instance: a full disk or a closed pipe
            print(f"error: {error}", file=sys.stderr)
            sys.exit(_USAGE_ERROR)
        except Interruption as interruption:
            Terminal().warn(interruption.message)
            sys.exit(interruption.exit_code)


if __name__ == "__main__":
    main()
