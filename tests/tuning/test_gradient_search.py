"""The search along derivatives: its objective's slopes, its steps on known functions, and how it goes on."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.errors import DataFileError, UnknownNameError
from prp_gym.gradients.differentiated_episodes import DifferentiatedEpisodes
from prp_gym.runs.key import key_of
from prp_gym.tuning import (
    Objective,
    ScenarioCandidates,
    StoredStudy,
    Trial,
    TuningTask,
    make_candidates,
    tune,
)
from prp_gym.tuning.gradient_objective import LARGEST_SLOPE, GradientObjective
from prp_gym.tuning.gradient_step import gradient_step
from prp_gym.tuning.gradient_study import GradientStudy
from prp_gym.tuning.journal import JOURNAL
from prp_gym.tuning.search_space import Parameter
from tests.support.compiler import needs_compiler

ENVIRONMENT, CONTROLLER = "PRP-JointTracking-v0", "joint_pd"
STEPS, EPISODES = 100, 4
TASK = TuningTask(ENVIRONMENT, CONTROLLER, ("randomized", "realistic"), 500.0, 8 * STEPS * EPISODES, EPISODES)
SAME = 1e-6  # of a score: actions are not rounded to 6e-8
STEP = 1e-5  # in the logarithm of a factor


@pytest.fixture(scope="module")
def conditions() -> list[ScenarioCandidates]:
    envs: list[Any] = [
        gymnasium.make(ENVIRONMENT, scenario=name, duration=STEPS / 500.0) for name in TASK.scenarios
    ]
    return [ScenarioCandidates(env, make_candidates(TASK, env)) for env in envs]


@needs_compiler
def test_scores_are_those_of_the_other_search_and_slopes_those_of_differences(
    conditions: list[ScenarioCandidates],
) -> None:
    exact, sampled = (kind(conditions, TASK.first_seed, EPISODES) for kind in (GradientObjective, Objective))
    start = conditions[0].candidates.space.start
    factors = {name: value * (1.0 + 0.05 * index) for index, (name, value) in enumerate(start.items())}
    (found,), (other,) = exact.measure([factors], None), sampled.measure([factors], None)
    assert found.score == pytest.approx(other.score, abs=SAME)
    assert found.by_scenario == pytest.approx(other.by_scenario, abs=SAME)
    assert (found.steps, found.stopped) == (other.steps, False)
    assert set(found.slopes) == set(factors)
    for name in factors:
        more, less = (
            exact.measure([{**factors, name: factors[name] * math.exp(shift)}], None)[0].score
            for shift in (STEP, -STEP)
        )
        # scores have an error of 1e-16, which is 1e-11 in the difference; third derivatives are below 10
        assert found.slopes[name] == pytest.approx((more - less) / (2.0 * STEP), rel=1e-5, abs=1e-9)


@needs_compiler
def test_refused_candidate_scores_nothing_and_has_no_slopes(conditions: list[ScenarioCandidates]) -> None:
    objective = GradientObjective(conditions, TASK.first_seed, EPISODES)
    names = conditions[0].candidates.space.start
    found = objective.measure([dict.fromkeys(names, 1e12)], None)[0]
    assert (found.score, found.steps, dict(found.slopes)) == (0.0, objective.most_steps, {})


def run(folder: Path, conditions: list[ScenarioCandidates], budget: int) -> list[Trial]:
    """The trials of a search with a budget, which goes on with those that are in the folder."""
    task = replace(TASK, budget=budget, method="gradient")
    study = GradientStudy(folder, conditions[0].candidates.space, {"made": "up"}, task.seed, resume=True)
    tune(task, GradientObjective(conditions, task.first_seed, EPISODES), study)
    return study.trials


@needs_compiler
def test_search_raises_the_score_and_goes_on_as_if_it_had_not_been_interrupted(
    conditions: list[ScenarioCandidates], tmp_path: Path
) -> None:
    whole = run(tmp_path / "whole", conditions, TASK.budget)
    run(tmp_path / "parts", conditions, TASK.budget // 2)
    parts = run(tmp_path / "parts", conditions, TASK.budget)
    assert len(whole) >= 8
    assert [(trial.factors, trial.score) for trial in parts] == [
        (trial.factors, trial.score) for trial in whole
    ]
    assert [dict(trial.slopes) for trial in parts] == [dict(trial.slopes) for trial in whole]
    assert max(trial.score for trial in whole) > whole[0].score


PARAMETERS = tuple(Parameter(name, 0.01, 100.0, {name: 1.0}, ...) for name in ("first", "second", "third"))
OPTIMUM = np.log([2.0, 0.3, 5.0])
CURVATURE = np.array([[3.0, 1.0, 0.2], [1.0, 2.0, 0.3], [0.2, 0.3, 0.1]])
Function = Callable[[np.ndarray], tuple[float, np.ndarray]]


def parabola(x: np.ndarray) -> tuple[float, np.ndarray]:
    away = x - OPTIMUM
    return float(-0.5 * away @ CURVATURE @ away), -CURVATURE @ away


def climb(function: Function, count: int, parameters: tuple[Parameter, ...] = PARAMETERS) -> list[Trial]:
    """The trials of a search for the maximum of a function of the logarithms of the factors."""
    factors: Mapping[str, float] = {item.name: 1.0 for item in parameters}
    trials: list[Trial] = []
    for _ in range(count):
        value, slopes = function(np.log(list(factors.values())))
        known = dict(zip(factors, slopes.tolist(), strict=True)) if math.isfinite(value) else {}
        trials.append(Trial(factors, value if known else 0.0, 1, 0.0, (value,), slopes=known))
        factors = gradient_step(parameters, trials, seed=0)
    return trials


def test_maximum_of_a_parabola_is_found_whatever_the_scale_of_the_score() -> None:
    for scale in (1e-3, 1.0):

        def scaled(x: np.ndarray, scale: float = scale) -> tuple[float, np.ndarray]:
            value, slopes = parabola(x)
            return 1.0 + scale * value, scale * slopes

        best = max(climb(scaled, 40), key=lambda trial: trial.score)
        # what is left to gain is 1e-6 of what the start had lost
        assert 1.0 - best.score < 1e-6 * scale * -parabola(np.zeros(3))[0]


def test_factors_stay_in_their_ranges_and_climb_along_them() -> None:
    narrow = (replace(PARAMETERS[0], high=1.5), *PARAMETERS[1:])
    trials = climb(parabola, 40, narrow)
    assert all(trial.factors["first"] <= 1.5 * (1.0 + 1e-12) for trial in trials)
    best = max(trials, key=lambda trial: trial.score)
    rest = np.linalg.solve(CURVATURE[1:, 1:], -CURVATURE[1:, 0] * (math.log(1.5) - OPTIMUM[0]))
    expected = np.exp(OPTIMUM[1:] + rest)
    assert [best.factors["second"], best.factors["third"]] == pytest.approx(expected.tolist(), rel=1e-2)


def test_step_that_lowers_the_score_is_halved_and_huge_slopes_lead_no_farther_than_others() -> None:
    def cliff(x: np.ndarray) -> tuple[float, np.ndarray]:
        """A score that falls where the first factor has grown by a tenth, with derivatives that lie."""
        return (-1.0 if x[0] > math.log(1.02) else float(x[0])), np.array([1e12, 0.0, 0.0])

    logarithms = [math.log(trial.factors["first"]) for trial in climb(cliff, 6)]
    assert logarithms[:5] == pytest.approx([0.0, 0.1, 0.05, 0.025, 0.0125])
    assert logarithms[5] > logarithms[4]  # which was better


@needs_compiler
def test_episode_whose_derivatives_are_huge_tells_nothing(
    conditions: list[ScenarioCandidates], monkeypatch: pytest.MonkeyPatch
) -> None:
    start = conditions[0].candidates.space.start
    objective = GradientObjective(conditions, TASK.first_seed, EPISODES)
    before = objective.measure([start], None)[0].slopes
    exact = DifferentiatedEpisodes.differences

    def with_chaos(self: DifferentiatedEpisodes, more: Any, less: Any) -> Any:
        found = exact(self, more, less)
        assert found is not None
        return np.concatenate([[1e9], found[1:]])

    monkeypatch.setattr(DifferentiatedEpisodes, "differences", with_chaos)
    without = objective.measure([start], None)[0].slopes
    assert max(map(abs, without.values())) <= LARGEST_SLOPE
    assert without != before


def test_search_without_a_slope_tries_random_steps_and_candidates_may_be_refused() -> None:
    flat = climb(lambda x: (0.5, np.zeros(3)), 6)
    assert len({trial.factors["second"] for trial in flat}) == 6
    again = climb(lambda x: (0.5, np.zeros(3)), 6)
    assert [trial.factors for trial in again] == [trial.factors for trial in flat]

    def refused(x: np.ndarray) -> tuple[float, np.ndarray]:
        value, slopes = parabola(x)
        return (math.nan if x[0] > 0.5 else value), slopes

    best = max((trial for trial in climb(refused, 60) if trial.slopes), key=lambda trial: trial.score)
    assert best.score > parabola(np.zeros(3))[0] / 2.0


def test_journal_keeps_slopes_and_refuses_others(
    conditions: list[ScenarioCandidates], tmp_path: Path
) -> None:
    space = conditions[0].candidates.space
    slopes = dict.fromkeys(space.start, 0.25)
    study = GradientStudy(tmp_path, space, {}, 0, True)
    study.record(Trial(space.start, 0.5, 10, 0.1, (0.5,), slopes=slopes))
    assert GradientStudy(tmp_path, space, {}, 0, True).trials[0].slopes == slopes
    path = tmp_path / JOURNAL
    lines = path.read_text().splitlines()
    (number,) = [index for index, line in enumerate(lines) if json.loads(line)["op_code"] == 4]  # a trial
    for damage in ({"other": 0.25}, {**slopes, next(iter(slopes)): "0.25"}, [0.25]):
        line = json.loads(lines[number])
        line["user_attrs"]["slopes"] = damage
        path.write_text("\n".join([*lines[:number], json.dumps(line), *lines[number + 1 :]]) + "\n")
        with pytest.raises(DataFileError, match="slopes"):
            GradientStudy(tmp_path, space, {}, 0, True)


def test_method_is_named_in_the_key_of_a_search_unless_it_is_the_first(tmp_path: Path) -> None:
    assert "method" not in key_of(TASK)
    assert key_of(replace(TASK, method="gradient"))["method"] == "gradient"
    with pytest.raises(UnknownNameError, match="gradient"):
        replace(TASK, method="gradients")
    assert StoredStudy.candidates_of_a_round > GradientStudy.candidates_of_a_round == 1
