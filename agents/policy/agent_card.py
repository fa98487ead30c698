"""`AgentCard`: all that there is to know of a trained agent but the numbers of its network."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from prp_gym.agents.policy.features import TrackingFeatures
from prp_gym.agents.policy.network import ACTIVATIONS, HEADS, NetworkShape
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError, ShapeError, UnknownNameError
from prp_gym.tasks.fields import Field, ObservationLayout

FORMAT = 1
"""Of the card; a change that older readers would misread raises it."""

_LARGEST_PART = 10_000

Keyword = str | float | int | bool | None | tuple[float, ...]
"""A keyword of `gymnasium.make`, as JSON knows it."""


@dataclass(frozen=True)
class Part:
    """Of an observation or of an action.

    Attributes:
        name: of the part.
        size: number of components.

    Raises:
        InvalidValueError: no component, or absurdly many.
    """

    name: str
    size: int

    def __post_init__(self) -> None:
        if not 1 <= self.size <= _LARGEST_PART:
            raise InvalidValueError(f"size of part {self.name!r}", self.size, f"1 to {_LARGEST_PART}")


@dataclass(frozen=True)
class Interface:
    """Between what and what the agent stands.

    Attributes:
        environment_id: for `gymnasium.make`, with its version.
        keywords: of the environment in which it was trained.
        observation: fields of the observation, in order.
        features: parts of what the network is given, in order.
        action: its parts, in order; none where they are not known.
    """

    environment_id: str
    keywords: Mapping[str, Keyword]
    observation: tuple[Part, ...]
    features: tuple[str, ...]
    action: tuple[Part, ...]

    def make_layout(self) -> ObservationLayout:
        """The observation's layout, with names and sizes alone."""
        return ObservationLayout(
            [
                Field.symmetric(part.name, ("",) * part.size, "", (0.0,) * part.size, "")
                for part in self.observation
            ]
        )


@dataclass(frozen=True)
class CurvePoint:
    """A held-out evaluation during training.

    Attributes:
        steps: taken so far in all environments together.
        seconds: since training began [s].
        score: mean over the held-out episodes of return/duration.
        violations: of limits in training so far, by their kinds.
    """

    steps: int
    seconds: float
    score: float
    violations: Mapping[str, float]


@dataclass(frozen=True)
class Score:
    """Of an evaluation after training.

    Attributes:
        value: interquartile mean over episodes of return/duration.
        low: lower end of its interval.
        high: upper end of its interval.
        episodes: that were played.
        seed: of the first one.
    """

    value: float
    low: float
    high: float
    episodes: int
    seed: int


@dataclass(frozen=True)
class Run:
    """The training.

    Attributes:
        command: that repeats it.
        seed: of the training.
        steps: taken in all environments together until the network was as it is.
        seconds: that they took [s].
        hyperparameters: of the algorithm, as JSON knows them.
        curve: held-out evaluations, in order.
    """

    command: str
    seed: int
    steps: int
    seconds: float
    hyperparameters: Mapping[str, Any]
    curve: tuple[CurvePoint, ...]


@dataclass(frozen=True)
class AgentCard:
    """What a trained agent is, and how it came about.

    Attributes:
        interface: environment, observation, features and action.
        algorithm: that trained it, by its class's name.
        network: its shape.
        run: the training.
        scores: after training, by scenario.
        versions: of Python and of the packages that trained it.
        sha256: of the file with the network's numbers.

    Raises:
        UnknownNameError: an activation, head or part of the features that does not exist.
        ShapeError: a network of other inputs than the features, or of other outputs than the action.
        InvalidValueError: a layer without units; a part without components, or a name given twice.
    """

    interface: Interface
    algorithm: str
    network: NetworkShape
    run: Run
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
        """Of the environment in which the agent was trained."""
        return self.interface.environment_id

    @property
    def action_size(self) -> int:
        """Components of an action."""
        return self.network.outputs

    @property
    def action_mode(self) -> str:
        """What its actions mean."""
        return str(self.interface.keywords.get("action_mode", EnvConfig.action_mode))

    @property
    def control_frequency(self) -> float:
        """Of its actions [Hz]."""
        frequency = self.interface.keywords.get("control_frequency", EnvConfig.control_frequency)
        if not isinstance(frequency, int | float):
            raise InvalidValueError("control_frequency of the agent", frequency, "a number", "Hz")
        return float(frequency)

    @property
    def steps(self) -> int:
        """Of the whole training, also those after the network was as it is."""
        return self.run.curve[-1].steps if self.run.curve else self.run.steps

    @property
    def seed(self) -> int:
        """Of the training."""
        return self.run.seed


class PlainFeatures:
    """The observation as it is.

    Args:
        layout: of the observation.

    Attributes:
        names: of the features' parts, in order.
        size: number of features.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self.names = layout.names
        self.size = layout.size

    def __call__(self, observation: Any) -> Any:
        """The observation (..., size)."""
        return observation


def make_features(interface: Interface) -> TrackingFeatures | PlainFeatures:
    """What makes the network's features of an observation.

    Raises:
        UnknownNameError: parts that neither the observation alone nor `TrackingFeatures` consists of.
    """
    layout = interface.make_layout()
    for features in (TrackingFeatures(layout), PlainFeatures(layout)):
        if features.names == interface.features:
            return features
    raise UnknownNameError("list of features", interface.features, [str(TrackingFeatures(layout).names)])
