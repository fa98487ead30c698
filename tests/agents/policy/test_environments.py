"""Cards and recipes name registered environments with declared keywords, and import nothing."""

import hashlib
import json
import pickle
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner

from prp_gym import list_envs
from prp_gym.agents.policy.agent_file import load_agent, save_agent
from prp_gym.agents.policy.environments import check_environment, declared_keywords, environment_revision
from prp_gym.agents.training.recipes import load_recipe
from prp_gym.agents.training.run_export import export_run
from prp_gym.agents.training.train import train
from prp_gym.artifacts import write_json
from prp_gym.cli.main import app
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import AgentFileError, InvalidValueError, PRPError, RunFolderError, UnknownNameError
from prp_gym.files.checksum import seal, unseal
from tests.support.agent_files import POLICY, put, refusal, rewrite
from tests.support.synthetic_agents import ID
from tests.support.training_runs import tiny_job

PAYLOAD = "module_that_writes_a_file"
FOREIGN_ID = f"{PAYLOAD}:{ID}"
CODE = [
    ("action_modes", f"{PAYLOAD}:make"),
    ("vector_entry_point", f"{PAYLOAD}:make"),
    ("wrappers", [PAYLOAD]),
]


@pytest.fixture(autouse=True)
def marker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Path of a file that a module, which can be imported, writes as soon as it is imported."""
    path = tmp_path / "marker"
    code = (
        f"from pathlib import Path\nPath({str(path)!r}).touch()\ndef make(*_, **__):\n    raise RuntimeError"
    )
    (tmp_path / f"{PAYLOAD}.py").write_text(code, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, PAYLOAD, raising=False)
    return path


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    """Path of an agent's files, without suffix."""
    save_agent(POLICY, tmp_path / "agent")
    return tmp_path / "agent"


def test_module_writes_its_file_when_it_is_imported(marker: Path) -> None:
    __import__(PAYLOAD)
    assert marker.exists()


def test_card_with_an_id_that_imports_a_module_is_refused(saved: Path, marker: Path) -> None:
    rewrite(saved, put("interface", "environment_id", value=FOREIGN_ID))
    assert f"key 'card.interface': unknown environment '{FOREIGN_ID}'" in refusal(saved)
    assert not marker.exists()


@pytest.mark.parametrize(("keyword", "value"), CODE[:2])
def test_card_with_a_keyword_that_imports_a_module_is_refused(
    saved: Path, marker: Path, keyword: str, value: str
) -> None:
    rewrite(saved, put("interface", "keywords", keyword, value=value))
    assert f"key 'card.interface': unknown keyword of environment '{ID}' '{keyword}'" in refusal(saved)
    assert not marker.exists()


@pytest.mark.parametrize(
    ("environment_id", "keyword"),
    [(ID, "max_episode_steps"), (ID, "disable_env_checker"), (ID, "num_threads"), (ID, "task")],
)
def test_card_with_a_keyword_that_is_not_declared_is_refused(
    saved: Path, environment_id: str, keyword: str
) -> None:
    rewrite(saved, put("interface", "keywords", keyword, value=1))
    assert f"unknown keyword of environment '{environment_id}' '{keyword}'" in refusal(saved)


def test_misspelt_id_of_a_card_is_refused_with_the_nearest(saved: Path) -> None:
    rewrite(saved, put("interface", "environment_id", value=f"{ID[:-1]}1"))
    assert f"Did you mean '{ID}'?" in refusal(saved)


@pytest.mark.parametrize(("keyword", "value"), CODE)
def test_recipe_with_a_keyword_that_imports_a_module_is_refused(
    tmp_path: Path, marker: Path, keyword: str, value: Any
) -> None:
    recipes = tmp_path / "own.yml"
    entry = {"n_timesteps": 1, "n_envs": 1, "policy": "MlpPolicy", "env_kwargs": {keyword: value}}
    recipes.write_text(yaml.safe_dump({"default": entry}), encoding="utf-8")
    with pytest.raises(UnknownNameError, match=f"unknown keyword of environment '{ID}' '{keyword}'"):
        load_recipe("ppo", ID, config=recipes)
    assert not marker.exists()


