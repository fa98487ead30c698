"""The command `prp-gym`."""

import sys
from importlib.metadata import version
from typing import Annotated

import typer

from prp_gym.cli.audit import audit_command
from prp_gym.cli.compare import compare_command
from prp_gym.cli.evaluate import evaluate_command
from prp_gym.cli.export import export_command
from prp_gym.cli.listing import list_command
from prp_gym.cli.reproduce import reproduce_command
from prp_gym.cli.ship import ship_command
from prp_gym.cli.ship_gains import ship_gains_command
from prp_gym.cli.train import train_command
from prp_gym.cli.tune import tune_command
from prp_gym.cli.tune_all import tune_all_command
from prp_gym.cli.view import view_command
from prp_gym.cli.zoo import zoo_command
from prp_gym.errors import PRPError
from prp_gym.processes.interruption import Interruption, interruptible
from prp_gym.runs.terminal import make_console

_USAGE_ERROR = 2

app = typer.Typer(
    name="prp-gym",
    help="Gymnasium environments and classical baselines for the PRP arm.",
    no_args_is_help=True,
    add_completion=False,
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


app.command("audit")(audit_command)
app.command("compare")(compare_command)
app.command("evaluate")(evaluate_command)
app.command("export")(export_command)
app.command("list")(list_command)
app.command("reproduce")(reproduce_command)
app.command("ship")(ship_command)
app.command("ship-gains")(ship_gains_command)
app.command("tune")(tune_command)
app.command("tune-all")(tune_all_command)
app.command("train")(train_command)
app.command("view")(view_command)
app.command("zoo")(zoo_command)


def main() -> None:
    """Run the command.

    An error of this package ends with its message and exit code 2. SIGINT, SIGTERM and SIGHUP end with a
    message that says what was kept, and with exit code 130, 143 or 129.
    """
    with interruptible():
        try:
            app()
        except PRPError as error:
            make_console(stderr=True).print(f"error: {error}", style="red", markup=False, highlight=False)
            sys.exit(_USAGE_ERROR)
        except OSError as error:  # of standard output, for instance: a full disk or a closed pipe
            print(f"error: {error}", file=sys.stderr)
            sys.exit(_USAGE_ERROR)
        except Interruption as interruption:
            make_console(stderr=True).print(interruption.message, markup=False, highlight=False)
            sys.exit(interruption.exit_code)


if __name__ == "__main__":
    main()
