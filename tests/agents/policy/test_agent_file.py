"""Files of trained agents: what is written is read again; those of the package by their names."""

import hashlib
import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import prp_gym
from prp_gym.agents.policy import agent_file
from prp_gym.agents.policy.agent_card import PlainFeatures
from prp_gym.agents.policy.agent_file import list_agents, list_seeds, load_agent, save_agent
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.errors import AgentFileError, OutputError, PRPError, UnknownNameError
from tests.support.agent_files import (
    POLICY,
    card_of,
    checksum,
    refusal,
    rewrite,
    tensors_of,
)
from tests.support.synthetic_agents import ID, RUN, layout_of, observations, synthetic_policy


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Path of an agent's files, without suffix."""
    save_agent(POLICY, tmp_path / "agent")
    return tmp_path / "agent"


def assert_same(found: LearnedPolicy, expected: LearnedPolicy) -> None:
    assert replace(found.card, sha256="") == replace(expected.card, sha256="")
    for name in ("mean", "variance", "epsilon", "clip"):
        np.testing.assert_array_equal(getattr(found.normalizer, name), getattr(expected.normalizer, name))
    assert found.network.tensors.keys() == expected.network.tensors.keys()
    for name, values in expected.network.tensors.items():
        np.testing.assert_array_equal(found.network.tensors[name], values)
    batch = observations(4)
    np.testing.assert_array_equal(found.predict(batch)[0], expected.predict(batch)[0])


@pytest.mark.parametrize("suffix", ["", ".safetensors", ".json"])
@pytest.mark.parametrize("kind", [str, Path])
def test_agent_is_read_as_it_was_written(tmp_path: Path, suffix: str, kind: Callable[[str], Any]) -> None:
    for memory in ((), (3, 2)):
        policy = synthetic_policy({"report": 0.25, "realistic": 0.5}, memory)
        path = kind(f"{tmp_path}/folder/ppo_v0.5{suffix}")
        assert [file.name for file in save_agent(policy, path)] == ["ppo_v0.5.safetensors", "ppo_v0.5.json"]
        assert_same(load_agent(path), policy)
    assert sorted(os.listdir(tmp_path / "folder")) == ["ppo_v0.5.json", "ppo_v0.5.safetensors"]


def test_same_agent_gives_the_same_files(tmp_path: Path, saved: Path) -> None:
    save_agent(load_agent(saved), tmp_path / "again")
    assert tensors_of(tmp_path / "again").read_bytes() == tensors_of(saved).read_bytes()
    assert card_of(tmp_path / "again").read_bytes() == card_of(saved).read_bytes()


def test_card_holds_digest_and_checksum(saved: Path) -> None:
    whole = json.loads(card_of(saved).read_text(encoding="utf-8"))
    assert whole["format"] == 1
    assert whole["checksum"] == checksum(whole["card"])
    assert whole["card"]["sha256"] == hashlib.sha256(tensors_of(saved).read_bytes()).hexdigest()
    assert load_agent(saved).card.sha256 == whole["card"]["sha256"]


def test_revision_of_the_environment_is_stored(tmp_path: Path) -> None:
    card = replace(POLICY.card, interface=replace(POLICY.card.interface, environment_revision=3))
    save_agent(LearnedPolicy(card, POLICY.normalizer, POLICY.network), tmp_path / "agent")
    whole = json.loads(card_of(tmp_path / "agent").read_text(encoding="utf-8"))
    assert whole["card"]["interface"]["environment_revision"] == 3
    assert load_agent(tmp_path / "agent").card.interface.environment_revision == 3


def test_card_without_a_revision_is_of_revision_1(saved: Path) -> None:
    rewrite(saved, lambda card: card["interface"].pop("environment_revision"))
    loaded = load_agent(saved)
    assert loaded.card.interface.environment_revision == 1
    assert_same(loaded, POLICY)


def test_agent_that_could_not_be_read_again_is_not_written(tmp_path: Path) -> None:
    for value in (np.nan, np.inf):
        with pytest.raises(AgentFileError, match=r"key 'card.scores.report.value' is .*; expected a number"):
            save_agent(synthetic_policy({"report": value}), tmp_path / "agent")
    policy = synthetic_policy()
    broken = LearnedPolicy(policy.card, replace(policy.normalizer, epsilon=np.nan), policy.network)
    with pytest.raises(AgentFileError, match=r"tensor 'normalizer\.epsilon' has NaN or infinity"):
        save_agent(broken, tmp_path / "agent")
    card = replace(policy.card, run=replace(policy.card.run, command="\ud800"))
    with pytest.raises(AgentFileError, match="is not text in UTF-8"):
        save_agent(LearnedPolicy(card, policy.normalizer, policy.network), tmp_path / "agent")
    assert list(tmp_path.iterdir()) == []


def test_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        save_agent(POLICY, tmp_path / "file" / "agent")