def test_recipe_for_an_id_that_imports_a_module_is_refused(tmp_path: Path, marker: Path) -> None:
    recipes = tmp_path / "own.yml"
    recipes.write_text(yaml.safe_dump({FOREIGN_ID: {"n_envs": 1}}), encoding="utf-8")
    for environment_id, config in ((FOREIGN_ID, None), (ID, recipes)):
        with pytest.raises(UnknownNameError, match=f"'{FOREIGN_ID}'"):
            load_recipe("ppo", environment_id, config=config)
    with pytest.raises(UnknownNameError, match="unknown environment"):
        replace(load_recipe("ppo", ID), environment_id=FOREIGN_ID)
    assert not marker.exists()


@pytest.mark.parametrize(
    ("key", "value"), [("environment", FOREIGN_ID), ("env_kwargs", {"action_modes": f"{PAYLOAD}:make"})]
)
def test_altered_settings_of_a_run_import_no_module(
    tmp_path: Path, marker: Path, key: str, value: Any
) -> None:
    job = tiny_job(tmp_path / "run")
    train(job)
    config = job.folder / "config.yml"
    content = yaml.safe_load(config.read_text(encoding="utf-8"))
    text = yaml.safe_dump({**content, key: value})
    config.write_text(text, encoding="utf-8")
    with pytest.raises(RunFolderError, match=r"'config\.yml' was altered since the run began"):
        export_run(job.folder)
    facts = json.loads((job.folder / "run.json").read_bytes())  # as if the checksums were adapted, too
    facts = {**unseal(config, facts), "recipe_sha256": hashlib.sha256(text.encode()).hexdigest()}
    write_json(job.folder / "run.json", seal(facts))
    with pytest.raises(UnknownNameError):
        export_run(job.folder)
    assert not marker.exists()


@pytest.mark.parametrize(
    "changes",
    [
        [put("interface", "environment_id", value=FOREIGN_ID)],
        [put("interface", "keywords", "action_modes", value=f"{PAYLOAD}:make")],
        [put("interface", "keywords", "entry_point", value=f"{PAYLOAD}:make")],
        [put("interface", "keywords", "action_mode", value=f"{PAYLOAD}:make")],
        [put("interface", "keywords", "scenario", value=f"{PAYLOAD}:make")],
        [put("algorithm", value=f"{PAYLOAD}:make"), put("interface", "keywords", "x", value=1)],
        [put("network", "activation", value=f"{PAYLOAD}:make")],
        [put("network", "head", value=f"{PAYLOAD}:make")],
        [put("interface", "features", value=[f"{PAYLOAD}:make"])],
    ],
)
def test_no_command_and_no_function_runs_the_code_that_a_card_names(
    saved: Path, marker: Path, changes: list[Any]
) -> None:
    for change in changes:
        rewrite(saved, change)
    with pytest.raises(AgentFileError):
        load_agent(saved).make_env()
    commands = (
        ["compare", "--env", ID, "--agent", str(saved), "--output", str(saved.parent / "out"), "--jobs", "1"],
        ["tune", "joint_pd", "--env", ID, "--like", str(saved), "--output", str(saved.parent / "out")],
    )
    for command in commands:
        result = CliRunner().invoke(app, command)
        assert isinstance(result.exception, PRPError), (command, result.output)
    assert not marker.exists()


@pytest.mark.parametrize(
    "name",
    [
        *("id", "max_episode_steps", "disable_env_checker", "num_envs", "vectorization_mode"),
        *("vector_kwargs", "wrappers", "entry_point", "additional_wrappers", "kwargs", "order_enforce"),
        *(
            "autoreset",
            "apply_api_compatibility",
            "task",
            "num_threads",
            "reward_threshold",
            "nondeterministic",
        ),
    ],
)
def test_no_argument_of_gymnasiums_own_is_a_keyword(name: str) -> None:
    for environment_id in list_envs():
        with pytest.raises(UnknownNameError, match=f"'{name}'"):
            check_environment(environment_id, {name: 1})


