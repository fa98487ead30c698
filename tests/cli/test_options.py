"""The options of all commands: the same name means the same everywhere."""

from collections import defaultdict
from collections.abc import Iterator
from types import UnionType
from typing import Any, get_args, get_type_hints

import pytest
import typer

from prp_gym.cli.main import COMMANDS, app

GROUP: Any = typer.main.get_command(app)
SHORT = {
    "--env": "-e",
    "--baseline": "-b",
    "--scenario": "-s",
    "--episodes": "-n",
    "--agent": "-a",
    "--format": "-f",
    "--gains": "-g",
    "--action-mode": "-m",
    "--output": "-o",
    "--jobs": "-j",
    "--plugin": "-p",
    "--quiet": "-q",
}
"""Options with a short form."""

TAKE_UP = ("audit", "compare", "evaluate", "train", "tune", "tune-all")
"""Commands that keep what is finished when they are interrupted, and go on with it."""

ONE_PROCESS = ("plot", "record", "reproduce", "tune")
COMPUTE = (*TAKE_UP, "plot", "record", "reproduce", "ship")


def options(command: str) -> list[Any]:
    return [item for item in GROUP.commands[command].params if item.param_type_name == "option"]


def everywhere() -> Iterator[tuple[str, Any]]:
    """Every option of every command."""
    for command in GROUP.commands:
        for item in options(command):
            yield command, item


def names(command: str) -> set[str]:
    return {name for item in options(command) for name in (*item.opts, *item.secondary_opts)}


def kind(command: str, item: Any) -> Any:
    """The type of an option's values, whether or not the option may be left out."""
    annotation = get_type_hints(COMMANDS[command])[item.name]
    parts = [part for part in get_args(annotation) if part is not type(None)]
    return parts[0] if isinstance(annotation, UnionType) else annotation


def test_option_has_one_help_text_one_type_and_the_same_names_in_all_commands() -> None:
    meanings = defaultdict(set)
    for command, item in everywhere():
        names = (*item.opts, *item.secondary_opts)
        if item.name != "help":
            meanings[names[0]].add((item.help, kind(command, item), item.multiple, names))
    assert {name: found for name, found in meanings.items() if len(found) > 1} == {}
    assert all(help_text for found in meanings.values() for help_text, *_ in found)
    every = [name for found in meanings.values() for *_, names in found for name in names]
    assert len(every) == len(set(every))  # no name stands for two options


def test_short_forms_are_those_of_the_table_wherever_the_option_is() -> None:
    found = {
        (item.opts[0], name) for _, item in everywhere() for name in item.opts if not name.startswith("--")
    }
    assert found == set(SHORT.items())


@pytest.mark.parametrize("command", sorted(GROUP.commands))
def test_command_that_takes_up_an_interrupted_run_does_so_unless_told_to_start_over(command: str) -> None:
    found = [item for item in options(command) if "--resume" in item.opts]
    assert [item.secondary_opts for item in found] == ([["--fresh"]] if command in TAKE_UP else [])
    assert all(item.default is True for item in found)
    assert ("--fresh" in names(command)) is (command in TAKE_UP)


@pytest.mark.parametrize("command", COMPUTE)
def test_command_that_computes_has_the_options_of_all_that_do(command: str) -> None:
    assert {"--output", "--plugin", "--quiet", "--json"} <= names(command)
    assert ({"--jobs", "--backend"} <= names(command)) is (command not in ONE_PROCESS)
