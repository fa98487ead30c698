"""A small comparison from the command line: what is run, written, printed, reused and refused."""

import json
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from typer.testing import CliRunner

from prp_gym import load_agent
from prp_gym.agents.policy import agent_file
from prp_gym.artifacts import to_plain, write_json
from prp_gym.baselines import BASELINES, make_baseline
from prp_gym.cli.main import app
from prp_gym.comparison import agents as compared_agents
from prp_gym.comparison import jobs as comparison_jobs
from prp_gym.comparison.outcome import Outcome
from prp_gym.errors import DataFileError, InvalidValueError
from prp_gym.evaluation import evaluate
from prp_gym.runs import run as runs
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.job import Job, JobResult, run_job
from prp_gym.tasks.spec import TASKS
from prp_gym.tuning import TunedController, Validation, tuned_controller
from tests.support.synthetic_agents_to_compare import save

RUNNER = CliRunner()
ID = "PRP-JointTracking-v0"
WIDTH = 120
ROUNDING = 1e-12  # of a few sums and quotients in double precision
CONTROLLERS = ("joint_pd", "joint_inverse_dynamics")
GAINS = {"proportional_gain": [50.0, 500.0, 50.0], "derivative_gain": [15.0, 150.0, 15.0]}
TUNED = TunedController(
    environment=ID,
    controller="joint_pd",
    scenarios=("randomized",),
    control_frequency=500.0,
    settings=GAINS,
    budget_steps=5000,
    used_steps=5000,
    simulated_seconds=10.0,
    trials=2,
    episodes=5,
    seconds=1.0,
    history=((2500, 0.2), (5000, 0.4)),
    history_by_scenario={"randomized": (0.2, 0.4)},
    score=0.4,
    score_of_start=0.2,
    edges={},
    validation=Validation(
        seed=500_000_000,
        episodes=5,
        score=0.4,
        score_of_start=0.2,
        kept_start=False,
        gain=0.2,
        gain_error=0.01,
        selection_seed=501_000_000,
        selection_episodes=2,
        selection=(0.4,),
        finalists=(0.4,),
    ),
    seed=0,
    command="prp-gym tune",
    versions={},
)
OPTIONS = [
    "--env",
    ID,
    *(item for controller in CONTROLLERS for item in ("--baseline", controller)),
    "--episodes",
    "3",
]
POLICIES = ["joint_pd", "joint_inverse_dynamics", "ppo_torque", "zero_torque", "hold"]


def shipped_in(folder: Path) -> dict[str, Path]:
    """Tuned controllers of a folder in the place of the package's, by name."""
    paths = {f"{ID}/{controller}": folder / f"{ID}_{controller}.json" for controller in BASELINES}
    return {name: path for name, path in paths.items() if path.is_file()}


