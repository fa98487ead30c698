"""`prp-gym train --shipped` and `prp-gym ship`, on trainings that take a fraction of a second."""

import json
import shlex
import shutil
from contextlib import closing
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from typer.testing import CliRunner

from prp_gym.agents.policy import agent_file
from prp_gym.agents.policy.agent_file import list_agents, list_seeds, load_agent
from prp_gym.agents.training.recipes import load_recipe
from prp_gym.agents.training.train import TrainingJob, train
from prp_gym.cli.main import app
from prp_gym.evaluation import evaluate
from tests.cli.test_main import plain, refusal
from tests.support.training_runs import ID, assert_same_weights, interrupted

RUNNER = CliRunner()
RESIDUAL = "residual:joint_inverse_dynamics"
MANIFEST = f"""
- {{environment: {ID}, algorithm: ppo, action_mode: torque, seeds: 2}}
- {{environment: {ID}, algorithm: ppo, action_mode: "{RESIDUAL}", seeds: 1}}
"""
RECIPES = """
default:
  {n_timesteps: 512, n_envs: 4, policy: MlpPolicy, n_steps: 32, batch_size: 64, n_epochs: 2, gamma: 0.9,
   policy_kwargs: {net_arch: [8]}, env_kwargs: {control_frequency: 50, duration: 1, scenario: randomized}}
"""
SEEDS = ("ppo_torque/seed_0", "ppo_torque/seed_1", "ppo_residual-joint_inverse_dynamics/seed_0")
AGENTS = [f"{ID}/{name.replace('/', '_')}" for name in SEEDS]
EVERY = 512 // 20
EPISODES = 6


