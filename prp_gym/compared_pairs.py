"""Pairs of a comparison: laws, laws tuned with a budget or varied, agents, and no torque at all."""

import hashlib
import json
import re
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import prp_gym
import prp_gym.baselines
from prp_gym.baselines import make_baseline
from prp_gym.baselines.gains import gain_sets
from prp_gym.compared_agents import AgentFile, digest, learning_history
from prp_gym.comparison.values import AGENT, BUDGET, LAW, VARIED, ZERO
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import evaluate
from prp_gym.evaluation.results import describe_evaluation, to_plain
from prp_gym.evaluation.rollout import Policy
from prp_gym.pairs import Pair, Record, make_environment

EQUAL_BUDGET = Path(str(prp_gym.baselines.__file__)).parent / "equal_budget"
"""Laws that come with the package, tuned with a budget."""

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
class LawPair(Pair):
    """A law with a gain set."""

    @property
    def name(self) -> str:
        """See `Playable.name`; another than an evaluation's, whose records say less."""
        return f"{super().name}_{LAW}"

    def play(self) -> Record:
        """See `Playable.play`."""
        return {**super().play(), **_facts(self.law, LAW)}


@dataclass(frozen=True)
class VariedPair(Pair):
    """A law with another gain set than that which is compared: one more policy to try the reward on."""

    @property
    def name(self) -> str:
        """See `Playable.name`."""
        return f"{super().name}_{self.gains}_{VARIED}"

    def play(self) -> Record:
        """See `Playable.play`."""
        return {**super().play(), **_facts(f"{self.law} ({self.gains})", VARIED)}


def list_varied(pair: Pair) -> list[VariedPair]:
    """A law's pair with each of its other gain sets that is stable at the pair's rate."""
    facts = vars(pair)
    found = []
    with closing(make_environment(pair.environment_id, pair.scenario, pair.control_frequency)) as env:
        for gains in gain_sets(pair.law):
            with suppress(InvalidValueError):  # refused as unstable at this rate
                make_baseline(pair.law, env, gains)
                found.append(VariedPair(**{**facts, "gains": gains}))
    return [item for item in found if item.gains != pair.gains]


@dataclass(frozen=True)
class ZeroPair:
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
        """See `Playable.name`."""
        return f"{self.environment_id}_{self.scenario}_{ZERO}"

    def play(self) -> Record:
        """See `Playable.play`."""
        with closing(make_environment(self.environment_id, self.scenario, self.control_frequency)) as env:
            size = int(np.prod(env.action_space.shape or ()))
            return _play(ZeroPolicy(size), env, self, _facts(ZERO, ZERO))


@dataclass(frozen=True)
class BudgetPair:
    """A law with the settings of a file that tuning with a budget has written.

    Attributes:
        environment_id: for `gymnasium.make`.
        scenario: of the environment.
        law: a baseline.
        path: of the file.
        sha256: of the file.
        episodes: that are played.
        seed: of the first episode.
    """

    environment_id: str
    scenario: str
    law: str
    path: str
    sha256: str
    episodes: int
    seed: int

    @property
    def name(self) -> str:
        """See `Playable.name`."""
        return f"{self.environment_id}_{self.scenario}_{self.law}_{BUDGET}"

    def play(self) -> Record:
        """See `Playable.play`."""
        content = Path(self.path).read_bytes()
        _check_digest(self.path, hashlib.sha256(content).hexdigest(), self.sha256)
        tuned = json.loads(content)
        frequency = float(tuned["control_frequency"])
        history = {
            "scenario": tuned["scenario"],
            "control_frequency": frequency,
            "steps": [steps for steps, _ in tuned["history"]],
            "seconds": [np.nan] * len(tuned["history"]),
            "score": [score for _, score in tuned["history"]],
            "violations": [np.nan] * len(tuned["history"]),
        }
        facts = {
            **_facts(f"{self.law} ({BUDGET})", BUDGET),
            "settings": tuned["settings"],
            "history": history,
            "sha256": self.sha256,
        }
        with closing(make_environment(self.environment_id, self.scenario, frequency)) as env:
            return _play(make_baseline(self.law, env, "tuned", **tuned["settings"]), env, self, facts)


def find_budget_law(environment_id: str, law: str) -> tuple[str, str]:
    """Path and SHA-256 of the file of a law tuned with a budget; empty where none comes with the package.

    Raises:
        InvalidValueError: the file is of another law or environment.
    """
    path = EQUAL_BUDGET / f"{environment_id}_{law}.json"
    if not path.is_file():
        return "", ""
    content = path.read_bytes()
    tuned = json.loads(content)
    if (tuned["environment"], tuned["law"]) != (environment_id, law):
        found = f"{tuned['law']} on {tuned['environment']}"
        raise InvalidValueError(f"content of {path}", found, f"{law} on {environment_id}")
    return str(path), hashlib.sha256(content).hexdigest()


@dataclass(frozen=True)
class AgentPair:
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
        """See `Playable.environment_id`."""
        return self.agent.environment_id

    @property
    def name(self) -> str:
        """See `Playable.name`; agents of one group are told apart by the digest."""
        group = re.sub(r"[^\w-]+", "-", self.agent.group)
        return f"{self.environment_id}_{self.scenario}_{AGENT}_{group}_{self.agent.sha256[:16]}"

    def play(self) -> Record:
        """See `Playable.play`.

        Raises:
            InvalidValueError: the agent's files have changed since the pair was made.
        """
        agent = self.agent
        _check_digest(agent.path, digest(Path(agent.path)), agent.sha256)
        policy = prp_gym.load_agent(agent.path)
        facts = {
            **_facts(agent.group, AGENT, agent.mode),
            "training_seed": agent.training_seed,
            "history": learning_history(policy.card),
            "path": agent.path,
            "sha256": agent.sha256,
        }
        with closing(policy.make_env(scenario=self.scenario)) as env:
            return _play(policy, env, self, facts)


ComparedPair = LawPair | VariedPair | ZeroPair | BudgetPair | AgentPair


def _check_digest(path: str, found: str, expected: str) -> None:
    if found != expected:
        raise InvalidValueError(
            f"SHA-256 of {path!r}", found, f"that of when the comparison began, {expected}"
        )
