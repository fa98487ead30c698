"""`python -m prp_gym.prebuilding`: build the compiled libraries of a wheel."""

from pathlib import Path
from typing import Annotated

import typer

from prp_gym.prebuilding.libraries import build_libraries
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tasks.spec import TASKS


def main(
    output: Annotated[Path, typer.Option(help="Folder of the libraries.")],
    env: Annotated[
        list[str] | None, typer.Option(help="Id of an environment; repeatable. Default: all.")
    ] = None,
) -> None:
    """Build the libraries of environments in all scenarios, with all controllers and action modes."""
    conditions = [
        (name, scenario) for name in env or [entry.id for entry in TASKS.values()] for scenario in SCENARIOS
    ]
    built = build_libraries(conditions, output, typer.echo)
    size = sum(path.stat().st_size for path in built) / 1e6
    typer.echo(f"{len(built)} libraries of {size:.1f} MB in {output}")


if __name__ == "__main__":
    typer.run(main)
