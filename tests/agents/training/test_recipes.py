"""Recipes: how their files are merged, what they may say, and what is refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from prp_gym import list_envs
from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.sb3.arguments import constructor_arguments, parse_schedule
from prp_gym.agents.training.recipes import EPISODES_A_SEED, FIRST_HELD_OUT_SEED, SEEDS, load_recipe
from prp_gym.errors import DataFileError, InvalidValueError, PRPError, UnknownNameError

ID = "PRP-Force-v0"
LAYERS = """
default:
  n_timesteps: 1000
  n_envs: 2
  policy: MlpPolicy
  gamma: 0.1
  n_steps: 1
  policy_kwargs: {net_arch: [1], activation_fn: tanh}
  env_kwargs: {action_mode: torque, control_frequency: 100}
  action_modes:
    impedance: {gamma: 0.2, n_steps: 2, n_epochs: 2, env_kwargs: {control_frequency: 50}}
PRP-Force-v0:
  n_steps: 3
  n_epochs: 3
  batch_size: 3
  policy_kwargs: {net_arch: [3]}
  action_modes:
    impedance: {batch_size: 4, vf_coef: 0.4}
    residual:impedance: {batch_size: 5}
PRP-Impedance-v0:
  env_kwargs: {action_mode: impedance}
"""


@pytest.fixture
def layers(tmp_path: Path) -> Path:
    path = tmp_path / "own.yml"
    path.write_text(LAYERS)
    return path


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("environment_id", list_envs())
def test_there_is_a_recipe_for_every_algorithm_and_environment(algorithm: str, environment_id: str) -> None:
    recipe = load_recipe(algorithm, environment_id)
    assert recipe.algorithm == algorithm
    assert recipe.environment_id == environment_id
    assert set(recipe.env_kwargs) == {"action_mode", "control_frequency", "scenario"}
    assert recipe.env_kwargs["scenario"] == "realistic"
    assert recipe.normalize == {"obs": True, "reward": True}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_learning_preset_has_the_default_recipe_at_its_own_frequency(algorithm: str) -> None:
    recipe, default = (load_recipe(algorithm, name) for name in ("PRP-Force-RL-v0", "PRP-Force-v0"))
    changed = {"control_frequency": 50.0, "observation": "errors"}
    assert recipe.env_kwargs == {**default.env_kwargs, **changed}
    assert recipe.settings == default.settings


def test_own_entry_of_a_learning_preset_has_the_last_word(tmp_path: Path) -> None:
    path = tmp_path / "own.yml"
    path.write_text(f"{LAYERS}PRP-Force-RL-v0:\n  env_kwargs: {{control_frequency: 25}}\n")
    keywords = load_recipe("ppo", "PRP-Force-RL-v0", config=path).env_kwargs
    assert keywords == {"action_mode": "torque", "control_frequency": 25, "observation": "errors"}


def test_default_holds_where_nothing_else_is_said(layers: Path) -> None:
    recipe = load_recipe("ppo", "PRP-Compliance-v0", config=layers)
    assert recipe.settings == {
        "gamma": 0.1,
        "n_steps": 1,
        "policy_kwargs": {"net_arch": [1], "activation_fn": "tanh"},
    }
    assert recipe.env_kwargs == {"action_mode": "torque", "control_frequency": 100}
    assert (recipe.n_timesteps, recipe.n_envs) == (1000, 2)


def test_later_layers_replace_earlier_ones_key_by_key(layers: Path) -> None:
    recipe = load_recipe("ppo", ID, "impedance", config=layers)
    assert recipe.settings == {
        "gamma": 0.2,  # of default's action mode: the id says nothing
        "n_steps": 3,  # of the id, over default's action mode
        "n_epochs": 3,
        "batch_size": 4,  # of the id's action mode
        "vf_coef": 0.4,
        "policy_kwargs": {"net_arch": [3], "activation_fn": "tanh"},
    }
    assert recipe.env_kwargs == {"action_mode": "impedance", "control_frequency": 50}


def test_parts_for_other_action_modes_do_not_count(layers: Path) -> None:
    settings = load_recipe("ppo", ID, config=layers).settings
    assert (settings["gamma"], settings["batch_size"]) == (0.1, 3)
    assert "vf_coef" not in settings


def test_action_mode_of_the_entry_chooses_the_part(layers: Path) -> None:
    recipe = load_recipe("ppo", "PRP-Impedance-v0", config=layers)
    assert recipe.action_mode == "impedance"
    assert recipe.settings["gamma"] == 0.2
    assert load_recipe("ppo", "PRP-Impedance-v0", "torque", config=layers).settings["gamma"] == 0.1


def test_engine_of_a_recipe_can_be_replaced() -> None:
    plain = load_recipe("ppo", "PRP-Adaptive-v0")
    compiled = plain.with_engine("compiled")
    written = load_recipe("ppo", "PRP-Adaptive-v0", overrides=["env_kwargs.engine=compiled"])
    assert compiled == written
    assert compiled.env_kwargs["engine"] == "compiled"
    assert written.with_engine("mujoco") == plain.with_engine("mujoco") == plain
    with pytest.raises(UnknownNameError, match="unknown engine 'bullet'"):
        plain.with_engine("bullet")


def test_group_is_named_after_algorithm_and_mode_as_a_folder_may_be(layers: Path) -> None:
    recipe = load_recipe("ppo", ID, "residual:impedance", config=layers)
    assert recipe.settings["batch_size"] == 5
    assert recipe.action_mode == "residual:impedance"
    assert recipe.name == "ppo_residual-impedance"


def test_overrides_have_the_last_word(layers: Path) -> None:
    overrides = ["policy_kwargs.net_arch=[32, 16]", "batch_size=7", "normalize.reward=false", "ent_coef=1e-3"]
    recipe = load_recipe("ppo", ID, "impedance", config=layers, overrides=overrides)
    assert recipe.settings["policy_kwargs"] == {"net_arch": [32, 16], "activation_fn": "tanh"}
    assert recipe.settings["batch_size"] == 7
    assert recipe.normalize == {"obs": True, "reward": False}
    assert recipe.settings["ent_coef"] == 0.001  # which YAML itself takes for a text


def test_recipe_written_out_says_everything(layers: Path) -> None:
    assert load_recipe("ppo", ID, "residual:impedance", config=layers).to_plain() == {
        "algorithm": "ppo",
        "environment": ID,
        "n_timesteps": 1000,
        "n_envs": 2,
        "policy": "MlpPolicy",
        "normalize": {"obs": True, "reward": True},
        "env_kwargs": {"action_mode": "residual:impedance", "control_frequency": 100},
        "gamma": 0.1,
        "n_steps": 3,
        "n_epochs": 3,
        "batch_size": 5,
        "policy_kwargs": {"net_arch": [3], "activation_fn": "tanh"},
    }


@pytest.mark.parametrize(
    ("override", "nearest"),
    [
        ("n_step=3", "n_steps"),
        ("policy=MlpPolici", "MlpPolicy"),
        ("policy_kwargs.netarch=[3]", "net_arch"),
        ("policy_kwargs.activation_fn=tanhh", "tanh"),
        ("normalize.rewards=true", "reward"),
    ],
)
def test_unknown_name_is_refused_with_the_nearest(override: str, nearest: str) -> None:
    with pytest.raises(UnknownNameError, match=f"Did you mean '{nearest}'"):
        load_recipe("ppo", ID, overrides=[override])


@pytest.mark.parametrize(
    ("algorithm", "environment_id", "nearest"),
    [("ppoo", ID, "ppo"), ("ppo", "PRP-Force-v1", "PRP-Force-v0")],
)
def test_unknown_algorithm_and_environment_are_refused(
    algorithm: str, environment_id: str, nearest: str
) -> None:
    with pytest.raises(UnknownNameError, match=f"Did you mean '{nearest}'"):
        load_recipe(algorithm, environment_id)


@pytest.mark.parametrize("key", ["env", "seed", "verbose", "device", "tensorboard_log", "use_sde"])
def test_what_training_itself_settles_is_no_key(key: str) -> None:
    with pytest.raises(UnknownNameError):
        load_recipe("ppo", ID, overrides=[f"{key}=1"])


def test_noise_is_for_algorithms_that_add_it_to_actions() -> None:
    assert load_recipe("td3", ID, overrides=["noise_std=0.3"]).settings["noise_std"] == 0.3
    with pytest.raises(UnknownNameError):
        load_recipe("ppo", ID, overrides=["noise_std=0.3"])


@pytest.mark.parametrize(
    ("algorithm", "override"),
    [
        ("ppo", "n_timesteps=0"),
        ("ppo", "n_timesteps=many"),
        ("ppo", "n_envs=1.5"),
        ("ppo", "n_envs=true"),
        ("ppo", "learning_rate=lin_"),
        ("ppo", "learning_rate=-1"),
        ("ppo", "learning_rate=exp_3"),
        ("ppo", "normalize.obs=1"),
        ("ppo", "normalize=true"),
        ("ppo", "policy_kwargs=3"),
        ("ppo", "env_kwargs=3"),
        ("ppo", "n_steps"),
        ("ppo", "=3"),
        ("ppo", "policy_kwargs.=3"),
        ("ppo", "n_steps=[3"),
        ("sac", "train_freq=[1, episode]"),
    ],
)
def test_value_that_is_not_allowed_is_refused(algorithm: str, override: str) -> None:
    with pytest.raises(InvalidValueError):
        load_recipe(algorithm, ID, overrides=[override])


@pytest.mark.parametrize(
    "content",
    [
        "default: [1, 2]",
        "- default",
        "default: {n_steps: 1",
        "PRP-Force-v1: {n_steps: 1}",
        "default: {action_modes: [impedance]}",
        "default: {action_modes: {torque: 3}}",
        "default: {n_steps: 1}",  # without a policy
        "default: !!python/object/apply:os.getcwd []",
    ],
)
def test_file_that_is_no_set_of_recipes_is_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "own.yml"
    path.write_text(content)
    with pytest.raises(PRPError):
        load_recipe("ppo", ID, config=path)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataFileError, match=r"nothing\.yml"):
        load_recipe("ppo", ID, config=tmp_path / "nothing.yml")


def test_schedule_falls_linearly_to_zero() -> None:
    schedule: Any = parse_schedule("learning_rate", "lin_5e-4")
    # of what remains of the training, 1 at the start and 0 at the end
    assert [schedule(1.0), schedule(0.5), schedule(0.0)] == [5e-4, 2.5e-4, 0.0]
    assert parse_schedule("learning_rate", 3e-4) == 3e-4


def test_names_become_what_the_algorithm_takes() -> None:
    settings = load_recipe("td3", ID, overrides=["noise_std=0.3", "learning_rate=lin_1e-3"]).settings
    arguments = constructor_arguments(settings, action_size=2)
    assert arguments["policy_kwargs"]["activation_fn"] is torch.nn.ReLU
    assert arguments["learning_rate"](0.5) == 5e-4
    draws = np.array([arguments["action_noise"]() for _ in range(4000)])
    # the standard error of a standard deviation of 4000 draws is 1.1 %; five of them
    assert draws.std(axis=0) == pytest.approx([0.3, 0.3], rel=0.06)
    assert not {"noise_type", "noise_std"} & set(arguments)


def test_seeds_of_training_episodes_are_none_of_the_held_out_ones() -> None:
    last_of_all = (SEEDS - 1 + 1) * EPISODES_A_SEED + EPISODES_A_SEED - 1
    assert last_of_all < FIRST_HELD_OUT_SEED
