"""`prp-gym train`: several seeds, interruption by force, and refusals."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.agents.training.recipes import SEEDS
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.shipped import read_groups
from prp_gym.agents.training.train import train
from prp_gym.cli.main import app
from prp_gym.tasks.presets import learning_id
from tests.cli.test_main import plain, refusal
from tests.support.training_runs import ID, TINY, assert_same_weights, tiny_job

RUNNER = CliRunner()
GROUP = Path(ID) / "ppo_torque"


def options(*more: str, algorithm: str = "ppo") -> list[str]:
    sets = [item for text in TINY[algorithm] for item in ("--set", text)]
    common = ["--algo", algorithm, "--action-mode", "torque", "--eval-every", "128", "--eval-episodes", "4"]
    common.append("--no-tensorboard")
    return ["train", ID, *common, *sets, *more]


def run_here(folder: Path, *more: str, algorithm: str = "ppo") -> str:
    """What the command says, in this process."""
    given = options("--output", str(folder), "--jobs", "1", *more, algorithm=algorithm)
    result = RUNNER.invoke(app, given)
    assert result.exit_code == 0, result.output
    return plain(result.output)


def command(folder: Path, *more: str, algorithm: str = "ppo") -> list[str]:
    start = [sys.executable, "-W", "error", "-m", "prp_gym.cli.main"]
    return [*start, *options("--output", str(folder), *more, algorithm=algorithm)]


def result_of(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "result.json").read_text())
    return content


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of seeds 3 and 4, each trained alone in this process."""
    folder = tmp_path_factory.mktemp("alone")
    for seed in (3, 4):
        train(tiny_job(folder / f"seed_{seed}", seed=seed))
    return folder


def test_seeds_trained_in_parallel_are_those_trained_alone(tmp_path: Path, alone: Path) -> None:
    run_here(tmp_path, "--seeds", "2", "--first-seed", "3", "--jobs", "2")
    assert {path.name for path in (tmp_path / GROUP).iterdir()} == {"seed_3", "seed_4"}
    for seed in ("seed_3", "seed_4"):
        assert_same_weights(tmp_path / GROUP / seed, alone / seed)
        assert result_of(tmp_path / GROUP / seed)["best"] == result_of(alone / seed)["best"]


def test_finished_seeds_are_told_and_only_the_others_trained(tmp_path: Path) -> None:
    run_here(tmp_path)
    before = (tmp_path / GROUP / "seed_0" / "result.json").stat().st_mtime_ns
    output = run_here(tmp_path, "--seeds", "2")
    assert "1 of 2 seeds are finished." in output
    assert (tmp_path / GROUP / "seed_0" / "result.json").stat().st_mtime_ns == before
    for seed in (0, 1):
        best = result_of(tmp_path / GROUP / f"seed_{seed}")["best"]
        assert [str(seed), f"{best['score']:.3f}"] in [line.split()[:2] for line in output.splitlines()]
    run = json.loads((tmp_path / GROUP / "seed_1" / "run.json").read_text())
    assert run["command"].startswith("prp-gym ")


