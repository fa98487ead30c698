"""What a search maximises: the mean over scenarios, left early where a candidate is hopeless."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import pytest

from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.evaluation import evaluate
from prp_gym.tuning import Candidates, Objective, ScenarioCandidates, SearchSpace, Trial
from prp_gym.tuning.objective import HOPELESS, mean_score

ENVIRONMENT, CONTROLLER = "PRP-JointTracking-v0", "joint_pd"
STEPS = 30
SCENARIOS = ("realistic", "randomized")
FIRST, EPISODES = 1_000_000, 5


def condition(scenario: str) -> ScenarioCandidates:
    env = gymnasium.make(ENVIRONMENT, scenario=scenario, duration=STEPS / 500.0)
    start: Any = make_baseline(CONTROLLER, env)
    space = SearchSpace.of(CONTROLLERS[CONTROLLER], start.settings)

    def make(values: Mapping[str, Any]) -> Any:
        return make_baseline(CONTROLLER, env, **values)

    return ScenarioCandidates(env, Candidates(space, make))


CONDITIONS = [condition(name) for name in SCENARIOS]
START: dict[str, float] = CONDITIONS[0].candidates.space.start
WEAK = dict.fromkeys(START, 0.2)


@pytest.fixture(scope="module")
def objective() -> Objective:
    return Objective(CONDITIONS, FIRST, EPISODES)


def test_score_is_the_mean_over_scenarios_of_the_evaluator_s_means(objective: Objective) -> None:
    found = objective.measure([START], None)[0]
    means = [
        evaluate(make_baseline(CONTROLLER, env), env, 3, FIRST + 3 * number).metrics["score"].mean()
        for number, (env, _) in enumerate(CONDITIONS)
    ]
    # five episodes are three in each of two scenarios; sums in another order
    assert found.by_scenario == pytest.approx(means, rel=1e-12)
    assert found.score == pytest.approx(sum(means) / 2, rel=1e-12)
    assert (found.steps, found.stopped, objective.episodes) == (6 * STEPS, False, 6)
    assert objective.most_steps == 6 * STEPS


def test_deterministic_scenario_has_one_episode() -> None:
    assert Objective([condition("report")], FIRST, 20).episodes == 1


def test_hopeless_candidate_is_run_in_the_first_scenario_alone(objective: Objective) -> None:
    weak = objective.measure([WEAK], None)[0]
    best = objective.measure([START], None)[0]
    assert 1.0 - weak.by_scenario[0] > HOPELESS * (1.0 - best.by_scenario[0])  # or there is nothing to see
    trial = Trial(START, best.score, best.steps, 0.0, best.by_scenario)
    found = objective.measure([WEAK], trial)[0]
    assert found.stopped
    assert found.by_scenario == weak.by_scenario[:1]
    assert found.steps == 3 * STEPS
    assert found.score == pytest.approx(best.score - (best.by_scenario[0] - weak.by_scenario[0]))
    assert found.score < best.score


def test_candidate_that_is_nearly_as_good_is_run_in_all_scenarios(objective: Objective) -> None:
    best = objective.measure([START], None)[0]
    trial = Trial(START, best.score, best.steps, 0.0, tuple(score + 1e-3 for score in best.by_scenario))
    assert not objective.measure([START], trial)[0].stopped


def test_refused_candidate_scores_nothing_and_uses_as_much_as_a_whole_one(objective: Objective) -> None:
    found = objective.measure([dict.fromkeys(START, 1e12)], None)[0]
    assert found == (0.0, objective.most_steps, (0.0, 0.0), False, {})


def test_scores_of_the_episodes_of_settings_are_those_of_their_candidate(objective: Objective) -> None:
    rows = objective.episode_scores([lambda candidates: candidates.space.settings(WEAK)] * 2)
    assert [len(own) for own in rows[0]] == [objective.episodes // 2] * 2
    assert [mean_score(item) for item in rows] == [objective.measure([WEAK], None)[0].score] * 2


def test_candidates_that_are_run_side_by_side_score_as_if_run_alone(objective: Objective) -> None:
    (start,) = objective.measure([START], None)
    trial = Trial(START, start.score, start.steps, 0.0, start.by_scenario)
    refused, other = dict.fromkeys(START, 1e12), dict.fromkeys(START, 0.9)
    proposals = [WEAK, START, refused, other]
    alone = [objective.measure([item], trial)[0] for item in proposals]
    assert objective.measure(proposals, trial) == alone
    assert {item.stopped for item in alone} == {False, True}
