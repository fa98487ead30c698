"""Jobs of a comparison: controllers, the same with other gains, agents, floors."""

import re
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.artifacts import to_plain
from prp_gym.comparison.agents import AgentFile, agent_revision, digest, learning_history
from prp_gym.comparison.values import AGENT, CONTROLLER, FLOOR, VARIED
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import evaluate
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.choice import ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers, gain_sets_of
from prp_gym.runs.evaluation_job import EvaluationJob, make_environment
from prp_gym.runs.floor_job import FloorJob
from prp_gym.runs.job import Record, make_record
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning import TunedController, list_tuned_controllers, load_tuned_controller

TORQUE = EnvConfig.action_mode
UNTRAINED = -1
"""Training seed of a policy that is not trained."""


def policy_facts(policy: str, kind: str, mode: str = TORQUE) -> dict[str, Any]:
    """What a record of a comparison states about its policy, in addition to the evaluation."""
    return {"policy": policy, "kind": kind, "mode": mode, "training_seed": UNTRAINED, "history": {}}


def _evaluate(
    policy: Policy,
    env: gymnasium.Env[Any, Any],
    job: Any,
    facts: Mapping[str, Any],
    revisions: Mapping[str, int],
) -> Record:
    evaluation = evaluate(policy, env, job.episodes, job.seed)
    described = make_record(evaluation, str(facts["policy"]), facts.get("settings", {}), revisions)
    record: Record = to_plain({**described, **facts})
    return record


@dataclass(frozen=True)
class ControllerJob(EvaluationJob):
    """A controller with the gains with which it is compared.

    Attributes:
        searched: search that found the gains; None for gains of another origin.
    """

    searched: TunedController | None = None

    @property
    def name(self) -> str:
        """See `Job.name`; it differs from that of an evaluation, whose records hold less."""
        return f"{super().name}_{CONTROLLER}"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        facts = policy_facts(self.controller.name, CONTROLLER)
        if self.searched is not None:
            facts["history"] = to_plain(_search_history(self.searched, self.scenario))
        return {**super().run(controllers), **facts}


@dataclass(frozen=True)
class VariedJob(EvaluationJob):
    """A controller with a gain set other than the compared one, for the audit of the reward."""

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{super().name}_{self.controller.gains.name}_{VARIED}"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        policy = f"{self.controller.name} ({self.controller.gains.name})"
        return {**super().run(controllers), **policy_facts(policy, VARIED)}


def list_varied(job: EvaluationJob, controllers: Controllers) -> list[VariedJob]:
    """A controller's job with each of its other gain sets that is stable at the control frequency.

    Args:
        job: job of the controller with the gains that are compared.
        controllers: the controllers that can be made, by name.
    """
    found = []
    where = (job.environment_id, job.scenario, job.control_frequency, job.engine)
    with closing(make_environment(*where)) as env:
        for gains in gain_sets_of(controllers.find(job.controller)):
            choice = replace(job.controller, gains=GainsChoice(gains))
            if choice == job.controller:
                continue
            with suppress(InvalidValueError):  # refused as unstable at this control frequency
                controllers.make(choice, env)
                known = {entry.name: getattr(job, entry.name) for entry in fields(EvaluationJob)}
                found.append(VariedJob(**{**known, "controller": choice}))
    return found


@dataclass(frozen=True)
class ComparedFloorJob(FloorJob):
    """A floor with which policies are compared."""

    @property
    def name(self) -> str:
        """See `Job.name`; it differs from that of an evaluation, whose records hold less."""
        return f"{super().name}_compared"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`."""
        return {**super().run(controllers), **policy_facts(self.floor, FLOOR)}


def _search_history(tuned: TunedController, scenario: str) -> dict[str, Any]:
    """The score in a scenario of the best candidate so far; wall times and violations were not recorded.

    Empty for a scenario that was not searched.
    """
    if scenario not in tuned.scenarios:
        return {}
    unknown = [np.nan] * len(tuned.history)
    return {
        "scenario": scenario,
        "control_frequency": tuned.control_frequency,
        "steps": [steps for steps, _ in tuned.history],
        "seconds": unknown,
        "score": list(tuned.history_by_scenario[scenario]),
        "violations": unknown,
    }


def find_search(environment_id: str, controller: ControllerChoice) -> TunedController | None:
    """The search of the package for the gains with which a controller is compared; None where there is none.

    Args:
        environment_id: id of the environment.
        controller: controller with its gains.

    Raises:
        InvalidValueError: a file whose controller or environment differs from its name.
        DataFileError: a file that is damaged.
    """
    name = f"{environment_id}/{controller.name}"
    if controller != ControllerChoice(controller.name) or name not in list_tuned_controllers(environment_id):
        return None
    tuned = load_tuned_controller(name)
    held = f"{tuned.environment}/{tuned.controller}"
    if held != name:
        raise InvalidValueError(f"content of tuned controller {name!r}", held, name)
    return tuned


@dataclass(frozen=True)
class AgentJob:
    """A learned agent in a scenario, in its own action mode and at its own control frequency.

    Attributes:
        agent: path and training conditions of the agent.
        scenario: name of the scenario.
        episodes: number of episodes.
        seed: random seed of the first episode.
        engine: engine of the environment, whichever one the agent was trained with.
    """

    agent: AgentFile
    scenario: str
    episodes: int
    seed: int
    engine: str = MUJOCO

    @property
    def environment_id(self) -> str:
        """See `Job.environment_id`."""
        return self.agent.environment_id

    @property
    def name(self) -> str:
        """See `Job.name`; agents of one group are distinguished by the digest."""
        group = re.sub(r"[^\w-]+", "-", self.agent.group)
        return f"{self.environment_id}_{self.scenario}_{AGENT}_{group}_{self.agent.sha256[:16]}"

    def run(self, controllers: Controllers) -> Record:
        """See `Job.run`.

        Raises:
            InvalidValueError: the agent's files have changed since the job was made.
        """
        agent = self.agent
        path = Path(agent.path)  # a path, since a name may be that of another agent
        _check_digest(agent.path, digest(path), agent.sha256)
        policy = load_agent(path)
        facts = {
            **policy_facts(agent.group, AGENT, agent.mode),
            "training_seed": agent.training_seed,
            "history": learning_history(policy.card),
            "path": agent.path,
            "sha256": agent.sha256,
        }
        with closing(policy.make_env(scenario=self.scenario, engine=self.engine)) as env:
            return _evaluate(policy, env, self, facts, {"agent": agent_revision(policy.card)})


ComparisonJob = ControllerJob | VariedJob | ComparedFloorJob | AgentJob


def _check_digest(path: str, found: str, expected: str) -> None:
    if found != expected:
        raise InvalidValueError(
            f"SHA-256 of {path!r}", found, f"that of when the comparison began, {expected}"
        )