@pytest.fixture(autouse=True)
def small_world(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Short episodes, two tiny agents of one group, a tuned controller, no terminal."""
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.2))
    monkeypatch.setattr(agent_file, "TRAINED", tmp_path / "trained")
    for seed in (0, 1):
        save(tmp_path / "trained" / ID / f"ppo_torque_seed_{seed}", seed)
    write_json(tmp_path / "searches" / f"{ID}_joint_pd.json", asdict(TUNED))
    monkeypatch.setattr(tuned_controller, "_shipped", lambda: shipped_in(tmp_path / "searches"))


def run(folder: Path, *options: str) -> tuple[dict[str, Any], str, str]:
    """Results, standard output and standard error of a comparison in this process."""
    result = RUNNER.invoke(app, ["compare", "--jobs", "1", "--output", str(folder), *OPTIONS, *options])
    assert result.exit_code == 0, result.output
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return content, result.stdout, " ".join(result.stderr.split())


def test_comparison_runs_every_policy_and_writes_results_and_figures(tmp_path: Path) -> None:
    content, output, error = run(tmp_path / "out")
    assert error == ""
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert files == {"results.json", "profiles.png", "scores.png", "learning.png", "compute.png"}
    for path in (tmp_path / "out").glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")
    rows = [(row["scenario"], row["policy"], row["training_seed"]) for row in content["evaluations"]]
    policies = [(name, seed) for name in POLICIES for seed in ((0, 1) if name == "ppo_torque" else (-1,))]
    assert rows == [(scenario, *item) for scenario in ("randomized", "realistic") for item in policies]
    assert {tuple(row["seeds"]) for row in content["evaluations"]} == {(0, 1, 2)}
    assert "…" not in output
    assert max(map(len, output.splitlines())) <= WIDTH
    for title in (
        f"{ID}, scenario randomized",
        "agents by training seed",
        "best controller against best agent",
        "score over all tasks",
        "learning effort: until the score of the best controller is reached",
    ):
        assert title in output


def test_policies_are_run_as_the_evaluator_runs_them(unwritten_figures: None, tmp_path: Path) -> None:
    content, _, _ = run(tmp_path / "out", "--scenario", "randomized", "--seed", "4")
    env = gymnasium.make(ID, scenario="randomized", control_frequency=500.0)
    controller = make_baseline("joint_pd", env, "tuned")
    expected = {"joint_pd": evaluate(controller, env, 3, 4)}
    env.close()
    for name, evaluation in expected.items():
        (row,) = (row for row in content["evaluations"] if row["policy"] == name)
        assert row["episodes"] == to_plain(evaluation.metrics)
    periods = {row["policy"]: row["control_period"] for row in content["evaluations"]}
    assert periods == dict.fromkeys(POLICIES, 0.002) | {"ppo_torque": 0.02}
    (zero,) = (row for row in content["evaluations"] if row["policy"] == "zero_torque")
    assert np.abs(zero["episodes"]["torque_rms"]).max() == 0.0


def test_agent_acts_in_the_mode_and_at_the_rate_of_its_training(
    unwritten_figures: None, tmp_path: Path
) -> None:
    stem = save(tmp_path / "mine_seed_4", 4, action_mode="joint_position", control_frequency=100.0)
    content, _, _ = run(tmp_path / "out", "--scenario", "realistic", "--agent", f"{stem}.safetensors")
    (row,) = (row for row in content["evaluations"] if row["policy"] == "mine")
    policy = load_agent(stem)
    env = policy.make_env(scenario="realistic")
    expected = evaluate(policy, env, 3, 0)
    env.close()
    assert row["episodes"] == to_plain(expected.metrics)
    assert np.count_nonzero(expected.metrics["divergence"]) == 0
    assert (row["mode"], row["kind"], row["training_seed"]) == ("joint_position", "agent", 4)
    assert row["history"]["control_frequency"] == 100.0


def test_results_hold_all_that_the_findings_follow_from(unwritten_figures: None, tmp_path: Path) -> None:
    content, _, _ = run(tmp_path / "out")
    again = json.loads(json.dumps(Outcome.of(content["evaluations"], 0).to_plain(), allow_nan=False))
    assert {name: content[name] for name in again} == again
    assert set(again) == {"scores", "pairwise_comparisons", "aggregates", "efforts"}
    assert len(content["pairwise_comparisons"]) == 2
    pairwise = content["pairwise_comparisons"][0]
    assert (pairwise["agent"], pairwise["verdict"], pairwise["scenario"]) == (
        "ppo_torque",
        "controller",
        "randomized",
    )
    by_kind = {effort["kind"]: effort for effort in content["efforts"]}
    assert by_kind["agent"]["reached"] == 2
    assert by_kind["agent"]["reach"] == {"steps": 2000.0, "simulated_seconds": 40.0, "wall_minutes": 0.2}
    assert by_kind["agent"]["violations"] == 3.0
    assert by_kind["controller"]["reach"]["steps"] == "inf"


def test_deterministic_scenario_is_run_once_and_nothing_learned_leaves_no_curves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agent_file, "TRAINED", tmp_path / "none")
    (tmp_path / "searches" / f"{ID}_joint_pd.json").unlink()
    content, output, _ = run(tmp_path / "out", "--scenario", "report")
    assert [row["seeds"] for row in content["evaluations"]] == [[0]] * 4  # two controllers, two floors
    assert not (tmp_path / "out" / "learning.png").exists()
    assert content["pairwise_comparisons"] == content["efforts"] == []
    assert "best agent" not in output


def test_interrupted_comparison_goes_on_where_it_stopped(
    unwritten_figures: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    finished: list[str] = []

    def run_five(controllers: Controllers, job: Job) -> JobResult:
        if len(finished) == 5:
            raise KeyboardInterrupt
        finished.append(job.name)
        return run_job(controllers, job)

    options = ["compare", "--jobs", "1", "--output", str(tmp_path / "out"), *OPTIONS]
    with monkeypatch.context() as patch:
        patch.setattr(runs, "run_job", run_five)
        assert RUNNER.invoke(app, options).exit_code != 0
    left = {path.stem: path.read_bytes() for path in (tmp_path / "out" / "jobs").iterdir()}
    assert set(left) == set(finished)
    content, _, error = run(tmp_path / "out")
    assert error.startswith("5 of 12 jobs were finished by an interrupted run")
    records = [json.loads(text)["record"] for text in left.values()]
    assert all(record in content["evaluations"] for record in records)  # measured times included
    _, _, error = run(tmp_path / "out")
    assert error == ""


def test_agent_that_was_trained_anew_is_run_again(
    unwritten_figures: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("prp_gym.runs.store.JobStore.remove", lambda *_: None)
        run(tmp_path / "out", "--scenario", "randomized")
    save(tmp_path / "trained" / ID / "ppo_torque_seed_1", 1, network=2)
    _, _, error = run(tmp_path / "out", "--scenario", "randomized")
    assert error == "5 of 6 jobs were finished by an interrupted run and are reused."


def test_files_that_change_under_way_are_refused(tmp_path: Path) -> None:
    (agent,) = compared_agents.find_agents([ID], [save(tmp_path / "mine", seed=7)])[2:]
    job = comparison_jobs.AgentJob(agent, "randomized", 1, 0)
    record = job.run(Controllers())
    assert (record["training_seed"], record["revisions"]) == (7, {"task": TASKS[ID].revision, "agent": 1})
    save(tmp_path / "mine", seed=8)
    with pytest.raises(InvalidValueError, match="SHA-256"):
        job.run(Controllers())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--baseline", "impedance"), "a controller that runs on the chosen environments"),
        (("--env", "PRP-Nothing-v0"), "unknown environment"),
        (("--scenario", "reprot"), "unknown scenario"),
        (("--episodes", "0"), "episodes is 0"),
        (("--agent", "nowhere"), "agent is 'nowhere'"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_anything_is_written(
    tmp_path: Path, options: tuple[str, ...], message: str
) -> None:
    result = RUNNER.invoke(app, ["compare", "--output", str(tmp_path / "out"), *OPTIONS, *options])
    assert message in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_agent_of_an_environment_that_was_not_chosen_is_refused(tmp_path: Path) -> None:
    stem = save(tmp_path / "other", environment_id="PRP-Adaptive-v0")
    result = RUNNER.invoke(
        app, ["compare", "--output", str(tmp_path / "out"), *OPTIONS, "--agent", str(stem)]
    )
    assert isinstance(result.exception, InvalidValueError)
    assert "environment of agent" in str(result.exception)


def test_tuned_controller_in_the_file_of_another_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "searches" / f"{ID}_joint_pd.json"
    path.rename(path.with_name(f"{ID}_joint_inverse_dynamics.json"))
    result = RUNNER.invoke(app, ["compare", "--output", str(tmp_path / "out"), *OPTIONS])
    assert isinstance(result.exception, InvalidValueError)
    assert f"is '{ID}/joint_pd'; allowed: {ID}/joint_inverse_dynamics" in str(result.exception)


def test_damaged_file_of_a_tuned_controller_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    path = tmp_path / "searches" / f"{ID}_joint_pd.json"
    path.write_text(path.read_text(encoding="utf-8").replace("trials", "trails"), encoding="utf-8")
    result = RUNNER.invoke(app, ["compare", "--output", str(tmp_path / "out"), *OPTIONS])
    assert isinstance(result.exception, DataFileError)
    assert "joint_pd.json" in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_agents_of_two_groups_are_kept_apart_even_if_their_files_are_alike(tmp_path: Path) -> None:
    stems = [save(tmp_path / name / f"{name}_seed_5", seed=5) for name in ("one", "two (2)")]
    agents = compared_agents.find_agents([ID], stems)[2:]
    jobs = [comparison_jobs.AgentJob(agent, "randomized", 1, 0) for agent in agents]
    assert agents[0].sha256 == agents[1].sha256
    assert len({job.name for job in jobs}) == 2
    assert not any(set(job.name) & set(" ()/") for job in jobs)