def test_missing_file_is_told(saved: Path) -> None:
    card, tensors = card_of(saved), tensors_of(saved)
    content = card.read_bytes()
    card.unlink()
    assert f"{card}': is missing; an agent is two files" in refusal(saved)
    card.write_bytes(content)
    tensors.unlink()
    assert f"{tensors}': is missing; an agent is two files" in refusal(str(saved))
    assert "is missing" in refusal(saved.parent / "other")
    tensors.mkdir()
    assert "is a directory; only a regular file is read" in refusal(saved)


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in the place of that of the package's agents."""
    monkeypatch.setattr(agent_file, "TRAINED", tmp_path)
    return tmp_path


def ship(folder: Path, scores: dict[int, float], group: str = f"{ID}/ppo_torque") -> None:
    for seed, value in scores.items():
        run = replace(RUN, seed=seed)
        policy = synthetic_policy({"realistic": value, "report": -value}, seed=seed, run=run)
        save_agent(policy, folder / f"{group}_seed_{seed}")


@pytest.mark.parametrize(
    ("scores", "median"),
    [
        ({0: 0.1, 1: 0.9, 2: 0.5}, 2),
        ({0: 0.1, 1: 0.5, 2: 0.9, 3: 0.7, 4: 0.2}, 1),
        ({0: 0.9, 1: 0.5, 2: 0.1, 3: 0.7}, 1),  # the lower of the two in the middle
        ({0: 0.5, 1: 0.5, 2: 0.5}, 1),
        ({7: 0.3}, 7),
        ({2: 0.2, 10: 0.3, 9: 0.9}, 10),
    ],
)
def test_group_loads_the_training_seed_of_median_score(
    shipped: Path, scores: dict[int, float], median: int
) -> None:
    ship(shipped, scores)
    assert load_agent(f"{ID}/ppo_torque").card.seed == median
    for seed in scores:
        assert load_agent(f"{ID}/ppo_torque_seed_{seed}").card.seed == seed
    assert list_seeds(f"{ID}/ppo_torque") == [f"{ID}/ppo_torque_seed_{seed}" for seed in sorted(scores)]


def test_median_needs_scores_where_there_are_several(shipped: Path) -> None:
    ship(shipped, {0: 0.1})
    save_agent(synthetic_policy({"report": 0.5}), shipped / ID / "ppo_torque_seed_1")
    assert "has no score in scenario 'realistic', in which it was trained" in refusal(f"{ID}/ppo_torque")


def test_agents_are_listed_by_group(shipped: Path) -> None:
    assert list_agents() == []
    ship(shipped, {0: 0.1, 1: 0.2})
    ship(shipped, {0: 0.1}, f"{ID}/sac_residual-joint_pd")
    ship(shipped, {0: 0.1}, "PRP-Force-v0/ppo_torque")
    own = [f"{ID}/ppo_torque", f"{ID}/sac_residual-joint_pd"]
    assert list_agents() == ["PRP-Force-v0/ppo_torque", *own]
    assert list_agents(ID) == own
    assert list_agents("PRP-Admittance-v0") == []
    with pytest.raises(
        UnknownNameError, match=r"unknown environment 'PRP-Froce-v0'. Did you mean 'PRP-Force-v0'"
    ):
        list_agents("PRP-Froce-v0")
    with pytest.raises(UnknownNameError, match=r"unknown group of agents"):
        list_seeds("no/such")


@pytest.mark.parametrize("name", [f"{ID}/ppo_torqe", f"{ID}/ppo_torque_seed_9", "../secret", ""])
def test_unknown_name_is_refused_with_the_nearest(shipped: Path, name: str) -> None:
    ship(shipped, {0: 0.1})
    with pytest.raises(UnknownNameError, match="unknown agent") as caught:
        load_agent(name)
    assert caught.value.valid == (f"{ID}/ppo_torque", f"{ID}/ppo_torque_seed_0")
    if "ppo" in name:
        assert "Did you mean 'PRP-JointTracking-v0/ppo_torque" in str(caught.value)


def test_damaged_agent_of_the_package_is_refused_by_name(shipped: Path) -> None:
    ship(shipped, {0: 0.1})
    tensors_of(shipped / ID / "ppo_torque_seed_0").unlink()
    assert "is missing" in refusal(f"{ID}/ppo_torque")


@pytest.mark.parametrize("name", prp_gym.list_agents())
def test_every_agent_of_the_package_is_whole(name: str) -> None:
    for one in (name, *list_seeds(name)):
        policy = load_agent(one)
        policy.make_env().close()
        assert one.startswith(f"{policy.card.environment_id}/")


def test_errors_of_files_are_caught_by_their_root(saved: Path) -> None:
    tensors_of(saved).unlink()
    with pytest.raises(PRPError):
        load_agent(saved)


def test_plain_features_are_the_observation(tmp_path: Path) -> None:
    features = PlainFeatures(layout_of(ID))
    assert (features.names, features.size) == (layout_of(ID).names, 27)
    np.testing.assert_array_equal(features(observations(2)), observations(2))
