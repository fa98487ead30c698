"""Learned agents to compare: their files, and the contents of their cards."""

import hashlib
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from prp_gym.agents.policy import agent_file
from prp_gym.agents.policy.agent_card import AgentCard
from prp_gym.agents.policy.agent_file import CARD, TENSORS, list_agents, list_seeds, load_agent
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError

_RUN = "agent"  # name of the files in the folder of a training seed
_LEARNING = "RL"  # addition to the names of agents that were trained on a learning preset
_SEED = re.compile(r"_seed_\d+$")


@dataclass(frozen=True)
class AgentFile:
    """An agent of one training seed.

    Attributes:
        path: path of the agent's files, without suffix.
        sha256: SHA-256 digest over both files.
        group: name that it shares with the agents of other training seeds.
        environment_id: id of the task on which the agent was trained, also through its learning preset.
        mode: action mode in which the agent was trained.
        control_frequency: control frequency of the environment [Hz].
        training_seed: random seed of the agent's training.
    """

    path: str
    sha256: str
    group: str
    environment_id: str
    mode: str
    control_frequency: float
    training_seed: int

    @classmethod
    def read(cls, path: Path, group: str) -> "AgentFile":
        """An agent by the path of its files, without suffix.

        Raises:
            PRPError: files that are missing, damaged or no agent.
        """
        card = load_agent(path).card
        learned_on_errors = card.environment_id != card.task_id
        return cls(
            path=str(path),
            sha256=digest(path),
            group=f"{group} ({_LEARNING})" if learned_on_errors else group,
            environment_id=card.task_id,
            mode=card.action_mode,
            control_frequency=card.control_frequency,
            training_seed=card.seed,
        )


def digest(path: Path) -> str:
    """SHA-256 over the numbers and the card of an agent, by the path of its files without suffix."""
    found = hashlib.sha256()
    for suffix in (TENSORS, CARD):
        content = agent_file.read_content(Path(f"{path}{suffix}"))
        found.update(f"{suffix}\0{len(content)}\0".encode())
        found.update(content)
    return found.hexdigest()


def agent_revision(card: AgentCard) -> int:
    """Revision of the behaviour of the task on which an agent was trained; 1 of a card that has none."""
    return card.interface.environment_revision


def learning_history(card: AgentCard) -> dict[str, Any]:
    """How an agent's held-out score grew in training, as a record holds it."""
    points = card.run.curve
    if not points:
        return {}
    return {
        "scenario": str(card.interface.keywords.get("scenario", EnvConfig.scenario)),
        "control_frequency": card.control_frequency,
        "steps": [point.steps for point in points],
        "seconds": [point.seconds for point in points],
        "score": [point.score for point in points],
        "violations": [float(sum(point.violations.values())) for point in points],
    }


def find_agents(environment_ids: Sequence[str], paths: Sequence[Path]) -> list[AgentFile]:
    """The agents of the package for some environments, and those that are given by path.

    Args:
        environment_ids: ids of the chosen environments.
        paths: paths of agents' files, with or without suffix, or of folders of training seeds `seed_<k>`.

    Returns:
        agents of every training seed; groups of one name on one environment are distinguished by a number.

    Raises:
        InvalidValueError: a path without agents, an agent of another environment, or agents of one group
            that differ in more than their training seed.
    """
    agents: list[AgentFile] = []
    for group, stems in [*_shipped(environment_ids), *(_given(path) for path in paths)]:
        own = [AgentFile.read(stem, group) for stem in stems]
        for agent in own:
            if agent.environment_id not in environment_ids:
                allowed = f"one of the chosen ones: {', '.join(environment_ids)}"
                raise InvalidValueError(f"environment of agent {agent.path!r}", agent.environment_id, allowed)
        agents += _renamed(own, {(agent.environment_id, agent.group) for agent in agents})
    _check_groups(agents)
    return agents


def _shipped(environment_ids: Sequence[str]) -> Iterable[tuple[str, list[Path]]]:
    for environment_id in environment_ids:
        for name in list_agents(environment_id):
            group = name.removeprefix(f"{environment_id}/")
            yield group, [agent_file.TRAINED / seed for seed in list_seeds(name)]


def _given(path: Path) -> tuple[str, list[Path]]:
    """Name and agents of a path that the user gave.

    Raises:
        InvalidValueError: there are none.
    """
    if os.path.isdir(path):
        stems = [card.with_name(_RUN) for card in sorted(path.glob(f"seed_*/{_RUN}{CARD}"))]
        if os.path.isfile(path / f"{_RUN}{CARD}"):  # the folder of one training seed
            return Path(os.path.realpath(path)).parent.name, [path / _RUN]
        name = Path(os.path.realpath(path)).name
    else:
        stem = path.with_name(path.name.removesuffix(TENSORS).removesuffix(CARD))
        stems = [stem] if os.path.isfile(stem.with_name(f"{stem.name}{CARD}")) else []
        run = Path(os.path.realpath(stem)).parent  # seed_<k> in a run's folder
        name = run.parent.name if stem.name == _RUN else _SEED.sub("", stem.name)
    if not stems:
        allowed = f"an agent's {TENSORS} and {CARD}, or a folder with seed_*/{_RUN}{TENSORS}"
        raise InvalidValueError("agent", str(path), allowed)
    return name, stems


def _renamed(agents: list[AgentFile], taken: set[tuple[str, str]]) -> list[AgentFile]:
    """The same agents under a group name that is unique in their environment."""
    if not agents:
        return agents
    name, number = agents[0].group, 1
    while any((agent.environment_id, name) in taken for agent in agents):
        number += 1
        name = f"{agents[0].group} ({number})"
    return [AgentFile(**{**vars(agent), "group": name}) for agent in agents]


def _check_groups(agents: Sequence[AgentFile]) -> None:
    """Refuse agents of one group that differ in more than their training seed, or that have the same one."""
    firsts: dict[tuple[str, str], AgentFile] = {}
    seen = set()
    for agent in agents:
        first = firsts.setdefault((agent.environment_id, agent.group), agent)
        for name in ("mode", "control_frequency"):
            if getattr(agent, name) != getattr(first, name):
                what = f"{name} of agent {agent.path!r}"
                raise InvalidValueError(
                    what, getattr(agent, name), f"that of its group, {getattr(first, name)!r}"
                )
        key = (agent.environment_id, agent.group, agent.training_seed)
        if key in seen:
            what = f"training seed of agent {agent.path!r}"
            raise InvalidValueError(what, agent.training_seed, "one that no other agent of its group has")
        seen.add(key)
