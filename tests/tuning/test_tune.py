"""The search: its budget, its episodes, its proposals, and how it goes on after a kill."""

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import make_baseline
from prp_gym.errors import InvalidValueError, MissingPackageError, OutputError
from prp_gym.evaluation import evaluate
from prp_gym.tuning import (
    Objective,
    Ranges,
    ScenarioCandidates,
    StoredStudy,
    Trial,
    Tuned,
    TuningTask,
    make_candidates,
    ranges_after,
    tune,
)
from prp_gym.tuning.journal import JOURNAL
from prp_gym.tuning.local_step import is_local, is_of_few, local_step, step_length
from prp_gym.tuning.widening import NO_LIMIT
from tests.support.full_disk import room_for

ENVIRONMENT = "PRP-Compliance-v0"
STEPS, EPISODES = 20, 3
COST = STEPS * EPISODES
TASK = TuningTask(ENVIRONMENT, "admittance", ("realistic",), 500.0, 12 * COST + 7, EPISODES)
ENV: Any = gymnasium.make(ENVIRONMENT, scenario="realistic", duration=STEPS / 500.0)
CANDIDATES = make_candidates(TASK, ENV)
SPACE: Any = CANDIDATES.space
KEY = {"made": "up"}


def objective(task: TuningTask = TASK) -> Objective:
    return Objective([ScenarioCandidates(ENV, CANDIDATES)], task.first_seed, task.episodes)


def search(folder: Path, task: TuningTask = TASK, resume: bool = False) -> Tuned:
    return tune(task, objective(task), StoredStudy(folder, SPACE, KEY, task.seed, resume))


def outline(tuned: Tuned) -> list[tuple[Any, ...]]:
    """All of the trials but the time that they took."""
    return [(dict(trial.factors), trial.score, trial.steps) for trial in tuned.trials]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Tuned:
    """A search in one go."""
    return search(tmp_path_factory.mktemp("whole"))


def test_budget_is_spent_to_less_than_a_trial_and_never_exceeded(whole: Tuned) -> None:
    assert len(whole.trials) == 12
    assert [trial.steps for trial in whole.trials] == [COST] * 12  # none of these episodes diverges
    assert whole.used_steps == 12 * COST == TASK.budget - 7


def test_steps_are_counted_as_they_are_simulated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from prp_gym.envs.core.loop import EpisodeLoop

    simulated, step = [], EpisodeLoop.step

    def counted(loop: EpisodeLoop, action: Any, idle: Any = None) -> Any:
        simulated.append(len(action) if idle is None else int(np.count_nonzero(~idle)))
        return step(loop, action, idle)

    monkeypatch.setattr(EpisodeLoop, "step", counted)
    assert search(tmp_path).used_steps == sum(simulated)


def test_first_trial_is_the_tuned_set_with_the_evaluator_s_score(whole: Tuned) -> None:
    first = whole.trials[0]
    assert first.factors == SPACE.start
    evaluation = evaluate(make_baseline("admittance", ENV), ENV, EPISODES, TASK.first_seed)
    # sums in another order
    assert first.score == pytest.approx(evaluation.metrics["score"].mean(), rel=1e-12)
    assert TASK.first_seed == 1_000_000


def test_result_is_never_below_the_tuned_set_and_is_the_best_trial(whole: Tuned) -> None:
    scores = [trial.score for trial in whole.trials]
    assert whole.best.score == max(scores) >= scores[0]
    policy = make_baseline("admittance", ENV, "report", **SPACE.settings(whole.best.factors))
    evaluation = evaluate(policy, ENV, EPISODES, TASK.first_seed)
    assert evaluation.metrics["score"].mean() == pytest.approx(max(scores), rel=1e-12)
    assert len(set(scores)) > len(scores) / 2  # or nothing was searched


def test_same_seed_same_search_and_another_seed_another(whole: Tuned, tmp_path: Path) -> None:
    assert outline(search(tmp_path / "again")) == outline(whole)
    other = search(tmp_path / "other", replace(TASK, seed=1))
    assert other.trials[0].factors == whole.trials[0].factors
    assert other.trials[0].score != whole.trials[0].score  # other episodes
    assert other.trials[1].factors != whole.trials[1].factors


