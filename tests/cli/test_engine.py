"""`--engine`: the same results from both engines, which are never mixed, and errors that name the option."""

import json
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner

from prp_gym.agents.policy import agent_file
from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.cli import options
from prp_gym.cli.main import app
from prp_gym.errors import CompilerError, InvalidValueError, RunFolderError, UnknownNameError
from prp_gym.tasks.setup import COMPILED, ENGINES, MUJOCO
from prp_gym.tuning import load_tuned_controller
from prp_gym.tuning.tuned_controller import SEARCHES
from tests.cli.test_train import GROUP
from tests.cli.test_train import options as train_options
from tests.support.compiler import needs_compiler
from tests.support.synthetic_agents_to_compare import save

RUNNER = CliRunner()
TRACKING, FORCE = "PRP-JointTracking-v0", "PRP-Force-v0"
SAME = 1e-6
"""Largest difference of a score: rounding, and the tolerance of MuJoCo's solver where several constraints
act, over the periods of an episode with stable control."""

COMMANDS = {
    "evaluate": ["evaluate", "--env", TRACKING],
    "compare": ["compare", "--env", TRACKING],
    "audit": ["audit", "--env", TRACKING],
    "tune": ["tune", "joint_pd", "--env", TRACKING, "--budget", "100"],
    "tune-all": ["tune-all", "--env", TRACKING],
    "train": ["train", TRACKING],
}


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes of a fifth of a second in this process."""
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.2))
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def run(*arguments: str) -> tuple[str, str]:
    """Standard output and error of a command in this process."""
    result = RUNNER.invoke(app, list(arguments))
    assert result.exit_code == 0, result.output
    return " ".join(result.stdout.split()), " ".join(result.stderr.split())


def evaluations(folder: Path) -> list[dict[str, Any]]:
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    rows: list[dict[str, Any]] = content["evaluations"]
    return rows


def scores(row: dict[str, Any]) -> list[float]:
    """Score of each episode."""
    return [score for (score,) in row["episodes"]["score"]]


@pytest.mark.parametrize("command", COMMANDS)
def test_engine_that_does_not_exist_is_refused(command: str, tmp_path: Path) -> None:
    result = RUNNER.invoke(app, [*COMMANDS[command], "--engine", "bullet", "--output", str(tmp_path / "out")])
    assert isinstance(result.exception, UnknownNameError)
    assert str(result.exception).startswith("unknown --engine 'bullet'")
    assert all(name in str(result.exception) for name in ENGINES)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_without_a_compiler_the_option_is_named_before_anything_is_done(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def find_none() -> None:
        raise CompilerError("there is none.")

    monkeypatch.setattr(options, "require_compiled_code", find_none)
    result = RUNNER.invoke(app, [*COMMANDS[command], "--engine", COMPILED, "--output", str(tmp_path / "out")])
    assert isinstance(result.exception, CompilerError)
    expected = "--engine compiled: there is none. --engine mujoco needs none."
    assert str(result.exception) == expected
    assert not (tmp_path / "out").exists()


EVALUATE = [
    *("evaluate", "--jobs", "1", "--env", TRACKING, "--env", FORCE, "--scenario", "realistic"),
    *("--baseline", "joint_pd", "--baseline", "parallel_force_position", "--baseline", "adaptive"),
    *("--episodes", "3"),
]


@needs_compiler
def test_both_engines_evaluate_alike_and_are_named(short: None, tmp_path: Path) -> None:
    found = {}
    for engine in ENGINES:
        output, _ = run(*EVALUATE, "--engine", engine, "--output", str(tmp_path / engine))
        assert ("scenario realistic, engine compiled: scores" in output) is (engine == COMPILED)
        rows = found[engine] = evaluations(tmp_path / engine)
        assert {row["engine"] for row in rows} == {engine}
    # of PRP-JointTracking-v0 two controllers, of PRP-Force-v0 all three, each with two floors
    assert len(found[MUJOCO]) == 2 + 3 + 2 * 2
    for one, other in zip(found[MUJOCO], found[COMPILED], strict=True):
        assert (one["environment"], one["baseline"]) == (other["environment"], other["baseline"])
        assert scores(other) == pytest.approx(scores(one), abs=SAME)


@needs_compiler
def test_a_run_goes_on_with_records_of_its_own_engine_alone(
    short: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The records of an interrupted run stay, since the command cannot remove them at its end."""
    given = [*EVALUATE, "--output", str(tmp_path)]
    with monkeypatch.context() as patch:
        patch.setattr("prp_gym.runs.store.JobStore.remove", lambda *_: None)
        run(*given)
    _, error = run(*given, "--engine", COMPILED)
    assert error.startswith("0 of 9 jobs were finished by an interrupted run")
    assert error.endswith("Not reused, as damaged or of other settings or code: 9.")
    assert {row["engine"] for row in evaluations(tmp_path)} == {COMPILED}


def folders(path: Path) -> set[Path]:
    """The folders of all evaluations below `results`, without the link to the latest."""
    return {item for item in path.glob("results/evaluate/*") if not item.is_symlink()}


