"""Declarations of learning algorithms: the suite's own, and one of another package."""

import pickle
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import typer.main

import prp_gym
from prp_gym.agents.algorithms import ALGORITHMS, AlgorithmEntry, AlgorithmSpec, RecipeScope
from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.agents.sb3.actors import read_gaussian_actor, read_squashed_actor
from prp_gym.agents.training.recipes import load_recipe
from prp_gym.agents.training.train import train
from prp_gym.cli.main import app
from prp_gym.errors import DataFileError, InvalidValueError, MissingPackageError, UnknownNameError
from tests.conformance.test_public_api import in_fresh_python
from tests.support.training_runs import ID, TINY, tiny_job

ROOT = Path(__file__).resolve().parents[3]
FOREIGN_MODULE = """
from pathlib import Path
from stable_baselines3 import PPO
import prp_gym
from prp_gym.agents.algorithms import AlgorithmEntry, AlgorithmSpec
from prp_gym.agents.sb3.actors import read_gaussian_actor

class CautiousPPO(PPO):
    pass

SPEC = prp_gym.register_algorithm(AlgorithmSpec(
    name="cautious_ppo",
    summary="PPO of another package",
    entry=AlgorithmEntry(__name__, "CautiousPPO", read_gaussian_actor),
    recipes=Path(__file__).with_name("cautious.yml"),
))
"""
FOREIGN_RECIPES = """
default: {n_timesteps: 700, n_envs: 4, policy: MlpPolicy, clip_range: 0.05}
PRP-Adaptive-v0: {gae_lambda: 0.7}
"""


@pytest.fixture
def foreign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[AlgorithmSpec]:
    """An algorithm that a package outside of this suite has declared, with recipes of its own."""
    (tmp_path / "package_with_an_algorithm.py").write_text(FOREIGN_MODULE, encoding="utf-8")
    (tmp_path / "cautious.yml").write_text(FOREIGN_RECIPES, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    import package_with_an_algorithm  # type: ignore[import-not-found]

    yield package_with_an_algorithm.SPEC
    ALGORITHMS.unregister("cautious_ppo")
    del sys.modules["package_with_an_algorithm"]


def test_every_file_of_the_folder_declares_the_algorithm_of_its_name() -> None:
    files = {path.stem for path in (ROOT / "agents" / "algorithms").glob("*.py")} - {"__init__", "spec"}
    assert set(ALGORITHMS) == files
    for name, spec in ALGORITHMS.items():
        assert spec.recipes == ROOT / "prp_gym" / "agents" / "algorithms" / f"{name}.yml"
        assert spec.load_class().__name__ == spec.entry.class_name
        assert spec.summary


def test_declarations_are_read_without_a_learning_library() -> None:
    code = (
        "import json, sys; from prp_gym.agents.algorithms import ALGORITHMS;"
        "names = list(ALGORITHMS); print(json.dumps([names, list(sys.modules)]))"
    )
    names, modules = in_fresh_python(code)
    assert names == list(ALGORITHMS)
    assert {"torch", "stable_baselines3", "sb3_contrib", "yaml"}.isdisjoint(modules)


@pytest.mark.parametrize(("command", "option"), [("train", "--algo"), ("export", "--algorithm")])
def test_help_names_every_algorithm(command: str, option: str) -> None:
    group: Any = typer.main.get_command(app)
    (described,) = (each.help for each in group.commands[command].params if option in each.opts)
    assert set(described.removeprefix("Learning algorithm: ").rstrip(".").split(", ")) == set(ALGORITHMS)


def test_algorithm_of_another_package_is_trained_and_exported(foreign: AlgorithmSpec, tmp_path: Path) -> None:
    recipe = load_recipe("cautious_ppo", ID)
    assert recipe.n_timesteps == 700
    assert recipe.settings == {"clip_range": 0.05, "gae_lambda": 0.7}
    shortened = load_recipe("cautious_ppo", ID, overrides=TINY["ppo"])
    result = train(replace(tiny_job(tmp_path / "run"), recipe=shortened))
    assert result["algorithm"] == "cautious_ppo"
    agent = load_agent(tmp_path / "run" / "agent")
    assert (agent.card.algorithm, agent.card.run.hyperparameters["clip_range"]) == ("CautiousPPO", 0.05)
    assert ALGORITHMS.find("cautious_ppo") is foreign


def test_algorithm_is_unknown_once_its_declaration_is_removed(foreign: AlgorithmSpec) -> None:
    ALGORITHMS.unregister(foreign.name)
    with pytest.raises(UnknownNameError, match="unknown algorithm 'cautious_ppo'"):
        load_recipe(foreign.name, ID)
    prp_gym.register_algorithm(foreign)
    assert load_recipe(foreign.name, ID).algorithm == foreign.name


def test_name_that_is_taken_is_refused(foreign: AlgorithmSpec) -> None:
    assert prp_gym.register_algorithm(foreign) is foreign
    with pytest.raises(InvalidValueError, match="is 'ppo'; allowed: one that no other algorithm has"):
        prp_gym.register_algorithm(replace(foreign, name="ppo"))


def test_recipe_file_that_does_not_exist_is_named(foreign: AlgorithmSpec) -> None:
    foreign.recipes.unlink()
    with pytest.raises(DataFileError, match=r"cautious\.yml': cannot be opened: No such file"):
        load_recipe(foreign.name, ID)


DEFAULT = RecipeScope()


def declared(package: str, class_name: str, scope: RecipeScope = DEFAULT) -> AlgorithmSpec:
    entry = AlgorithmEntry(package, class_name, read_gaussian_actor)
    return AlgorithmSpec("unregistered", "", entry, Path("unregistered.yml"), scope)


def test_package_or_class_that_does_not_exist_is_named() -> None:
    with pytest.raises(MissingPackageError, match="no_such_package is not installed"):
        declared("no_such_package", "PPO").load_class()
    with pytest.raises(
        UnknownNameError, match=r"unknown class of package 'sb3_contrib' 'TQD'. Did you mean 'TQC'"
    ):
        declared("sb3_contrib", "TQD").load_class()


def test_scope_decides_what_a_recipe_may_set() -> None:
    plain = declared("stable_baselines3", "SAC")
    scope = RecipeScope(("CnnPolicy",), replay_buffer=True, excluded=frozenset({"tau", "gamma"}))
    scoped = declared("stable_baselines3", "SAC", scope)
    assert set(plain.settings()) - set(scoped.settings()) == {"gamma"}
    assert {"noise_type", "noise_std", "buffer_size"} <= set(scoped.settings()) - set(plain.settings())
    assert "tau" not in scoped.settings()
    assert "net_arch" in scoped.policy_settings("CnnPolicy")
    with pytest.raises(UnknownNameError, match=r"unknown policy 'MlpPolicy'. Did you mean 'CnnPolicy'"):
        scoped.policy_settings("MlpPolicy")
    assert "net_arch" in plain.policy_settings("MlpPolicy")


@pytest.mark.parametrize("name", ["ppo", "recurrent_ppo", "sac", "td3", "tqc"])
def test_declaration_survives_pickling(name: str) -> None:
    assert pickle.loads(pickle.dumps(ALGORITHMS[name])) == ALGORITHMS[name]


def test_reader_of_another_kind_of_actor_is_not_equal() -> None:
    spec = ALGORITHMS["ppo"]
    other = replace(spec, entry=replace(spec.entry, read_actor=read_squashed_actor))
    with pytest.raises(InvalidValueError, match="one that no other algorithm has"):
        prp_gym.register_algorithm(other)
    assert ALGORITHMS["ppo"] == spec
