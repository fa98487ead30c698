"""Run the environments under other libraries: `make clients`, `python -m bench.clients --only NAME`."""

from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from bench.clients.catalogue import CLIENTS
from bench.clients.environment import Outcome, install, run
from bench.clients.results import RESULTS, read_results, verdict
from prp_gym.artifacts import write_json
from prp_gym.errors import UnknownNameError


def main(
    only: Annotated[
        list[str] | None, typer.Option(help="Name of a library; repeatable. Default: all.")
    ] = None,
) -> None:
    """Install each library in an environment of its own, run its program, and show and store the results."""
    known = {client.name: client for client in CLIENTS}
    for name in only or known:
        if name not in known:
            raise UnknownNameError("client", name, known)
    results = read_results()
    failed = 0
    for name in only or known:
        reason = install(known[name])
        results[name] = Outcome("", reason, 0.0) if reason else run(known[name])
        failed += bool(results[name].message)
        typer.echo(f"{known[name].title}: {results[name].message or 'unchanged'}")
        write_json(RESULTS, {key: asdict(results[key]) for key in known if key in results})
    _show(results)
    raise typer.Exit(failed)


def _show(results: dict[str, Outcome]) -> None:
    table = Table("client", "version", "Gymnasium", "result", "time [s]")
    for client in CLIENTS:
        if client.name in results:
            found = results[client.name]
            result = verdict(client, found)
            table.add_row(client.title, client.version, found.gymnasium, result, f"{found.seconds:.0f}")
    Console().print(table)


if __name__ == "__main__":
    typer.run(main)
