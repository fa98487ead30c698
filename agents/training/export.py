"""`export_agent`: a model of Stable-Baselines3 as a `LearnedPolicy`."""

import platform
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from prp_gym.agents.algorithms import ALGORITHMS, AlgorithmSpec
from prp_gym.agents.policy.agent_card import (
    AgentCard,
    Interface,
    Keyword,
    Part,
    PlainFeatures,
    Score,
    TrainingRecord,
)
from prp_gym.agents.policy.agent_tensors import digest, pack_tensors
from prp_gym.agents.policy.environments import environment_revision
from prp_gym.agents.policy.features import TrackingFeatures
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.policy.network import Network
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.sb3.packages import require
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.tasks.fields import ObservationLayout

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

_PACKAGES = ("prp-gym", "gymnasium", "mujoco", "numpy", "stable-baselines3", "sb3-contrib", "torch")
_LARGEST_DIFFERENCE = 1e-5  # of actions: rounding in single precision over a few hundred products per unit
_TRIALS, _STEPS = 64, 4  # observations at once, and consecutive steps


@dataclass(frozen=True)
class AgentFacts:
    """What a card states and a model of Stable-Baselines3 does not know.

    Attributes:
        environment_id: id for `gymnasium.make`, with its version.
        environment_keywords: keywords of the environment in which the agent was trained.
        layout: layout of the observation.
        run: record of the training.
        scores: scores after training, by scenario; empty before an evaluation.
        action: parts of an action, in order; empty where they are not known.
    """

    environment_id: str
    environment_keywords: Mapping[str, Keyword]
    layout: ObservationLayout
    run: TrainingRecord
    scores: Mapping[str, Score] = field(default_factory=dict)
    action: tuple[Part, ...] = ()


def identity_normalizer(size: int) -> Normalizer:
    """The normaliser of features that were not normalised in training.

    Args:
        size: number of features.
    """
    return Normalizer(np.zeros(size), np.ones(size), 0.0, np.inf)


def export_agent(model: "BaseAlgorithm", normalizer: Normalizer, facts: AgentFacts) -> LearnedPolicy:
    """A trained model as an agent that needs neither PyTorch nor Stable-Baselines3.

    Args:
        model: model of a declared algorithm, with a policy network that its declaration can read.
        normalizer: normaliser of the features in training.
        facts: what the model does not know.

    Raises:
        MissingPackageError: Stable-Baselines3 is not installed.
        UnknownNameError: an environment or keyword that does not exist.
        InvalidValueError: an algorithm that is not declared, a network that cannot be exported, or one whose
            actions in numpy differ from those in PyTorch.
        ShapeError: a normaliser or observation layout with other features than the model's.
    """
    require()
    from prp_gym.agents.sb3.network_reader import read_network

    network = read_network(model, _find_algorithm(model).entry.read_actor)
    interface = _interface(facts, network.shape.inputs)
    for name in ("mean", "variance"):
        if np.shape(getattr(normalizer, name)) != (network.shape.inputs,):
            expected = f"({network.shape.inputs},), as the model's features"
            raise ShapeError(f"{name} of the normalizer", np.shape(getattr(normalizer, name)), expected)
    _check_actions(model, network)
    card = AgentCard(
        interface=interface,
        algorithm=type(model).__name__,
        network=network.shape,
        run=facts.run,
        scores=facts.scores,
        versions=_versions(),
        sha256=digest(pack_tensors(normalizer, network)),
    )
    return LearnedPolicy(card, normalizer, network)


def _find_algorithm(model: "BaseAlgorithm") -> AlgorithmSpec:
    """The declaration of the algorithm that trained a model.

    Raises:
        InvalidValueError: no declared algorithm has the model's class.
    """
    name = type(model).__name__
    for spec in ALGORITHMS.values():
        if spec.entry.class_name == name and isinstance(model, spec.load_class()):
            return spec
    valid = sorted(spec.entry.class_name for spec in ALGORITHMS.values())
    raise InvalidValueError("algorithm", name, f"one of {', '.join(valid)}")


def _versions() -> dict[str, str]:
    """Versions of Python and of the packages that are installed."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def _interface(facts: AgentFacts, inputs: int) -> Interface:
    """The agent's interface, with that one of the two kinds of features that the network has inputs for.

    Raises:
        ShapeError: the network has inputs for neither kind.
    """
    kinds = (TrackingFeatures(facts.layout), PlainFeatures(facts.layout))
    fitting = [features for features in kinds if features.size == inputs]
    if not fitting:
        sizes = " or ".join(str((features.size,)) for features in kinds)
        raise ShapeError("observation of the model", (inputs,), f"{sizes} on {facts.environment_id}")
    return Interface(
        environment_id=facts.environment_id,
        keywords=dict(facts.environment_keywords),
        observation=tuple(Part(part.name, part.shape[0]) for part in facts.layout.fields),
        features=fitting[0].names,
        action=facts.action,
        environment_revision=environment_revision(facts.environment_id),
    )


def _check_actions(model: "BaseAlgorithm", network: Network) -> None:
    """Refuse a network whose actions in numpy differ from the model's in PyTorch.

    Raises:
        InvalidValueError: they differ by more than rounding.
    """
    rng = np.random.default_rng(0)
    memory = network.initial_memory((_TRIALS,))
    state: Any = None
    starts = np.ones(_TRIALS, dtype=np.bool_)
    for _ in range(_STEPS):
        features = rng.standard_normal((_TRIALS, network.shape.inputs)).astype(np.float32)
        expected, state = model.predict(features, state, episode_start=starts, deterministic=True)
        action, memory = network(features, memory)
        difference = float(np.max(np.abs(action - expected)))
        if not difference <= _LARGEST_DIFFERENCE:
            allowed = f"at most {_LARGEST_DIFFERENCE:g}; please report this model"
            raise InvalidValueError("difference between numpy's and torch's actions", difference, allowed)
        starts[:] = False
