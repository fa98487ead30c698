"""Pairs of a comparison: laws, laws tuned with a budget or varied, agents, and no torque at all."""

import re
from collections.abc import Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.baselines import make_baseline
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.comparison.agents import AgentFile, digest, learning_history
from prp_gym.comparison.values import AGENT, BUDGET, CONTROLLER, VARIED, ZERO
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import evaluate
from prp_gym.evaluation.results import describe_evaluation, to_plain
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.job import EvaluationJob, Record, make_environment
from prp_gym.tuning import TunedController, list_tuned_controllers, load_tuned_controller

TORQUE = EnvConfig.action_mode
UNTRAINED = -1
"""Training seed of what is not trained."""


class ZeroPolicy:
    """No torque at all: what a task is worth to who does nothing.

    Args:
        size: of an action.
    """

    def __init__(self, size: int) -> None:
        self._size = size

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """Zeros (..., size) for observations (..., any)."""
        return np.zeros((*np.shape(observation)[:-1], self._size), dtype=np.float32), state


def _facts(policy: str, kind: str, mode: str = TORQUE) -> dict[str, Any]:
    """What a record of a comparison says of its policy beside the evaluation."""
    return {"policy": policy, "kind": kind, "mode": mode, "training_seed": UNTRAINED, "history": {}}


def _play(policy: Policy, env: gymnasium.Env[Any, Any], pair: Any, facts: Mapping[str, Any]) -> Record:
    evaluation = evaluate(policy, env, pair.episodes, pair.seed)
    described = describe_evaluation(evaluation, str(facts["policy"]), facts.get("settings", {}))
    record: Record = to_plain({**described, **facts})
    return record


@dataclass(frozen=True)
class ControllerJob(EvaluationJob):
    """A law with a gain set."""

    @property
    def name(self) -> str:
        """See `Job.name`; another than an evaluation's, whose records say less."""
        return f"{super().name}_{CONTROLLER}"

    def play(self) -> Record:
        """See `Job.play`."""
        return {**super().play(), **_facts(self.controller, CONTROLLER)}


@dataclass(frozen=True)
class VariedJob(EvaluationJob):
    """A law with another gain set than that which is compared: one more policy to try the reward on."""

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{super().name}_{self.gains}_{VARIED}"

    def play(self) -> Record:
        """See `Job.play`."""
        return {**super().play(), **_facts(f"{self.controller} ({self.gains})", VARIED)}


def list_varied(pair: EvaluationJob) -> list[VariedJob]:
    """A law's pair with each of its other gain sets that is stable at the pair's rate."""
    facts = vars(pair)
    found = []
    with closing(make_environment(pair.environment_id, pair.scenario, pair.control_frequency)) as env:
        for gains in gain_sets(pair.controller):
            with suppress(InvalidValueError):  # refused as unstable at this rate
                make_baseline(pair.controller, env, gains)
                found.append(VariedJob(**{**facts, "gains": gains}))
    return [item for item in found if item.gains != pair.gains]


@dataclass(frozen=True)
class ZeroTorqueJob:
    """No torque on an environment.

    Attributes:
        environment_id: for `gymnasium.make`.
        scenario: of the environment.
        control_frequency: actions a second [Hz].
        episodes: that are played.
        seed: of the first episode.
    """

    environment_id: str
    scenario: str
    control_frequency: float
    episodes: int
    seed: int

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{self.environment_id}_{self.scenario}_{ZERO}"

    def play(self) -> Record:
        """See `Job.play`."""
        with closing(make_environment(self.environment_id, self.scenario, self.control_frequency)) as env:
            size = int(np.prod(env.action_space.shape or ()))
            return _play(ZeroPolicy(size), env, self, _facts(ZERO, ZERO))


@dataclass(frozen=True)
class BudgetJob:
    """A law with the settings that tuning with a budget has found, at the rate at which it found them.

    Attributes:
        tuned: the law, and how it was tuned.
        scenario: of the environment.
        episodes: that are played.
        seed: of the first episode.
    """

    tuned: TunedController
    scenario: str
    episodes: int
    seed: int

    @property
    def environment_id(self) -> str:
        """See `Job.environment_id`."""
        return self.tuned.environment

    @property
    def name(self) -> str:
        """See `Job.name`."""
        return f"{self.environment_id}_{self.scenario}_{self.tuned.controller}_{BUDGET}"

    def play(self) -> Record:
        """See `Job.play`."""
        tuned = self.tuned
        facts = {
            **_facts(f"{tuned.controller} ({BUDGET})", BUDGET),
            "settings": tuned.settings,
            "history": _tuning_history(tuned),
        }
        with closing(make_environment(self.environment_id, self.scenario, tuned.control_frequency)) as env:
            return _play(tuned.make(env), env, self, facts)


def _tuning_history(tuned: TunedController) -> dict[str, Any]:
    """How the best score grew in tuning; times and violations are not known."""
    unknown = [np.nan] * len(tuned.history)
    return {
        "scenario": tuned.scenario,
        "control_frequency": tuned.control_frequency,
        "steps": [steps for steps, _ in tuned.history],
        "seconds": unknown,
        "score": [score for _, score in tuned.history],
        "violations": unknown,
    }


def find_tuned_controllers(environment_id: str, controllers: Sequence[str]) -> list[TunedController]:
    """Those of some laws that come with the package as tuned with a budget on an environment.

    Raises:
        InvalidValueError: a file that is damaged, or of another law or environment than its name says.
    """
    names = list_tuned_controllers(environment_id)
    found = []
    for name in (f"{environment_id}/{controller}" for controller in controllers):
        if name in names:
            tuned = load_tuned_controller(name)
            held = f"{tuned.environment}/{tuned.controller}"
            if held != name:
                raise InvalidValueError(f"content of tuned law {name!r}", held, name)
            found.append(tuned)
    return found


@dataclass(frozen=True)
class AgentJob:
    """A learned agent in a scenario, in its own action mode and at its own rate.

    Attributes:
        agent: its file.
        scenario: of the environment.
        episodes: that are played.
        seed: of the first episode.
    """

    agent: AgentFile
    scenario: str
    episodes: int
    seed: int

    @property
    def environment_id(self) -> str:
        """See `Job.environment_id`."""
        return self.agent.environment_id

    @property
    def name(self) -> str:
        """See `Job.name`; agents of one group are told apart by the digest."""
        group = re.sub(r"[^\w-]+", "-", self.agent.group)
        return f"{self.environment_id}_{self.scenario}_{AGENT}_{group}_{self.agent.sha256[:16]}"

    def play(self) -> Record:
        """See `Job.play`.

        Raises:
            InvalidValueError: the agent's files have changed since the pair was made.
        """
        agent = self.agent
        path = Path(agent.path)  # not a name, which may be that of another
        _check_digest(agent.path, digest(path), agent.sha256)
        policy = load_agent(path)
        facts = {
            **_facts(agent.group, AGENT, agent.mode),
            "training_seed": agent.training_seed,
            "history": learning_history(policy.card),
            "path": agent.path,
            "sha256": agent.sha256,
        }
        with closing(policy.make_env(scenario=self.scenario)) as env:
            return _play(policy, env, self, facts)


ComparisonJob = ControllerJob | VariedJob | ZeroTorqueJob | BudgetJob | AgentJob


def _check_digest(path: str, found: str, expected: str) -> None:
    if found != expected:
        raise InvalidValueError(
            f"SHA-256 of {path!r}", found, f"that of when the comparison began, {expected}"
        )
