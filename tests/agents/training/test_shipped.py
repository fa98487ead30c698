"""The list of the agents that are shipped with the package, and the agents themselves."""

import shlex
from contextlib import closing
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from prp_gym import evaluate, list_agents, load_agent
from prp_gym.action_modes import list_action_modes
from prp_gym.agents.policy.agent_file import CARD, TENSORS, TRAINED, list_seeds
from prp_gym.agents.policy.environments import environment_revision
from prp_gym.agents.training.recipes import Recipe
from prp_gym.agents.training.shipped import ShippedGroup, default_action_mode, read_groups
from prp_gym.artifacts import to_plain
from prp_gym.cli.ship import SCENARIOS
from prp_gym.errors import PRPError
from prp_gym.tasks.spec import TASKS
from tests.support.synthetic_agents import layout_of

GROUPS = read_groups()
CHEAP = "PRP-Adaptive-v0"  # a single link: a hundred episodes take about a second


@cache
def recipes() -> dict[str, Recipe]:
    """By the group's name."""
    made = [group.recipe() for group in GROUPS]
    return {f"{recipe.environment_id}/{recipe.name}": recipe for recipe in made}


def released_tasks() -> list[str]:
    """Ids of the tasks that belong to a release; other registered tasks need no trained agent."""
    return [spec.id for spec in TASKS.values() if spec.released]


def test_every_released_task_has_agents_with_five_training_seeds() -> None:
    assert {group.environment for group in GROUPS} == set(released_tasks())
    assert min(group.seeds for group in GROUPS) >= 5


def test_three_environments_have_agents_that_set_joint_torques() -> None:
    assert len({group.environment for group in GROUPS if group.action_mode == "torque"}) >= 3


@pytest.mark.parametrize("group", GROUPS, ids=str)
def test_group_has_a_mode_of_its_environment_and_a_recipe(group: ShippedGroup) -> None:
    assert group.action_mode in list_action_modes(layout_of(group.environment))
    recipe = group.recipe()
    assert (recipe.environment_id, recipe.algorithm) == (group.environment, group.algorithm)
    assert recipe.action_mode == group.action_mode


@pytest.mark.parametrize("environment_id", released_tasks())
def test_training_takes_the_mode_of_the_first_shipped_group_by_default(environment_id: str) -> None:
    modes = [group.action_mode for group in GROUPS if group.environment == environment_id]
    assert default_action_mode(environment_id) == modes[0] != "torque"


def test_recipe_names_the_mode_where_no_agents_are_shipped(tmp_path: Path) -> None:
    assert default_action_mode("PRP-Force-RL-v0") is None
    assert default_action_mode("Own-v0") is None
    assert default_action_mode("PRP-Force-v0", tmp_path / "own.yml") is None


def manifest(folder: Path, text: str) -> Path:
    path = folder / "groups.yml"
    path.write_text(text, encoding="utf-8")
    return path


GOOD = "{environment: PRP-Adaptive-v0, algorithm: ppo, action_mode: torque, seeds: 2}"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "holds None; expected a list of groups"),
        ("[]", r"holds \[\]; expected a list of groups"),
        ("groups: 3", "expected a list of groups"),
        ("- [", "cannot be read as YAML"),
        ("- ppo", "is 'ppo'; expected an object"),
        (f"- {GOOD.replace(', seeds: 2', '')}", r"key '\[0\]\.seeds' is missing"),
        (f"- {GOOD.replace('}', ', seed: 3}')}", r"key '\[0\]\.seed' is unknown; did you mean 'seeds'"),
        (f"- {GOOD}\n- {GOOD.replace('2', '3')}", "one that is listed once"),
        (f"- {GOOD.replace('2', '0')}", "seeds of a group is 0"),
        (f"- {GOOD.replace('2', '500')}", "seeds of a group is 500"),
        (f"- {GOOD.replace('2', 'true')}", r"seeds' is True; expected a whole number"),
        (f"- {GOOD.replace('torque', '3')}", r"action_mode' is 3; expected text"),
    ],
)
def test_list_that_is_none_is_refused(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(PRPError, match=told):
        read_groups(manifest(tmp_path, text))


def test_list_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PRPError, match=r"nothing\.yml"):
        read_groups(tmp_path / "nothing.yml")


def test_list_of_a_file_takes_the_place_of_the_own_one(tmp_path: Path) -> None:
    (group,) = read_groups(manifest(tmp_path, f"- {GOOD}"))
    assert group == ShippedGroup("PRP-Adaptive-v0", "ppo", "torque", 2)


@pytest.mark.skipif(not list_agents(), reason="no agents come with this tree")
def test_agents_that_come_with_the_package_are_those_of_the_list() -> None:
    assert set(list_agents()) == set(recipes())
    counts = {name: group.seeds for name, group in zip(recipes(), GROUPS, strict=True)}
    assert {name: len(list_seeds(name)) for name in list_agents()} == counts


@pytest.mark.parametrize("name", list_agents())
def test_every_training_seed_was_trained_as_the_recipe_says(name: str) -> None:
    for number, agent in enumerate(list_seeds(name)):
        assert agent == f"{name}_seed_{number}"
        card, recipe = load_agent(agent).card, recipes()[name]
        assert to_plain(card.run.hyperparameters) == to_plain(recipe.to_plain())
        assert card.interface.keywords == recipe.env_kwargs
        assert card.interface.environment_revision == environment_revision(card.environment_id)
        assert (card.environment_id, card.action_mode) == (recipe.environment_id, recipe.action_mode)
        assert (card.seed, card.control_frequency) == (number, recipe.env_kwargs["control_frequency"])
        # PPO ends with whole rollouts, so that a training may be longer than asked for
        assert card.steps >= recipe.n_timesteps


@pytest.mark.parametrize("name", list_agents())
def test_every_training_seed_has_scores_small_files_and_a_command_for_everybody(name: str) -> None:
    for agent in list_seeds(name):
        for suffix in (TENSORS, CARD):
            assert (TRAINED / f"{agent}{suffix}").stat().st_size < 1_000_000
        card = load_agent(agent).card
        assert set(SCENARIOS) <= set(card.scores)
        for score in card.scores.values():
            assert (score.episodes, score.seed) == (100, 0)
            assert score.low <= score.value <= score.high
        words = shlex.split(card.run.command)
        assert words[:3] == ["prp-gym", "train", card.environment_id]
        assert not any(word.startswith("/") for word in words)


@pytest.mark.parametrize("name", list_agents())
def test_agent_acts_on_its_environment(name: str) -> None:
    policy = load_agent(name)
    with closing(policy.make_env()) as env:
        observation, _ = env.reset(seed=0)
        for _ in range(20):
            action, _ = policy.predict(observation)
            assert action.shape == env.action_space.shape
            assert np.all(np.abs(action) <= 1.0)  # false for NaN
            observation, _, terminated, _, _ = env.step(action)
            assert not terminated


@pytest.mark.parametrize("name", list_agents(CHEAP))
def test_score_on_the_card_is_found_again(name: str) -> None:
    policy = load_agent(name)
    score = policy.card.scores["randomized"]
    with closing(policy.make_env(scenario="randomized")) as env:
        found = evaluate(policy, env, score.episodes, score.seed).score
    # other processors round the network's float32 differently: random 3e-7 on every action moved the scores
    # by 2e-8, and a ten-thousandth more viscous friction moved them by more than is allowed here
    assert found == pytest.approx((score.value, score.low, score.high), abs=1e-6)
