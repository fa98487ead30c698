"""`Baseline`: a classical control law as a policy with Stable-Baselines3's `predict` protocol."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, MissingFieldError, UnknownNameError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import NOMINAL, RobotParameters
from prp_gym.tasks.fields import ObservationLayout

PolicyState = tuple[NDArray[Any], ...] | None


@dataclass(frozen=True, eq=False)
class ControlInterface:
    """All that a law may know of an environment, beside what it observes.

    Attributes:
        environment_id: its id.
        layout: of the observation.
        torque_limit: joint torques at action 1 (3) [N m, N, N m].
        period: of control [s].
    """

    environment_id: str
    layout: ObservationLayout
    torque_limit: Array
    period: float

    @classmethod
    def of(cls, env: Any) -> Self:
        """The interface of an environment of this suite, wrapped or not.

        Raises:
            InvalidValueError: another environment.
        """
        inner = getattr(env, "unwrapped", env)
        try:
            return cls(
                environment_id=inner.task.environment_id,
                layout=inner.observation_layout,
                torque_limit=np.asarray(inner.torque_limit),
                period=1.0 / inner.control_frequency,
            )
        except AttributeError:
            raise InvalidValueError("env", env, "an environment of prp_gym, wrapped or not") from None


@dataclass(frozen=True, eq=False)
class Settings:
    """A law's numbers; subclasses declare them. Vectors (3) may be given as one number for all joints.

    Two settings are equal only if they are the same object.
    """

    @classmethod
    def from_mapping(cls, law: str, values: Mapping[str, Any]) -> Self:
        """Settings by name.

        Raises:
            UnknownNameError: a name that the law does not have.
            InvalidValueError: a value that is not allowed.
        """
        names = [entry.name for entry in fields(cls)]
        for name in values:
            if name not in names:
                raise UnknownNameError(f"setting of law {law!r}", name, names)
        return cls(**values)

    def _make_vector(self, name: str, unit: str) -> None:
        """Turn a setting into a vector (3) of finite numbers, none negative."""
        given = getattr(self, name)
        try:
            vector = np.broadcast_to(np.asarray(given, dtype=np.float64), 3).copy()
        except (TypeError, ValueError):
            raise InvalidValueError(name, given, "one number or three", unit) from None
        if not (np.isfinite(vector).all() and (vector >= 0.0).all()):
            raise InvalidValueError(name, given, "finite and at least 0", unit)
        vector.flags.writeable = False
        object.__setattr__(self, name, vector)


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelSettings(Settings):
    """Numbers of a law that computes with a model of the arm.

    Attributes:
        model: of the arm; it may differ from the plant.
    """

    model: RobotParameters = NOMINAL

    def __post_init__(self) -> None:
        if not isinstance(self.model, RobotParameters):
            raise InvalidValueError("model", self.model, "a RobotParameters")


SettingsT = TypeVar("SettingsT", bound=Settings)
ModelSettingsT = TypeVar("ModelSettingsT", bound=ModelSettings)


class Baseline(ABC, Generic[SettingsT]):
    """A control law on one environment, or on many of them at once.

    Args:
        interface: what the law may know of the environment.
        settings: the law's numbers.

    Attributes:
        name: of the law.
        summary: one line for listings.
        required_fields: of the observation that the law reads.
        settings_class: of its numbers.

    Raises:
        MissingFieldError: the environment does not observe what the law reads.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    required_fields: ClassVar[tuple[str, ...]]
    settings_class: ClassVar[type[Settings]]

    def __init__(self, interface: ControlInterface, settings: SettingsT) -> None:
        missing = [name for name in self.required_fields if name not in interface.layout.names]
        if missing:
            raise MissingFieldError(self.name, missing, interface.layout.names)
        self.interface = interface
        self.settings = settings

    @abstractmethod
    def torque(self, observed: Mapping[str, Array]) -> Array:
        """The law.

        Args:
            observed: fields by name, each (..., size), in the units of their declaration.

        Returns:
            (..., 3) joint torques, unlimited [N m, N, N m].
        """

    def predict(
        self,
        observation: NDArray[Any] | dict[str, NDArray[Any]],
        state: PolicyState = None,
        episode_start: NDArray[Any] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], PolicyState]:
        """The action for one observation or for several, as Stable-Baselines3's policies give it.

        Args:
            observation: (size) or (N, size).
            state: what the last call returned; None at first.
            episode_start: (N) whether an episode starts with this observation.
            deterministic: of no effect: the laws are deterministic.

        Returns:
            action (3) or (N, 3), within [-1, 1], and the state for the next call.

        Raises:
            ShapeError: an observation of another size, for instance behind a wrapper that changes it.
            InvalidValueError: an observation that is a dictionary.
        """
        if isinstance(observation, dict):
            raise InvalidValueError("observation", sorted(observation), "a flat array, not a dictionary")
        torque = self.torque(self.interface.layout.split(observation))
        action = np.clip(torque / self.interface.torque_limit, -1.0, 1.0)
        return action.astype(np.float32), state


class ModelBaseline(Baseline[ModelSettingsT]):
    """A control law that computes with a model of the arm, `self.arm`.

    Args:
        interface: what the law may know of the environment.
        settings: the law's numbers, the model among them.
    """

    def __init__(self, interface: ControlInterface, settings: ModelSettingsT) -> None:
        super().__init__(interface, settings)
        self.arm = PRPArm(settings.model)
