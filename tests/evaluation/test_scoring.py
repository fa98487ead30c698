"""What the tasks declare about their tables and audits refers to metrics that they have."""

import gymnasium
import pytest

from prp_gym import list_envs
from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.evaluation import METRICS, episode_metrics, record_episode
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.tasks.spec import TASKS


@pytest.mark.parametrize("environment_id", list_envs())
def test_columns_and_criteria_of_a_task_are_metrics_that_its_episodes_have(environment_id: str) -> None:
    env = gymnasium.make(environment_id, duration=0.1)
    controller = list_baselines(env.get_wrapper_attr("observation_layout"))[0]
    found = episode_metrics(record_episode(make_baseline(controller, env), env, 0))
    env.close()
    scoring = scoring_of(environment_id)
    least = 6 if TASKS[environment_id].released else 1
    assert len(set(scoring.columns)) == len(scoring.columns) >= least
    for name in scoring.columns:
        assert METRICS[name].column is not None
        assert name in found
    assert scoring.criteria or not TASKS[environment_id].released
    for criterion in scoring.criteria:
        assert len(found[criterion.metric]) == 1
        assert criterion.worst > 0.0


def test_task_that_is_not_declared_has_neither_columns_nor_criteria() -> None:
    scoring = scoring_of("PRP-Unknown-v0")
    assert (scoring.columns, scoring.criteria) == ((), ())