def test_history_tells_the_best_so_far() -> None:
    trials = [Trial({}, score, 10, 0.0) for score in (0.3, 0.2, 0.5, 0.5, 0.4)]
    ranges = Ranges((), {})
    tuned = Tuned(trials, ranges)
    assert [(steps, trial.score) for steps, trial in tuned.history] == [(10, 0.3), (30, 0.5), (50, 0.5)]
    assert tuned.best is trials[2]
    assert [steps for steps, _ in Tuned(trials[:3], ranges).history] == [10, 30]
    hopeless = Trial({}, 0.9, 10, 0.0, (0.9,), stopped=True)  # an estimate is never the best
    assert Tuned([*trials, hopeless], ranges).best is trials[2]


def test_budget_for_less_than_a_trial_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match=f"budget is {COST - 1} steps; allowed: at least {COST}"):
        search(tmp_path, replace(TASK, budget=COST - 1))
    assert len(search(tmp_path / "one", replace(TASK, budget=COST)).trials) == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("budget", 0),
        ("budget", 1.5),
        ("episodes", 0),
        ("episodes", True),
        ("seed", -1),
        ("seed", 499),
        ("scenarios", ()),
        ("scenarios", ("report", "report")),
    ],
)
def test_numbers_that_make_no_search_are_refused(name: str, value: Any) -> None:
    with pytest.raises(InvalidValueError, match=f"^{name} is "):
        replace(TASK, **{name: value})


def test_training_episodes_of_the_last_seed_are_not_those_of_validation() -> None:
    last = replace(TASK, seed=498, episodes=999_999)
    assert last.first_seed + last.episodes <= 500_000_000


class OneSetting:
    """A study that proposes the same over and over."""

    def __init__(self, factors: dict[str, float], edges: dict[str, str]) -> None:
        self.trials: list[Trial] = []
        self.factors, self.edges = factors, edges

    @property
    def known(self) -> list[Trial]:
        return self.trials

    def ranges(self, trials: Any) -> Ranges:
        return Ranges(SPACE.parameters, self.edges)

    def propose(self) -> list[dict[str, float]]:
        return [self.factors]

    def record(self, trial: Trial) -> None:
        self.trials.append(trial)


def test_candidate_that_the_controller_refuses_scores_nothing_and_is_charged_in_full() -> None:
    refused = {**SPACE.start, "frame_inertia_translation": 0.0}  # no mass
    tuned = tune(TASK, objective(), OneSetting(refused, {}))
    assert [(trial.score, trial.steps) for trial in tuned.trials] == [(0.0, COST)] * 12


def test_search_goes_on_for_a_quarter_of_the_budget_at_an_edge_that_is_no_limit() -> None:
    task = replace(TASK, budget=8 * COST)
    for edges, trials in (({"a, high": NO_LIMIT}, 10), ({"a, high": "a declared limit"}, 8), ({}, 8)):
        assert len(tune(task, objective(), OneSetting(SPACE.start, edges)).trials) == trials


def distance(factors: Any) -> float:
    """A made-up score with its maximum, 1, at a factor of 2 for every parameter."""
    return math.exp(-sum(math.log(value / 2.0) ** 2 for value in factors.values()))


def synthetic(folder: Path, trials: int, resume: bool = False) -> StoredStudy:
    study = StoredStudy(folder, SPACE, KEY, 0, resume)
    while len(study.trials) < trials:
        factors = study.propose()[0]
        keep(study, distance(factors), factors)
    return study


def keep(study: StoredStudy, score: float, factors: dict[str, float]) -> None:
    study.record(Trial(factors, score, 1, 0.0, (score,)))


def test_search_climbs_and_stays_within_the_ranges(tmp_path: Path) -> None:
    study = synthetic(tmp_path, 60)
    scores = [trial.score for trial in study.trials]
    # at the start exp(-7 ln²2) = 0.035; 60 random draws reach 0.04 in the median, 0.22 in one case of 20
    assert max(scores) > 0.4
    parameters = ranges_after(SPACE.parameters, study.trials).parameters
    for trial in study.trials:
        assert all(item.low <= trial.factors[item.name] <= item.high for item in parameters)


