"""Jobs of an audit: good and bad policies, many more than those that are compared."""

import zlib
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np

from prp_gym.artifacts import to_plain
from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.degenerate import DEGENERATE
from prp_gym.baselines.floors import FLOORS
from prp_gym.comparison.agents import AgentFile
from prp_gym.comparison.jobs import AgentJob, ControllerJob, VariedJob, list_varied, policy_facts
from prp_gym.comparison.listing import FREQUENCY
from prp_gym.comparison.values import VARIED
from prp_gym.errors import PRPError
from prp_gym.evaluation.evaluate import evaluate
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import list_jobs, make_environment
from prp_gym.runs.floor_job import FloorJob, list_floors
from prp_gym.runs.job import Record, make_record
from prp_gym.runs.selection import Selection
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning import SearchSpace, start_gains

UNAWARE = {spec.name: spec for group in (FLOORS, DEGENERATE) for spec in group.values()}
"""Policies that do not attempt the task, by name."""

_NEAR, _FAR = 2.0, 5.0  # a random factor on gains lies between the inverse of one of them and itself
_FAR_EVERY = 3
_TRIES = 20


@dataclass(frozen=True)
class UnawareJob(FloorJob):
    """A policy that does not attempt the task, a floor or an exploit of the reward."""

    specs: ClassVar[Mapping[str, ControllerSpec]] = UNAWARE

    @property
    def name(self) -> str:
        """See `Job.name`; it differs from that of an evaluation, whose records hold less."""
        return f"{super().name}_audited"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        return {**super().run(controllers), **policy_facts(self.floor, VARIED)}


@dataclass(frozen=True)
class RandomGainsJob:
    """A controller whose gains are drawn at random around its tuned ones.

    Attributes:
        controller: name of the controller.
        draw: number of the draw.
        environment_id: id of the environment.
        scenario: name of the scenario.
        episodes: number of episodes.
        seed: random seed of the first episode.
        engine: engine of the environment.
    """

    controller: str
    draw: int
    environment_id: str
    scenario: str
    episodes: int
    seed: int
    engine: str = MUJOCO

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{self.environment_id}_{self.scenario}_{self.controller}_random_{self.draw}"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        with closing(make_environment(self.environment_id, self.scenario, FREQUENCY, self.engine)) as env:
            policy = self._draw(CONTROLLERS.find(self.controller), env)
            evaluation = evaluate(policy, env, self.episodes, self.seed)
        name = f"{self.controller} (random {self.draw})"
        record: Record = to_plain({**make_record(evaluation, name, {}, {}), **policy_facts(name, VARIED)})
        return record

    def _draw(self, spec: ControllerSpec, env: gymnasium.Env[Any, Any]) -> Policy:
        """The policy; gains that the controller refuses are drawn anew."""
        label = zlib.crc32(f"{self.environment_id} {self.controller}".encode())
        rng = np.random.default_rng([self.seed, label, self.draw])
        gains = start_gains(spec, self.environment_id, FREQUENCY)
        space = SearchSpace.of(spec, make_baseline(spec, env, gains).settings)
        most = np.log(_FAR if self.draw % _FAR_EVERY == _FAR_EVERY - 1 else _NEAR)
        for _ in range(_TRIES):
            factors = {item.name: float(np.exp(rng.uniform(-most, most))) for item in space.parameters}
            try:
                policy: Policy = make_baseline(spec, env, **space.settings(factors))
            except PRPError:
                continue
            return policy
        return make_baseline(spec, env, gains)


AuditJob = ControllerJob | VariedJob | UnawareJob | RandomGainsJob | AgentJob


def list_audit_jobs(
    selected: Selection,
    agents: Sequence[AgentFile],
    episodes: int,
    seed: int,
    draws: int,
    engine: str = MUJOCO,
) -> list[AuditJob]:
    """In each condition the controllers with all their gain sets, random gains, floors, exploits and agents.

    Args:
        selected: chosen conditions and controllers.
        agents: agents to audit, of all environments.
        episodes: number of episodes of each job.
        seed: random seed of the first episode, and of the random gains.
        draws: number of random gains in all for the controllers that are intended for an environment.
        engine: engine of all environments, also of the agents'.

    Raises:
        PRPError: see `list_jobs`.
    """
    jobs: list[AuditJob] = []
    for environment_id, scenario in selected.conditions:
        where, choices = [(environment_id, scenario)], selected.choices
        own = list_jobs(where, choices, selected.controllers, FREQUENCY, episodes, seed, engine)
        jobs += [ControllerJob(**vars(job)) for job in own]
        jobs += [item for job in own for item in list_varied(job, selected.controllers)]
        unaware = list_floors(where, FREQUENCY, episodes, seed, UNAWARE, engine)
        jobs += [UnawareJob(**vars(job)) for job in unaware]
        names = [job.controller.name for job in own if job.controller.name in CONTROLLERS]
        intended = [name for name in names if environment_id in CONTROLLERS.find(name).data.intended]
        jobs += [
            RandomGainsJob(name, draw, environment_id, scenario, episodes, seed, engine)
            for name in intended
            for draw in range(-(-draws // len(intended)))
        ]
        jobs += [
            AgentJob(agent, scenario, episodes, seed, engine)
            for agent in agents
            if agent.environment_id == environment_id
        ]
    return jobs