@pytest.fixture(scope="module")
def lists(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Options for a small list of agents and for their recipes."""
    folder = tmp_path_factory.mktemp("lists")
    (folder / "groups.yml").write_text(MANIFEST, encoding="utf-8")
    (folder / "recipes.yml").write_text(RECIPES, encoding="utf-8")
    return ["--manifest", str(folder / "groups.yml"), "--config", str(folder / "recipes.yml")]


def run_here(*options: str) -> str:
    """What a command says, in this process."""
    result = RUNNER.invoke(app, options)
    assert result.exit_code == 0, (result.output, result.exception)
    return plain(result.output)


def train_shipped(lists: list[str], runs: Path) -> str:
    return run_here("train", "--shipped", *lists, "--output", str(runs), "--jobs", "1")


def ship(lists: list[str], runs: Path, output: Path, *more: str) -> str:
    options = ("--runs", str(runs), "--output", str(output), "--episodes", str(EPISODES), "--jobs", "1")
    return run_here("ship", *lists, *options, *more)


def result_of(runs: Path, seed: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((runs / ID / seed / "result.json").read_text())
    return content


def times(folder: Path, pattern: str) -> dict[str, int]:
    """When each file was written."""
    return {str(path.relative_to(folder)): path.stat().st_mtime_ns for path in folder.glob(pattern)}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory, lists: list[str]) -> Path:
    """All seeds of the list, the second one after an interruption."""
    folder = tmp_path_factory.mktemp("runs")
    recipe = load_recipe("ppo", ID, "torque", Path(lists[3]))
    job = TrainingJob(recipe, 1, folder / ID / SEEDS[1], EVERY, tensorboard=False)
    with pytest.raises(KeyboardInterrupt):
        train(job, interrupted(3))
    train_shipped(lists, folder)
    return folder


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory, lists: list[str], runs: Path) -> Path:
    """The agents of the list."""
    folder = tmp_path_factory.mktemp("trained")
    ship(lists, runs, folder)
    return folder


def test_all_seeds_are_trained_and_an_interrupted_one_goes_on(runs: Path) -> None:
    found = {str(path.parent.relative_to(runs / ID)) for path in runs.glob("*/*/*/result.json")}
    assert found == set(SEEDS)
    assert [result_of(runs, seed)["resumes"] for seed in SEEDS] == [0, 1, 0]
    assert [result_of(runs, seed)["action_mode"] for seed in SEEDS] == ["torque", "torque", RESIDUAL]
    assert not list(runs.glob("*/*/*/tensorboard"))


def test_finished_seeds_are_left_and_their_results_told(lists: list[str], runs: Path) -> None:
    before = times(runs, "*/*/*/*")
    output = train_shipped(lists, runs)
    assert "3 of 3 seeds are finished." in output
    assert times(runs, "*/*/*/*") == before
    for seed in SEEDS:
        assert f"{result_of(runs, seed)['best']['score']:.3f}" in output


def test_one_that_is_missing_is_trained_and_counted(lists: list[str], runs: Path, tmp_path: Path) -> None:
    shutil.copytree(runs, tmp_path / "runs")
    shutil.rmtree(tmp_path / "runs" / ID / SEEDS[2])
    output = train_shipped(lists, tmp_path / "runs")
    assert "2 of 3 seeds are finished." in output
    assert f"3 of 3: {ID} ppo_residual-joint_inverse_dynamics seed 0, best score " in output
    assert_same_weights(tmp_path / "runs" / ID / SEEDS[2], runs / ID / SEEDS[2])


def test_command_on_the_card_trains_the_same_agent_again(runs: Path, tmp_path: Path) -> None:
    command = load_agent(runs / ID / SEEDS[2] / "agent").card.run.command
    assert str(runs) not in command
    run_here(*shlex.split(command)[1:], "--output", str(tmp_path), "--jobs", "1")
    assert_same_weights(tmp_path / ID / SEEDS[2], runs / ID / SEEDS[2])
    assert result_of(tmp_path, SEEDS[2])["best"] == result_of(runs, SEEDS[2])["best"]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ([], "environment id and --shipped is (None, False)"),
        ([ID, "--shipped"], "exactly one of the two"),
        ([ID, "--manifest", "groups.yml"], "only with --shipped"),
        (["--shipped", "--algo", "ppo"], "--algo is 'ppo'; allowed: not with --shipped"),
        (["--shipped", "--action-mode", "torque"], "--action-mode is 'torque'"),
        (["--shipped", "--seeds", "1"], "--seeds is 1"),
        (["--shipped", "--first-seed", "0"], "--first-seed is 0"),
        (["--shipped", "--manifest", "nothing.yml"], "nothing.yml"),
    ],
)
def test_options_that_do_not_go_together_are_refused_before_a_folder_is_made(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    options: list[str],
    told: str,
) -> None:
    assert told in refusal(capsys, monkeypatch, "train", *options, "--output", str(tmp_path / "runs"))
    assert not (tmp_path / "runs").exists()


def test_agents_are_found_by_the_names_of_their_groups(
    shipped: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agent_file, "TRAINED", shipped)
    torque, residual = f"{ID}/ppo_torque", f"{ID}/ppo_residual-joint_inverse_dynamics"
    assert list_agents() == [residual, torque]
    assert [*list_seeds(torque), *list_seeds(residual)] == AGENTS
    for name, seed in zip(AGENTS, SEEDS, strict=True):
        mine, trained = load_agent(name), load_agent(runs / ID / seed / "agent")
        assert (mine.card.sha256, mine.card.run) == (trained.card.sha256, trained.card.run)
        assert not trained.card.scores
    assert load_agent(torque).card.seed in (0, 1)


@pytest.mark.parametrize("name", AGENTS)
@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_score_on_the_card_is_the_mean_over_the_episodes(shipped: Path, name: str, scenario: str) -> None:
    policy = load_agent(shipped / name)
    score = policy.card.scores[scenario]
    keywords = {**policy.environment_keywords, "scenario": scenario}
    with closing(gymnasium.make(ID, **keywords)) as env:  # type: ignore[arg-type]
        scores = evaluate(policy, env, EPISODES, 0).metrics["score"][:, 0]
    assert score.value == pytest.approx(scores.mean(), abs=1e-12)  # the same numbers, added in another order
    assert scores.min() <= score.low < score.value < score.high <= scores.max()
    assert (score.episodes, score.seed) == (EPISODES, 0)


def test_only_changed_agents_are_written_also_with_parallel_workers(
    lists: list[str], runs: Path, shipped: Path, tmp_path: Path
) -> None:
    output = tmp_path / "trained"
    shutil.copytree(shipped, output)
    card = output / f"{AGENTS[1]}.json"
    expected = card.read_bytes()
    card.write_text("damaged")
    before = times(output, "*/*")
    said = ship(lists, runs, output, "--jobs", "2")
    assert card.read_bytes() == expected
    after = times(output, "*/*")
    assert {name for name in after if after[name] != before.get(name)} == {f"{AGENTS[1]}.json"}
    assert said.count("as before") == 2
    assert said.count("written") == 1


def test_missing_agent_is_refused_by_name_or_left_out(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    lists: list[str],
    runs: Path,
    tmp_path: Path,
) -> None:
    some, output = tmp_path / "runs", tmp_path / "trained"
    shutil.copytree(runs, some)
    (some / ID / SEEDS[0] / "result.json").unlink()
    options = ("--runs", str(some), "--output", str(output))
    error = refusal(capsys, monkeypatch, "ship", *lists, *options)
    assert "runs without a trained agent" in error
    assert [seed in error.replace(" ", "") for seed in SEEDS] == [True, False, False]
    assert not output.exists()
    said = ship(lists, some, output, "--allow-missing")
    assert f"left out:\n  {some / ID / SEEDS[0]}\n" in said
    assert sorted(path.stem for path in output.glob("*/*.json")) == sorted(
        Path(name).name for name in AGENTS[1:]
    )
    shutil.rmtree(some)
    assert "without a trained" in refusal(capsys, monkeypatch, "ship", *lists, *options, "--allow-missing")


def test_files_that_are_not_in_the_list_are_named_and_left(
    lists: list[str], runs: Path, shipped: Path, tmp_path: Path
) -> None:
    output = tmp_path / "trained"
    shutil.copytree(shipped, output)
    for name in (f"{ID}/ppo_torque_seed_2.json", "PRP-Force-v0/sac_torque_seed_0.safetensors"):
        (output / name).parent.mkdir(exist_ok=True)
        (output / name).write_text("old")
    said = ship(lists, runs, output)
    left = said.split("not in the list, left as they are:\n")[1]
    assert f"  {output}/{ID}/ppo_torque_seed_2.json\n" in left
    assert f"  {output}/PRP-Force-v0/sac_torque_seed_0.safetensors\n" in left
    assert left.count(str(output)) == 2
    assert (output / ID / "ppo_torque_seed_2.json").read_text() == "old"


def test_agent_of_another_recipe_or_seed_is_refused(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    lists: list[str],
    runs: Path,
    tmp_path: Path,
) -> None:
    output = ("--output", str(tmp_path / "trained"))
    other = tmp_path / "recipes.yml"
    other.write_text(RECIPES.replace("gamma: 0.9", "gamma: 0.95"), encoding="utf-8")
    changed = ("--manifest", lists[1], "--config", str(other), "--runs", str(runs))
    error = refusal(capsys, monkeypatch, "ship", *changed, *output)
    assert "gamma of the agent in" in error
    assert "is 0.9; allowed: 0.95, as the recipe says" in error
    shutil.copytree(runs / ID / "ppo_torque", tmp_path / "runs" / ID / "ppo_torque")
    own = tmp_path / "runs" / ID / "ppo_torque"
    shutil.copy(own / "seed_0" / "agent.json", own / "seed_1")
    shutil.copy(own / "seed_0" / "agent.safetensors", own / "seed_1")
    swapped = (*lists, "--runs", str(tmp_path / "runs"), "--allow-missing")
    assert "seed of the agent in" in refusal(capsys, monkeypatch, "ship", *swapped, *output)
    assert not (tmp_path / "trained").exists()