ALLOWED: list[dict[str, Any]] = [
    {"scenario": "report", "control_frequency": 50, "action_mode": "impedance"},
    {"torque_limit": [1.0, 2.0, 3.0]},
    {"torque_limit": None, "duration": 3600},
    {"render_mode": "rgb_array", "width": 64, "height": 64, "camera": "top"},
]


@pytest.mark.parametrize("keywords", ALLOWED)
def test_keywords_within_their_bounds_are_allowed(keywords: dict[str, Any]) -> None:
    check_environment("PRP-Impedance-v0", keywords)


@pytest.mark.parametrize(
    "keywords",
    [
        {"scenario": "reports"},
        {"scenario": ["report"]},
        {"scenario": {"report": 1}},
        {"action_mode": "impedanse"},
        {"action_mode": f"residual:{PAYLOAD}"},
        {"action_mode": [1.0]},
        {"control_frequency": 1e400},
        {"control_frequency": "fast"},
        {"control_frequency": 0},
        {"control_frequency": 300, "action_mode": "impedance"},
        {"duration": 3601.0},
        {"duration": 1e300},
        {"duration": float("nan")},
        {"duration": True, "scenario": 3},
        {"torque_limit": [1.0] * 1000},
        {"torque_limit": ["1.0"]},
        {"torque_limit": -1.0},
        {"torque_limit": [[1.0]]},
        {"render_mode": "human"},
        {"render_mode": "window"},
        {"width": 10**9},
        {"width": 1.5},
        {"camera": "x" * 10_000},
        {"camera": b"top"},
        {"surface_stiffness": "hard"},
        {"surface_stiffness": 1e300},
        {"surface_normal": [1.0, 2.0]},
        {"surface_normal": [0.0, 0.0, 0.0]},
        {"target_stiffness": [1.0, 2.0]},
        {"target_stiffness": -1.0},
    ],
)
def test_value_of_a_keyword_out_of_its_bounds_is_refused(keywords: dict[str, Any]) -> None:
    with pytest.raises(PRPError) as caught:
        check_environment("PRP-Impedance-v0", keywords)
    assert len(str(caught.value)) < 800


def test_card_and_recipe_check_the_values_of_keywords(saved: Path) -> None:
    rewrite(saved, put("interface", "keywords", "duration", value=5000.0))
    assert "duration in a file is 5000.0 s; allowed: at most 3600" in refusal(saved)
    with pytest.raises(UnknownNameError, match=r"unknown scenario 'reports'\. Did you mean 'report'"):
        load_recipe("ppo", ID, overrides=["env_kwargs.scenario=reports"])
    with pytest.raises(InvalidValueError, match="render_mode in a file is 'human'"):
        load_recipe("ppo", ID, overrides=["env_kwargs.render_mode=human"])


@pytest.mark.parametrize("environment_id", list_envs())
def test_common_keywords_are_declared_but_not_the_task_itself(environment_id: str) -> None:
    names = {field.name for field in fields(EnvConfig)}
    assert names <= declared_keywords(environment_id)
    assert declared_keywords(environment_id).isdisjoint({"action_modes", "task"})


def test_keywords_of_a_task_are_declared_for_it_alone() -> None:
    own = declared_keywords("PRP-Force-v0") - declared_keywords("PRP-JointRegulation-v0")
    assert own == {
        *("surface_stiffness", "surface_damping", "surface_normal", "surface_offset", "desired_force")
    }
    check_environment("PRP-Force-v0", {"desired_force": 2.0})
    with pytest.raises(UnknownNameError, match="'desired_force'"):
        check_environment("PRP-JointRegulation-v0", {"desired_force": 2.0})


def test_refusal_survives_pickling() -> None:
    with pytest.raises(UnknownNameError) as caught:
        check_environment(ID, {"scenari": "report"})
    copy = pickle.loads(pickle.dumps(caught.value))
    assert str(copy) == str(caught.value)
    assert (copy.name, copy.valid) == ("scenari", tuple(sorted(declared_keywords(ID))))


def test_revision_is_that_of_a_registered_environment() -> None:
    assert {environment_revision(name) for name in list_envs()} == {2}
    with pytest.raises(UnknownNameError, match="unknown environment 'PRP-Froce-v0'"):
        environment_revision("PRP-Froce-v0")
