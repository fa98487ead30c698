"""The jobs of a comparison."""

from collections.abc import Sequence
from contextlib import closing

from prp_gym.comparison.agents import AgentFile
from prp_gym.comparison.jobs import (
    AgentJob,
    ComparedFloorJob,
    ComparisonJob,
    ControllerJob,
    find_search,
)
from prp_gym.evaluation.evaluate import episodes_to_run
from prp_gym.runs.evaluation_job import list_jobs, make_environment
from prp_gym.runs.floor_job import list_floors
from prp_gym.runs.selection import Selection
from prp_gym.tasks.setup import MUJOCO

FREQUENCY = 500.0
"""Control frequency of the controllers [Hz]."""


def list_comparison_jobs(
    selected: Selection, agents: Sequence[AgentFile], episodes: int, seed: int, engine: str = MUJOCO
) -> list[ComparisonJob]:
    """In each condition the controllers, the agents, and the floors.

    Args:
        selected: chosen conditions and controllers.
        agents: agents to compare, of all environments.
        episodes: number of episodes of each job; a deterministic scenario has one.
        seed: random seed of the first episode.
        engine: engine of all environments, also of the agents'.

    Raises:
        PRPError: see `list_jobs` and `find_search`.
    """
    jobs: list[ComparisonJob] = []
    for environment_id, scenario in selected.conditions:
        where, choices = [(environment_id, scenario)], selected.choices
        own = list_jobs(where, choices, selected.controllers, FREQUENCY, episodes, seed, engine)
        jobs += [
            ControllerJob(**vars(job), searched=find_search(environment_id, job.controller)) for job in own
        ]
        with closing(make_environment(environment_id, scenario, FREQUENCY, engine)) as env:
            count = episodes_to_run(env, episodes)
        jobs += [
            AgentJob(item, scenario, count, seed, engine)
            for item in agents
            if item.environment_id == environment_id
        ]
        floors = list_floors(where, FREQUENCY, episodes, seed, engine=engine)
        jobs += [ComparedFloorJob(**vars(job)) for job in floors]
    return jobs
