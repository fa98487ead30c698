"""`AgentCard`: the description of a trained agent, without the weights of its network."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from prp_gym.agents.policy.environments import check_environment
from prp_gym.agents.policy.features import TrackingFeatures
from prp_gym.agents.policy.network import ACTIVATIONS, HEADS, NetworkShape
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError, ShapeError, UnknownNameError
from prp_gym.tasks.fields import Field, ObservationLayout
from prp_gym.tasks.presets import find_preset

FORMAT = 1
"""Format of the card; a change that older readers would misread raises this number."""

_LARGEST_PART = 10_000

Keyword = str | float | int | bool | None | tuple[float, ...]
"""Value of a keyword of `gymnasium.make`, as JSON represents it."""


@dataclass(frozen=True)
class Part:
    """A named part of an observation or of an action.

    Attributes:
        name: name of the part.
        size: number of components of the part.

    Raises:
        InvalidValueError: no component, or too many.
    """

    name: str
    size: int

    def __post_init__(self) -> None:
        if not 1 <= self.size <= _LARGEST_PART:
            raise InvalidValueError(f"size of part {self.name!r}", self.size, f"1 to {_LARGEST_PART}")


@dataclass(frozen=True)
class Interface:
    """The environment in which an agent was trained, and the agent's inputs and outputs.

    Attributes:
        environment_id: id for `gymnasium.make`, with its version.
        keywords: keywords of the environment.
        observation: fields of the observation, in order.
        features: names of the parts of the network's input, in order.
        action: parts of an action, in order; empty where they are not known.
        environment_revision: revision of the environment's behaviour; 1 for a card without this key.

    Raises:
        UnknownNameError: an environment that is not registered, or a keyword that it does not declare.
        InvalidValueError: a revision below 1; an observation or action of more than 10,000 components; a
            keyword that is not allowed.
    """

    environment_id: str
    keywords: Mapping[str, Keyword]
    observation: tuple[Part, ...]
    features: tuple[str, ...]
    action: tuple[Part, ...]
    environment_revision: int = 1

    def __post_init__(self) -> None:
        check_environment(self.environment_id, self.keywords)
        for name in ("observation", "action"):
            size = sum(part.size for part in getattr(self, name))
            if size > _LARGEST_PART:
                raise InvalidValueError(f"size of the {name}", size, f"at most {_LARGEST_PART}")
        if self.environment_revision < 1:
            allowed = "a whole number, at least 1"
            raise InvalidValueError("environment_revision", self.environment_revision, allowed)

    @property
    def task_id(self) -> str:
        """Id of the task; that of the environment may be a learning preset."""
        return find_preset(self.environment_id).task.id

    @property
    def all_keywords(self) -> Mapping[str, Keyword]:
        """Keywords of the environment, with those that its id sets."""
        return find_preset(self.environment_id).complete(self.keywords)

    def make_layout(self) -> ObservationLayout:
        """Layout of the observation, with names and sizes of the fields only."""
        return ObservationLayout(
            [
                Field.symmetric(part.name, ("",) * part.size, "", (0.0,) * part.size, "")
                for part in self.observation
            ]
        )


@dataclass(frozen=True)
class CurvePoint:
    """An evaluation on held-out episodes during training.

    Attributes:
        steps: number of training steps so far, summed over the parallel environments.
        seconds: wall-clock time since training began [s].
        score: mean reward over the held-out episodes.
        violations: number of violated limits in training so far, by the kind of limit.
    """

    steps: int
    seconds: float
    score: float
    violations: Mapping[str, float]


@dataclass(frozen=True)
class Score:
    """Score of an evaluation after training.

    Attributes:
        value: mean reward over the episodes.
        low: lower end of the 95 % confidence interval of the mean.
        high: upper end of the 95 % confidence interval of the mean.
        episodes: number of evaluation episodes.
        seed: seed of the first episode.
    """

    value: float
    low: float
    high: float
    episodes: int
    seed: int


@dataclass(frozen=True)
class TrainingRecord:
    """The record of a training.

    Attributes:
        command: command line that repeats the training.
        seed: training seed.
        steps: number of training steps, summed over the parallel environments, when the network was stored.
        seconds: wall-clock time of these steps [s].
        hyperparameters: recipe of the training, as JSON represents it.
        curve: evaluations on held-out episodes, in order.
    """

    command: str
    seed: int
    steps: int
    seconds: float
    hyperparameters: Mapping[str, Any]
    curve: tuple[CurvePoint, ...]


@dataclass(frozen=True)
class AgentCard:
    """The description of a trained agent.

    Attributes:
        interface: environment, observation, features and action.
        algorithm: name of the class of the algorithm that trained the agent.
        network: sizes, activation and head of the network.
        run: record of the training.
        scores: scores after training, by scenario.
        versions: versions of Python and of the packages used in training.
        sha256: SHA-256 of the file with the network's weights.

    Raises:
        UnknownNameError: an activation, head or part of the features that does not exist.
        ShapeError: a network with other inputs than the features, or with other outputs than the action.
        InvalidValueError: a layer without units; a part without components, or two parts of the same name.
    """

    interface: Interface
    algorithm: str
    network: NetworkShape
    run: TrainingRecord
    scores: Mapping[str, Score]
    versions: Mapping[str, str]
    sha256: str

    def __post_init__(self) -> None:
        network, action = self.network, sum(part.size for part in self.interface.action)
        for kind, name, valid in (
            ("activation", network.activation, ACTIVATIONS),
            ("head", network.head, HEADS),
        ):
            if name not in valid:
                raise UnknownNameError(kind, name, valid)
        layers = (network.inputs, *network.memory, *network.hidden, network.outputs)
        if min(layers) < 1:
            raise InvalidValueError("layer sizes", layers, "at least 1")
        features = make_features(self.interface)
        if features.size != network.inputs:
            raise ShapeError("input of the network", (network.inputs,), f"({features.size},), the features")
        if action not in (0, network.outputs):
            raise ShapeError("output of the network", (network.outputs,), f"({action},), the action")

    @property
    def environment_id(self) -> str:
        """Id of the environment in which the agent was trained, of a task or of its learning preset."""
        return self.interface.environment_id

    @property
    def task_id(self) -> str:
        """Id of the task on which the agent was trained."""
        return self.interface.task_id

    @property
    def action_size(self) -> int:
        """Number of components of an action."""
        return self.network.outputs

    @property
    def action_mode(self) -> str:
        """Name of the action mode, which says what the agent's actions mean."""
        return str(self.interface.all_keywords.get("action_mode", EnvConfig.action_mode))

    @property
    def control_frequency(self) -> float:
        """Control frequency of the environment in which the agent was trained [Hz]."""
        frequency = self.interface.all_keywords.get("control_frequency", EnvConfig.control_frequency)
        if not isinstance(frequency, int | float):
            raise InvalidValueError("control_frequency of the agent", frequency, "a number", "Hz")
        return float(frequency)

    @property
    def engine(self) -> str:
        """Name of the engine that simulated the training; MuJoCo of a card that names none."""
        return str(self.interface.all_keywords.get("engine", EnvConfig.engine))

    @property
    def steps(self) -> int:
        """Number of steps of the whole training, including those after the network was stored."""
        return self.run.curve[-1].steps if self.run.curve else self.run.steps

    @property
    def seed(self) -> int:
        """Training seed."""
        return self.run.seed


class PlainFeatures:
    """Features that are the observation itself.

    Args:
        layout: layout of the observation.

    Attributes:
        names: names of the parts of the features, in order.
        size: number of features.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self.names = layout.names
        self.size = layout.size

    def __call__(self, observation: Any) -> Any:
        """The observation (..., size)."""
        return observation


def make_features(interface: Interface) -> TrackingFeatures | PlainFeatures:
    """The function that computes the network's input from an observation.

    Args:
        interface: interface of the agent.

    Raises:
        UnknownNameError: parts other than those of the observation or of `TrackingFeatures`.
    """
    layout = interface.make_layout()
    for features in (TrackingFeatures(layout), PlainFeatures(layout)):
        if features.names == interface.features:
            return features
    raise UnknownNameError("list of features", interface.features, [str(TrackingFeatures(layout).names)])
