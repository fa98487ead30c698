"""Recipes in the form of rl-baselines3-zoo, whose programs then train, tune and show the same agents."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from prp_gym.agents.sb3.arguments import ACTIVATIONS
from prp_gym.agents.sb3.packages import require
from prp_gym.agents.training.recipes import Recipe
from prp_gym.errors import OutputError

_HEADER = "# Recipes for rl-baselines3-zoo, written by `prp-gym zoo`; use them with --gym-packages prp_gym.\n"


def zoo_entry(recipe: Recipe) -> dict[str, Any]:
    """A recipe as the entry of one environment in a file of rl-baselines3-zoo.

    The zoo merges no entries, so this one is complete. It evaluates the text of `policy_kwargs` as Python, in
    which activations are classes of `torch.nn`, and calls the normalised quantities as `VecNormalize` does.
    """
    entry = {
        "env_kwargs": dict(recipe.env_kwargs),
        "n_envs": recipe.n_envs,
        "n_timesteps": recipe.n_timesteps,
        "normalize": {f"norm_{name}": chosen for name, chosen in recipe.normalize.items()},
        "policy": recipe.policy,
        **recipe.settings,
    }
    if "policy_kwargs" in recipe.settings:
        arguments = recipe.settings["policy_kwargs"].items()
        entry["policy_kwargs"] = f"dict({', '.join(f'{name}={_python(name, v)}' for name, v in arguments)})"
    return entry


def _python(name: str, value: Any) -> str:
    return f"nn.{ACTIVATIONS[value]}" if name == "activation_fn" else repr(value)


def write_zoo_recipes(recipes: Iterable[Recipe], path: Path) -> None:
    """Write a file for the zoo's option `--conf-file`.

    Args:
        recipes: recipes of one algorithm, at most one for each environment.
        path: path of the file, whose name must end in `.yml` for the zoo to read it as YAML.

    Raises:
        OutputError: the file cannot be written.
        MissingPackageError: PyYAML is not installed.
    """
    entries = {recipe.environment_id: zoo_entry(recipe) for recipe in recipes}
    text = _HEADER + str(require("yaml").safe_dump(entries, sort_keys=False))
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(path, error.strerror) from error
