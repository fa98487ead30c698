"""Which agents are compared, and which are refused."""

from dataclasses import replace
from pathlib import Path

import pytest

from prp_gym.agents.policy import agent_file
from prp_gym.agents.policy.agent_card import CurvePoint
from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.comparison.agents import digest, find_agents, learning_history
from prp_gym.errors import InvalidValueError
from tests.support.synthetic_agents_to_compare import save

ID, OTHER = "PRP-JointTracking-v0", "PRP-Adaptive-v0"


@pytest.fixture(autouse=True)
def trained(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A folder in the place of that of the package's agents."""
    monkeypatch.setattr(agent_file, "TRAINED", tmp_path / "trained")


def test_agents_of_the_package_are_grouped_over_training_seeds(tmp_path: Path) -> None:
    for seed in (0, 1, 10):
        save(tmp_path / "trained" / ID / f"ppo_torque_seed_{seed}", seed=seed)
    save(tmp_path / "trained" / ID / "sac_torque_seed_0")
    save(tmp_path / "trained" / OTHER / "ppo_torque_seed_0", environment_id=OTHER)
    found = find_agents([ID], [])
    assert {(agent.group, agent.training_seed) for agent in found} == {
        ("ppo_torque", 0),
        ("ppo_torque", 1),
        ("ppo_torque", 10),
        ("sac_torque", 0),
    }
    assert {agent.environment_id for agent in find_agents([OTHER, ID], [])} == {ID, OTHER}
    assert [agent.training_seed for agent in found] == [0, 1, 10, 0]
    assert len({agent.sha256 for agent in found}) == 3  # two files of seed 0 are alike


def test_run_folder_gives_the_agents_of_all_its_training_seeds(tmp_path: Path) -> None:
    run = tmp_path / "runs" / ID / "sac_joint_position"
    for seed in (0, 1):
        save(run / f"seed_{seed}" / "agent", seed=seed, action_mode="joint_position")
    expected = {("sac_joint_position", seed, "joint_position", 50.0) for seed in (0, 1)}
    found = find_agents([ID], [run])
    assert {(a.group, a.training_seed, a.mode, a.control_frequency) for a in found} == expected
    (one,) = find_agents([ID], [run / "seed_1"])
    assert (one.group, one.training_seed) == ("sac_joint_position", 1)


@pytest.mark.parametrize("suffix", ["", ".json", ".safetensors"])
def test_file_is_named_with_or_without_suffix(tmp_path: Path, suffix: str) -> None:
    stem = save(tmp_path / "mine_seed_3", seed=3)
    (agent,) = find_agents([ID], [Path(f"{stem}{suffix}")])
    assert (agent.group, agent.path, agent.sha256) == ("mine", str(stem), digest(stem))


def test_path_is_a_path_even_where_it_reads_as_a_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"{ID}/ppo_torque_seed_0"
    save(tmp_path / "trained" / name, seed=0)
    save(tmp_path / "own" / name, seed=5)
    monkeypatch.chdir(tmp_path / "own")
    assert [agent.training_seed for agent in find_agents([ID], [Path(name)])] == [0, 5]


def test_groups_of_one_name_are_told_apart(tmp_path: Path) -> None:
    save(tmp_path / "trained" / ID / "ppo_torque_seed_0")
    run = tmp_path / "runs" / ID / "ppo_torque"
    save(run / "seed_0" / "agent")
    assert [agent.group for agent in find_agents([ID], [run, run])] == [
        "ppo_torque",
        "ppo_torque (2)",
        "ppo_torque (3)",
    ]


def test_agent_of_another_environment_is_refused(tmp_path: Path) -> None:
    stem = save(tmp_path / "mine", environment_id=OTHER)
    with pytest.raises(InvalidValueError, match=f"environment of agent .*mine.* is '{OTHER}'.*{ID}"):
        find_agents([ID], [stem])


def test_path_without_agents_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "nothing", tmp_path / "nothing.safetensors"):
        with pytest.raises(InvalidValueError, match="agent is"):
            find_agents([ID], [path])


@pytest.mark.parametrize(
    ("second", "message"),
    [
        ({"seed": 0}, "training seed of agent"),
        ({"seed": 1, "action_mode": "joint_position"}, "mode of agent"),
        ({"seed": 1, "control_frequency": 100.0}, "control_frequency of agent"),
    ],
)
def test_group_whose_agents_differ_in_more_than_the_training_seed_is_refused(
    tmp_path: Path, second: dict[str, object], message: str
) -> None:
    save(tmp_path / "run" / "seed_0" / "agent")
    save(tmp_path / "run" / "seed_1" / "agent", **second)  # type: ignore[arg-type]
    with pytest.raises(InvalidValueError, match=message):
        find_agents([ID], [tmp_path / "run"])


@pytest.mark.parametrize("suffix", [".json", ".safetensors"])
def test_digest_changes_with_either_file(tmp_path: Path, suffix: str) -> None:
    stem = save(tmp_path / "mine")
    before = digest(stem)
    with Path(f"{stem}{suffix}").open("a") as file:
        file.write(" ")
    assert digest(stem) != before


def test_history_is_the_cards_curve(tmp_path: Path) -> None:
    card = load_agent(save(tmp_path / "mine", scenario="realistic")).card
    assert learning_history(card) == {
        "scenario": "realistic",
        "control_frequency": 50.0,
        "steps": [1000, 2000],
        "seconds": [6.0, 12.0],
        "score": [0.05, 0.999],
        "violations": [2.0, 3.0],
    }
    assert learning_history(replace(card, run=replace(card.run, curve=()))) == {}
    one = replace(card.run, curve=(CurvePoint(1000, 6.0, 0.5, {}),))
    assert learning_history(replace(card, run=one))["violations"] == [0.0]