def test_every_step_has_a_direction_of_its_own(tmp_path: Path) -> None:
    study = StoredStudy(tmp_path, SPACE, KEY, 0, False)
    steps = []
    for score in (1.0, 0.5, 0.5):  # the start stays the best
        factors = study.propose()[0]
        steps.append(np.log(list(factors.values())))
        keep(study, score, factors)
    directions = [step / np.linalg.norm(step) for step in steps[1:]]
    assert abs(directions[0] @ directions[1]) < 0.95


def test_sampler_looks_at_small_factors_as_often_as_at_large_ones(tmp_path: Path) -> None:
    factors = []
    for seed in range(20):
        study = StoredStudy(tmp_path / str(seed), SPACE, KEY, seed, False)
        for _ in range(7):
            last = study.propose()[0]
            keep(study, 0.5, last)
        factors += list(last.values())  # of the first candidate that is not a step
    # 140 draws, log-uniform on 0.1 to 10 or 0.2 to 5: their median's deviation is 0.1 in log; linear: 5
    assert 0.5 < np.median(factors) < 2.0
    assert min(factors) < 0.2
    assert max(factors) > 5.0


def test_search_that_is_resumed_is_the_one_that_was_not_interrupted(tmp_path: Path) -> None:
    expected = synthetic(tmp_path / "whole", 16).trials
    folder = tmp_path / "parts"
    for count in (0, 1, 5, 11):
        study = synthetic(folder, count, resume=True)
        study.propose()  # under way when the process ends
    (folder / f"{JOURNAL}.lock").symlink_to(folder / JOURNAL)
    with (folder / JOURNAL).open("ab") as file:
        file.write(b'{"op_code": 5, "tri')
    assert synthetic(folder, 16, resume=True).trials == expected


def test_search_is_neither_overwritten_nor_mixed_with_another(tmp_path: Path) -> None:
    synthetic(tmp_path, 2)
    with pytest.raises(InvalidValueError, match="--resume to go on"):
        synthetic(tmp_path, 2)
    with pytest.raises(InvalidValueError, match=r"'made': 'up'.*to resume one of \{'made': 'otherwise'\}"):
        StoredStudy(tmp_path, SPACE, {"made": "otherwise"}, 0, True)
    assert len(synthetic(tmp_path, 2, resume=True).trials) == 2


def test_proposals_of_a_round_do_not_depend_on_each_other_s_scores(tmp_path: Path) -> None:
    studies = [synthetic(tmp_path / str(score), 1) for score in (0.01, 0.9)]
    proposals = [study.propose() for study in studies]
    assert proposals[0] == proposals[1]
    assert len(proposals[0]) == 4
    for study, score in zip(studies, (0.01, 0.9), strict=True):
        keep(study, score, proposals[0][0])
        assert study.propose() == proposals[0][1:]
        for factors in study.propose():
            keep(study, 0.0, factors)
    assert studies[0].propose() != studies[1].propose()


def test_step_grows_with_success_and_shrinks_without() -> None:
    def length(scores: list[float]) -> float:
        return step_length([Trial({}, score, 1, 0.0) for score in scores])

    assert [is_local(index) for index in range(8)] == [False, True, True, True, True, True, False, True]
    assert length([0.5]) == 0.3
    assert length([0.5, 0.6]) == pytest.approx(0.45)
    # a success, two failures; the third and the sixth change few factors, and the last is not a step
    assert length([0.5, 0.6, 0.7, 0.7, 0.7, 0.8, 0.9]) == pytest.approx(0.3 * 1.5**0.5)
    assert [is_of_few(index) for index in range(7)] == [False, False, True, False, False, True, False]
    assert length([0.5, 0.4, 0.4, 0.4, 0.4, 0.6, 0.4, 0.4]) == pytest.approx(0.3 / 1.5)  # four failures
    assert length([0.5] * 300) == 0.02
    assert length([float(index) for index in range(300)]) == 1.0


