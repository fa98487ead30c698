"""Trained agents as files: weights as safetensors and a card as JSON, formats that cannot hold code."""

import os
import re
from dataclasses import replace
from pathlib import Path

from prp_gym.agents.policy.agent_tensors import digest, pack_tensors, unpack_tensors
from prp_gym.agents.policy.card_file import READER, pack_card, unpack_card
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.artifacts import write_file
from prp_gym.checks import choice
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import AgentFileError, InvalidValueError, UnknownNameError
from prp_gym.files.file_reader import FileReader
from prp_gym.tasks.registration import list_envs

TRAINED = Path(__file__).parents[1] / "trained"
"""Folder of the agents that are shipped with the package."""

TENSORS, CARD = ".safetensors", ".json"
_WITH_CODE = frozenset((".zip", ".pkl", ".pickle", ".pt", ".pth", ".npy", ".npz", ".joblib"))
_READERS = {TENSORS: FileReader(256 * 2**20, AgentFileError), CARD: READER}
_LONGEST_PATH = 4096  # characters
_ONE_SEED = re.compile(r"(?P<group>.+)_seed_(?P<seed>\d+)")


def save_agent(policy: LearnedPolicy, path: str | Path) -> tuple[Path, Path]:
    """Write an agent's two files, each atomically.

    Args:
        policy: agent to write.
        path: path of the files, with or without either suffix; a missing folder is created.

    Returns:
        the paths of the weights and of the card.

    Raises:
        AgentFileError: a card or weights that could not be read again, for instance NaN.
        OutputError: the files cannot be written.
    """
    tensors, card = _twins(path)
    content = pack_tensors(policy.normalizer, policy.network)
    described = replace(policy.card, sha256=digest(content))
    packed = pack_card(described)
    unpack_tensors(tensors, content, unpack_card(card, packed))
    write_file(tensors, content)
    write_file(card, packed)
    return tensors, card


def load_agent(name_or_path: str | Path) -> LearnedPolicy:
    """A trained agent, which needs numpy only; no file that can hold code is opened.

    Args:
        name_or_path: name of a shipped agent or path of an agent's files. The name
            `<environment id>/<algorithm>_<action mode>` stands for the training seed with the median score,
            the same with `_seed_<k>` for training seed k. A path has either suffix or none.

    Raises:
        UnknownNameError: no shipped agent has this name.
        InvalidValueError: neither a name nor a path.
        AgentFileError: a file that is missing, damaged, altered or of another kind.
    """
    if not isinstance(name_or_path, (str, Path)) or len(str(name_or_path)) > _LONGEST_PATH:
        raise InvalidValueError("agent", name_or_path, f"a name or path of up to {_LONGEST_PATH} characters")
    if isinstance(name_or_path, str) and name_or_path in _shipped():
        return _load(*_twins(TRAINED / _median(name_or_path)))
    tensors, card = _twins(name_or_path)
    named = isinstance(name_or_path, str) and Path(name_or_path).suffix not in (TENSORS, CARD)
    if named and not os.path.exists(tensors) and not os.path.exists(card):
        raise UnknownNameError("agent", name_or_path, _shipped())
    return _load(tensors, card)


def list_agents(environment_id: str | None = None) -> list[str]:
    """Names of the shipped agents, each of which stands for a group of training seeds.

    Args:
        environment_id: id of the environment in which the agents were trained; None for all.

    Raises:
        UnknownNameError: an environment that is not registered.
    """
    if environment_id is not None:
        choice("environment", environment_id, list_envs())
    groups = {_group(name) for name in _files()}
    return sorted(name for name in groups if environment_id in (None, name.partition("/")[0]))


def list_seeds(group: str) -> list[str]:
    """Names of the agents in a group, one for each training seed, in the order of the seeds.

    Args:
        group: name of the group, as `list_agents` gives it.

    Raises:
        UnknownNameError: no such group.
    """
    own = [name for name in _files() if _group(name) == group]
    if not own:
        raise UnknownNameError("group of agents", group, list_agents())
    return sorted(own, key=lambda name: (len(name), name))


def _files() -> list[str]:
    """Names of all shipped agents, `<environment id>/<file name without suffix>`."""
    paths = sorted(TRAINED.glob(f"*/*{CARD}"))
    return [f"{path.parent.name}/{path.name.removesuffix(CARD)}" for path in paths]


def _shipped() -> list[str]:
    return [*list_agents(), *_files()]


def _group(name: str) -> str:
    match = _ONE_SEED.fullmatch(name)
    return match["group"] if match else name


def _median(name: str) -> str:
    """The agent itself, or a group's agent of (lower) median score; equal scores are ordered by seed."""
    files = _files()
    if name in files:
        return name
    seeds = list_seeds(name)
    if len(seeds) == 1:
        return seeds[0]
    ranked = sorted((_own_score(seed), index) for index, seed in enumerate(seeds))
    return seeds[ranked[(len(ranked) - 1) // 2][1]]


def _own_score(name: str) -> float:
    """The score that an agent's card states for the scenario of the training."""
    _, path = _twins(TRAINED / name)
    card = unpack_card(path, read_content(path))
    scenario = card.interface.keywords.get("scenario", EnvConfig.scenario)
    if scenario not in card.scores:
        raise AgentFileError(path, f"has no score in scenario {scenario!r}, in which it was trained")
    return card.scores[str(scenario)].value


def _twins(path: str | Path) -> tuple[Path, Path]:
    """Paths of an agent's two files.

    Raises:
        AgentFileError: the suffix of a file that can hold code.
    """
    given = str(path)
    if Path(given).suffix.lower() in _WITH_CODE:
        remedy = f"convert it, if you trust its author: prp-gym export {given} --trust --env ID --output OUT"
        raise AgentFileError(
            given, f"files with this suffix can run code when they are opened, so it is not opened; {remedy}"
        )
    stem = given.removesuffix(TENSORS).removesuffix(CARD)
    return Path(stem + TENSORS), Path(stem + CARD)


def _load(tensors: Path, card: Path) -> LearnedPolicy:
    described = unpack_card(card, read_content(card))
    return LearnedPolicy(described, *unpack_tensors(tensors, read_content(tensors), described))


def read_content(path: Path) -> bytes:
    """The content of one of an agent's two files.

    Args:
        path: path of the file, with its suffix.

    Raises:
        AgentFileError: a file that cannot be read, or that is larger than the files of any agent.
    """
    try:
        return _READERS[path.suffix].read_bytes(path)
    except AgentFileError as error:
        if not isinstance(error.__cause__, FileNotFoundError):
            raise
        raise AgentFileError(path, f"is missing; an agent is two files, {TENSORS} and {CARD}") from None