@needs_compiler
def test_new_folder_of_another_engine(short: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without `--output`, an unfinished run of MuJoCo stays as it is."""
    monkeypatch.chdir(tmp_path)
    given = ["evaluate", "--jobs", "1", "--env", TRACKING, "--baseline", "joint_pd", "--episodes", "1"]
    run(*given)
    (first,) = folders(tmp_path)
    record = first / "run.json"
    record.write_text(record.read_text(encoding="utf-8").replace("true", "false"), encoding="utf-8")
    run(*given, "--engine", COMPILED)
    (second,) = folders(tmp_path) - {first}
    assert {row["engine"] for row in evaluations(second)} == {COMPILED}
    run(*given)
    assert folders(tmp_path) == {first, second}
    assert '"finished": true' in record.read_text(encoding="utf-8")  # it was gone on with


TUNE = ["tune", "joint_pd", "--env", TRACKING, "--budget", "1400", "--episodes", "2"]


def search(folder: Path) -> dict[str, Any]:
    path = folder / f"{TRACKING}_joint_pd" / "result.json"
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


@needs_compiler
def test_both_engines_find_the_same_gains_with_the_same_budget(short: None, tmp_path: Path) -> None:
    for engine in ENGINES:
        run(*TUNE, "--engine", engine, "--output", str(tmp_path / engine))
    one, other = (search(tmp_path / engine) for engine in ENGINES)
    assert (one["engine"], other["engine"]) == (MUJOCO, COMPILED)
    for name in ("trials", "used_steps", "budget_steps", "episodes"):
        assert one[name] == other[name], name
    assert other["score"] == pytest.approx(one["score"], abs=SAME)
    assert other["validation"]["finalists"] == pytest.approx(one["validation"]["finalists"], abs=SAME)
    assert other["settings"] == one["settings"]  # rounded, of the same proposals


@needs_compiler
def test_a_search_does_not_go_on_with_the_trials_of_another_engine(short: None, tmp_path: Path) -> None:
    run(*TUNE, "--output", str(tmp_path))
    before = search(tmp_path)
    refused = RUNNER.invoke(app, [*TUNE, "--output", str(tmp_path), "--engine", COMPILED])
    assert isinstance(refused.exception, InvalidValueError)
    assert "{'engine': None}" in str(refused.exception)
    assert "{'engine': 'compiled'}" in str(refused.exception)
    assert search(tmp_path) == before
    run(*TUNE, "--output", str(tmp_path), "--engine", COMPILED, "--fresh")
    assert search(tmp_path)["engine"] == COMPILED


@needs_compiler
def test_all_searches_have_the_engine(short: None, tmp_path: Path) -> None:
    output, _ = run(
        *(
            "tune-all",
            "--env",
            "PRP-Adaptive-v0",
            "--baseline",
            "joint_pd",
            "--budget",
            "4800",
            "--jobs",
            "1",
        ),
        *("--engine", COMPILED, "--output", str(tmp_path)),
    )
    assert "validation of the searches, engine compiled" in output
    (path,) = tmp_path.glob("*/result.json")
    assert load_tuned_controller(path).engine == COMPILED


def test_record_without_an_engine_is_mujocos() -> None:
    folder = Path(str(files("prp_gym.baselines").joinpath(SEARCHES)))
    kept = [path for path in folder.glob("*.json") if "engine" not in json.loads(path.read_text())]
    assert kept
    assert {load_tuned_controller(path).engine for path in kept} == {MUJOCO}


@needs_compiler
def test_comparison_runs_every_policy_with_the_engine(
    short: None, unwritten_figures: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agent_file, "TRAINED", tmp_path / "trained")
    save(tmp_path / "trained" / TRACKING / "ppo_torque_seed_0", 0)
    given = ["compare", "--jobs", "1", "--env", TRACKING, "--baseline", "joint_pd", "--episodes", "2"]
    found = {}
    for engine in ENGINES:
        output, _ = run(*given, "--engine", engine, "--output", str(tmp_path / engine))
        assert ("scenario realistic, engine compiled: scores" in output) is (engine == COMPILED)
        found[engine] = evaluations(tmp_path / engine)
        assert {row["engine"] for row in found[engine]} == {engine}
    assert {row["policy"] for row in found[MUJOCO]} == {"joint_pd", "ppo_torque", "zero_torque", "hold"}
    for one, other in zip(found[MUJOCO], found[COMPILED], strict=True):
        assert scores(other) == pytest.approx(scores(one), abs=SAME)


@needs_compiler
def test_agent_says_with_which_engine_it_was_trained(tmp_path: Path) -> None:
    given = train_options("--output", str(tmp_path), "--jobs", "1", "--engine", COMPILED)
    run(*given)
    folder = RunFolder(tmp_path / GROUP / "seed_0")
    agent = load_agent(folder.agent)
    assert agent.card.engine == COMPILED
    assert agent.environment_keywords["engine"] == COMPILED
    assert "--engine compiled" in agent.card.run.command
    assert folder.read_config()["env_kwargs"]["engine"] == COMPILED
    for keywords, expected in (({}, MUJOCO), ({"engine": COMPILED}, COMPILED)):
        env: Any = agent.make_env(**keywords)
        assert env.unwrapped.config.engine == expected
        env.close()
    without = RUNNER.invoke(app, train_options("--output", str(tmp_path), "--jobs", "1"))
    assert isinstance(without.exception, RunFolderError)
    assert "engine" in str(without.exception)


def test_training_with_mujoco_is_that_without_the_option(tmp_path: Path) -> None:
    """So that runs of before go on."""
    run(*train_options("--output", str(tmp_path), "--jobs", "1"))
    output, error = run(*train_options("--output", str(tmp_path), "--jobs", "1", "--engine", MUJOCO))
    assert "1 of 1 seeds are finished." in error + output
    agent = load_agent(tmp_path / GROUP / "seed_0" / "agent")
    assert agent.card.engine == MUJOCO
    assert "engine" not in agent.environment_keywords