@pytest.mark.parametrize("algorithm", ["sac"])  # whose checkpoints have most in them
def test_training_that_was_killed_goes_on_to_the_same_number_of_steps(tmp_path: Path, algorithm: str) -> None:
    long = ("--set", "n_timesteps=896", "--jobs", "1")
    folder = tmp_path / ID / f"{algorithm}_torque" / "seed_0"
    process = subprocess.Popen(command(tmp_path, *long, algorithm=algorithm), stdout=subprocess.DEVNULL)
    for _ in range(60_000):
        if any(path.name >= "checkpoint-000000000256" for path in folder.glob("checkpoint-*")):
            break
        time.sleep(0.001)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert not (folder / "result.json").exists()
    run_here(tmp_path, *long, algorithm=algorithm)
    result = result_of(folder)
    assert result["resumes"] == 1
    assert result["steps"] == 896
    rows = json.loads((folder / "curve.json").read_text())["rows"]
    steps = [row["steps"] for row in rows]
    assert steps == sorted(set(steps))
    assert len(steps) == 7  # every 128 steps


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--seeds", "0"], "seeds is 0"),
        (["--first-seed", "-1"], "first_seed is -1"),
        (["--first-seed", str(SEEDS)], f"last seed is {SEEDS}"),
        (["--eval-every", "-1"], "eval_every is -1"),
        (["--eval-episodes", "0"], "eval_episodes is 0"),
        (["--checkpoint-every", "-1"], "checkpoint_every is -1"),
        (["--algo", "ppoo"], "Did you mean 'ppo'"),
        (["--action-mode", "torqe"], "Did you mean 'torque'"),
        (["--set", "n_step=3"], "Did you mean 'n_steps'"),
        (["--set", "env_kwargs.scenari=report"], "Did you mean 'scenario'"),
        (["--set", "env_kwargs.control_frequency=7"], "control_frequency is 7"),
        (["--config", "nothing.yml"], "nothing.yml"),
        (["--backend", "lokky"], "Did you mean 'loky'"),
    ],
)
def test_what_cannot_be_trained_is_refused_before_a_folder_is_made(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    more: list[str],
    told: str,
) -> None:
    error = refusal(capsys, monkeypatch, "train", ID, "--output", str(tmp_path / "runs"), *more)
    assert told in error
    assert not (tmp_path / "runs").exists()


def test_settings_other_than_those_of_the_folder_are_refused(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    run_here(tmp_path)
    more = ("--output", str(tmp_path), "--resume", "--set", "batch_size=32")
    error = refusal(capsys, monkeypatch, *options(*more))
    assert "batch_size is 64 there and 32 here" in error


def test_without_stable_baselines_the_extra_is_told(tmp_path: Path) -> None:
    hidden = "import sys; sys.modules['stable_baselines3'] = None; from prp_gym.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", hidden, "train", ID, "--output", str(tmp_path / "runs")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2
    assert "stable_baselines3 is not installed; install it with: pip install 'prp-gym[agents]'" in (
        " ".join(done.stderr.split())
    )


def test_progress_is_read_from_the_folders(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    assert folder.read_steps() == 0
    folder.progress.write_text('{"steps": 12}')
    assert folder.read_steps() == 12
    folder.progress.write_text('{"st')
    assert folder.read_steps() == 0
    folder.result.write_text('{"steps": 99}')
    assert folder.read_steps() == 99


def test_evaluations_are_a_tenth_of_training_apart_unless_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs = []

    def stop(job: Any) -> bool:
        jobs.append(job)
        raise KeyboardInterrupt

    monkeypatch.setattr("prp_gym.agents.training.train.is_ready", stop)
    chosen = ["--action-mode", "torque", "--set", "n_timesteps=5000"]
    RUNNER.invoke(app, ["train", ID, "--output", str(tmp_path), *chosen])
    assert (jobs[0].eval_every, jobs[0].checkpoint_every, jobs[0].eval_episodes) == (500, 500, 20)
    assert jobs[0].folder == tmp_path / GROUP / "seed_0"


def test_default_action_mode_is_that_of_the_shipped_agents(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs = []

    def stop(job: Any) -> bool:
        jobs.append(job)
        raise KeyboardInterrupt

    monkeypatch.setattr("prp_gym.agents.training.train.is_ready", stop)
    RUNNER.invoke(app, ["train", ID, "--output", str(tmp_path)])
    (shipped, *_) = (group for group in read_groups() if group.environment == ID)
    assert (jobs[0].recipe.environment_id, jobs[0].recipe.action_mode) == (ID, shipped.action_mode)


def test_agent_of_a_learning_preset_keeps_its_id(tmp_path: Path) -> None:
    preset = learning_id(ID)
    given = [preset if part == ID else part for part in options("--output", str(tmp_path), "--jobs", "1")]
    result = RUNNER.invoke(app, given)
    assert result.exit_code == 0, result.output
    card = load_agent(tmp_path / preset / "ppo_torque" / "seed_0" / "agent").card
    assert (card.environment_id, card.task_id, card.control_frequency) == (preset, ID, 50.0)
    assert card.interface.features == tuple(part.name for part in card.interface.observation)