def test_step_starts_from_the_best_candidate() -> None:
    parameters = tuple(replace(item, low=0.5, high=2.0) for item in SPACE.parameters)
    start = SPACE.start
    near = dict.fromkeys(start, 1.9)
    trials = [Trial(start, 0.2, 1, 0.0), Trial(near, 0.3, 1, 0.0), Trial(start, 0.1, 1, 0.0)]
    steps = [local_step(parameters, trials, np.random.default_rng(seed)) for seed in range(200)]
    logs = np.log([list(step.values()) for step in steps]) - np.log(1.9)
    inside = logs[logs < np.log(2.0 / 1.9) - 1e-9]
    assert logs.max() == pytest.approx(np.log(2.0 / 1.9))  # the ranges' end
    # 1400 draws, cut at 0.051, of which 57 to 60 % lie below it: below 0 their median is -0.674 lengths
    assert np.median(logs[logs < 0]) == pytest.approx(-0.674 * step_length(trials), rel=0.15)
    assert len(inside) > logs.size / 2


def test_step_of_few_factors_leaves_the_others_as_they_are() -> None:
    parameters = tuple(replace(item, low=0.01, high=100.0) for item in SPACE.parameters)
    best = dict.fromkeys(SPACE.start, 1.2)
    trials = [Trial(SPACE.start, 0.2, 1, 0.0), Trial(best, 0.3, 1, 0.0)]
    generators = [np.random.default_rng(seed) for seed in range(300)]
    logs = np.log([list(local_step(parameters, trials, rng, few=True).values()) for rng in generators])
    moved = np.abs(logs - np.log(1.2)) > 1e-12
    assert (moved.sum(axis=1) == -(-len(parameters) // 3)).all()
    # each factor as often as any other: 3 of 7 in 300 steps, four standard deviations of 8.6
    np.testing.assert_allclose(moved.sum(axis=0), 300 * 3 / 7, atol=35)
    # a standard deviation of 1, of about 900 draws: its error is 1/sqrt(1800)
    assert np.std((logs - np.log(1.2))[moved]) == pytest.approx(1.0, abs=0.1)


CHILD = """
import sys, time
from pathlib import Path
from tests.tuning.test_tune import KEY, SPACE, TASK, StoredStudy, objective, tune
study = StoredStudy(Path(sys.argv[1]), SPACE, KEY, TASK.seed, False)
def slowly(trial):
    time.sleep(0.05)
tune(TASK, objective(), study, slowly)
"""


def test_search_that_was_killed_goes_on_to_the_same_end(tmp_path: Path, whole: Tuned) -> None:
    root = Path(__file__).resolve().parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    process = subprocess.Popen([sys.executable, "-c", CHILD, str(tmp_path)], cwd=root, env=environment)
    for _ in range(20_000):
        journal = tmp_path / JOURNAL
        if journal.exists() and journal.read_bytes().count(b'"seconds"') >= 3:
            break
        time.sleep(0.001)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    study = StoredStudy(tmp_path, SPACE, KEY, TASK.seed, True)
    assert 2 <= len(study.trials) < 12
    tuned = tune(TASK, objective(), study)
    assert outline(tuned) == outline(whole)
    assert tuned.used_steps == whole.used_steps


def test_full_disk_ends_a_search_and_it_goes_on_later(tmp_path: Path) -> None:
    expected = synthetic(tmp_path / "whole", 6).trials
    folder = tmp_path / "run"
    study = synthetic(folder, 3)
    factors = study.propose()[0]
    with room_for((folder / JOURNAL).stat().st_size + 50), pytest.raises(OutputError) as caught:
        keep(study, 0.5, factors)
    assert caught.value.path == str(folder / JOURNAL)
    assert synthetic(folder, 6, resume=True).trials == expected
    assert [path.name for path in folder.iterdir()] == [JOURNAL]


def test_folder_that_is_removed_ends_a_search(tmp_path: Path) -> None:
    study = synthetic(tmp_path / "run", 1)
    factors = study.propose()[0]
    shutil.rmtree(tmp_path / "run")
    with pytest.raises(OutputError, match="removed or renamed"):
        keep(study, 0.5, factors)
    assert not (tmp_path / "run").exists()


def test_journal_is_optuna_s_own(tmp_path: Path) -> None:
    synthetic(tmp_path, 2)
    lines = (tmp_path / JOURNAL).read_text(encoding="utf-8").splitlines()
    assert all("op_code" in json.loads(line) for line in lines)


def test_missing_optuna_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(MissingPackageError, match=r"^optuna is not installed; .*'prp-gym\[tune\]'"):
        StoredStudy(tmp_path, SPACE, KEY, 0, False)
