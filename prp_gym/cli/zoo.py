"""The command `prp-gym zoo`."""

from pathlib import Path
from typing import Annotated

import typer

from prp_gym.agents.training.recipes import load_recipe
from prp_gym.agents.training.shipped import default_action_mode
from prp_gym.agents.training.zoo_recipe import write_zoo_recipes
from prp_gym.cli.options import Algorithm, DefaultActionMode, Environments, Json, Plugins, RecipeFile
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.tasks.registration import list_envs

_SUFFIXES = (".yml", ".yaml")


def zoo_command(
    output: Annotated[Path, typer.Argument(help="Path of the file, which ends in .yml.")],
    env: Environments = None,
    algo: Algorithm = "ppo",
    action_mode: DefaultActionMode = None,
    config: RecipeFile = None,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Write the recipes of an algorithm in the form of rl-baselines3-zoo.

    Its programs read the file with --conf-file, and find the environments with --gym-packages prp_gym.
    """
    if output.suffix not in _SUFFIXES:
        raise InvalidValueError("file for the zoo", str(output), f"a name that ends in {_SUFFIXES[0]}")
    recipes = [
        load_recipe(algo, name, action_mode or default_action_mode(name, config), config)
        for name in env or list_envs()
    ]
    write_zoo_recipes(recipes, output)
    content = {"recipes": len(recipes), "file": str(output)}
    terminal = Terminal.of(quiet=False, as_json=as_json)
    terminal.report(content, lines=[f"{len(recipes)} recipes of {algo}: {output}"])
