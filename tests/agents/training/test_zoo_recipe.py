"""Recipes in the form of rl-baselines3-zoo: what its reader makes of them is the suite's own recipe."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from torch import nn

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.sb3.arguments import constructor_arguments
from prp_gym.agents.training.recipes import load_recipe
from prp_gym.agents.training.zoo_recipe import write_zoo_recipes, zoo_entry
from prp_gym.errors import OutputError

FORCE = "PRP-Force-v0"
NOT_SETTINGS = {"env_kwargs", "n_envs", "n_timesteps", "normalize", "policy"}


def read_as_the_zoo_does(path: Path) -> dict[str, Any]:
    """Read the first entry: YAML, then the text of `policy_kwargs` as Python with `nn` in sight."""
    entry = dict(next(iter(yaml.safe_load(path.read_text(encoding="utf-8")).values())))
    entry["policy_kwargs"] = eval(entry["policy_kwargs"], {"nn": nn})
    return entry


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_the_zoo_reads_the_recipe(algorithm: str, tmp_path: Path) -> None:
    recipe = load_recipe(algorithm, FORCE)
    write_zoo_recipes([recipe], tmp_path / "zoo.yml")
    entry = read_as_the_zoo_does(tmp_path / "zoo.yml")
    own = constructor_arguments(recipe.settings, action_size=3)
    assert entry["policy_kwargs"] == own["policy_kwargs"]
    assert entry["env_kwargs"] == recipe.env_kwargs
    assert entry["normalize"] == {
        "norm_obs": recipe.normalize["obs"],
        "norm_reward": recipe.normalize["reward"],
    }
    assert (entry["n_envs"], entry["n_timesteps"], entry["policy"]) == (
        recipe.n_envs,
        recipe.n_timesteps,
        recipe.policy,
    )
    assert set(entry) - NOT_SETTINGS == set(recipe.settings)
    for name in set(recipe.settings) - {"policy_kwargs"}:
        assert entry[name] == recipe.settings[name]


def test_entry_leaves_the_recipe_as_it_is() -> None:
    recipe = load_recipe("ppo", FORCE, "variable_force_position")
    before = recipe.to_plain()
    entry = zoo_entry(recipe)
    assert entry["policy_kwargs"] == "dict(net_arch=[64, 64], activation_fn=nn.Tanh, log_std_init=0.0)"
    assert entry["env_kwargs"]["action_mode"] == "variable_force_position"
    assert recipe.to_plain() == before


def test_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"missing.*No such file"):
        write_zoo_recipes([load_recipe("ppo", FORCE)], tmp_path / "missing" / "zoo.yml")
