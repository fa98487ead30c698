"""`Baseline`: a classical controller as a policy with Stable-Baselines3's `predict` protocol."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.base.control_interface import ControlInterface, Model
from prp_gym.baselines.base.described import DescribedController, Origin
from prp_gym.baselines.base.references import (
    OFFSET_FIELDS,
    REFERENCE_FIELDS,
    JointReferences,
    MovedReferences,
    PoseReferences,
    References,
)
from prp_gym.baselines.base.settings import Settings
from prp_gym.errors import InvalidValueError, MissingFieldError
from prp_gym.evaluation.policy_state import PolicyState, state_to_begin_with
from prp_gym.robot.arrays import Array, anywhere
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import ObservationLayout

ControllerState = tuple[Array, ...]
Observed = Mapping[str, Array]


SettingsT = TypeVar("SettingsT", bound=Settings)


class Baseline(DescribedController[SettingsT], ABC, Generic[SettingsT]):
    """A controller of one environment, or of many of them at once.

    The state of a stateful controller (integrals, estimates) is a tuple of arrays with the leading dimensions
    of the observations; the caller keeps it, as that of a recurrent policy.

    Args:
        interface: what the controller may know of the environment.
        settings: settings of the controller.

    Attributes:
        measured_fields: names of the observation fields that the controller reads besides the reference.
        settings_class: class of the controller's settings.
        rendered: settings that take the task's target impedance, with gain sets declared to do so.
        integrators: indices of the state arrays that are held while an actuator is at its limit.
        batched: `predict` also takes several observations at once.
        slow_without_compiler: `predict` takes far longer on a machine without compiled code, so that commands
            which run all controllers leave this one out there.
        compiled: `predict` does what `act` does, which may be compiled; not of a class with its own.
        settings: settings of the controller, every vector at its full length.
        model: robot model that the controller uses.
        references: desired motion, in joint or operational space.

    Raises:
        MissingFieldError: the environment does not observe what the controller reads.
        ShapeError: a setting of another length.
        InvalidValueError: a model of another robot.
    """

    measured_fields: ClassVar[tuple[str, ...]]
    settings_class: ClassVar[type[Settings]]
    rendered: ClassVar[tuple[str, ...]] = ()
    integrators: ClassVar[tuple[int, ...]] = ()
    batched: ClassVar[bool] = True
    slow_without_compiler: ClassVar[bool] = False
    compiled: ClassVar[bool] = True

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.predict is not Baseline.predict:
            cls.compiled = False

    def __init__(self, interface: ControlInterface, settings: SettingsT) -> None:
        missing = self.missing_fields(interface.layout)
        if missing:
            raise MissingFieldError(type(self).__name__, missing, interface.layout.names)
        self.interface = interface
        self.model = interface.model_with(settings.model)
        parameters = len(self.model.parameter_vector())
        sizes = {"joint": self.model.joint_count, "pose": 6, "parameter": parameters}
        self.settings = settings.sized(sizes)
        self.references = _references(interface.layout, self.model)
        self.origin = Origin(type(self).__name__)

    @classmethod
    def missing_fields(cls, layout: ObservationLayout) -> list[str]:
        """Fields that the controller reads and a layout does not have."""
        missing = [name for name in cls.measured_fields if name not in layout.names]
        if not any(set(fields) <= set(layout.names) for fields in REFERENCE_FIELDS):
            missing.append(" or ".join(fields[0] for fields in REFERENCE_FIELDS))
        return missing

    def initial_state(self, observed: Observed) -> ControllerState:
        """The state at the start of an episode.

        Args:
            observed: fields by name, each (..., size).

        Returns:
            arrays (..., any size); an empty tuple for a stateless controller.
        """
        return ()

    @abstractmethod
    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """The control law.

        Args:
            observed: fields by name, each (..., size), in the units of their declaration.
            state: state from `initial_state` or from the last call.

        Returns:
            (..., joints) joint torques, unlimited [N m, N, N m], and the state a period later if they
            are applied as they are.
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
            state: state that the last call returned; None at first.
            episode_start: (N) whether an episode starts with this observation; there the state starts anew.
            deterministic: has no effect, since the controllers are deterministic.

        Returns:
            action (joints) or (N, joints), within [-1, 1], and the state for the next call, None for a
            stateless controller.

        Raises:
            ShapeError: an observation of another size, for instance behind a wrapper that changes it;
                a state of another controller or number of environments; an `episode_start` of another number.
            InvalidValueError: an observation that is a dictionary or holds no numbers or huge ones; a state
                or an `episode_start` of another kind.
            NonFiniteError: NaN or infinity in the observation or the state.
        """
        if isinstance(observation, dict):
            raise InvalidValueError("observation", sorted(observation), "a flat array, not a dictionary")
        layout = self.interface.layout
        observed = layout.split(layout.checked(observation))
        action, after = self.act(observed, self._begin(observed, state, episode_start))
        return action, after or None

    def act(self, observed: Observed, state: ControllerState) -> tuple[NDArray[np.float32], ControllerState]:
        """The action of one period, and the state a period later with the integrators held at a limit.

        Args:
            observed: fields by name, each (..., size), in the units of their declaration.
            state: state from `initial_state` or from the last call.

        Returns:
            (..., joints) within [-1, 1], and the state for the next call.
        """
        torque, after = self.control(observed, state)
        demand = torque / self.interface.torque_limit
        action = np.clip(demand, -1.0, 1.0)
        if after and self.integrators:
            after = self._hold(state, after, np.logical_or.reduce(action != demand, axis=-1))
        return action.astype(np.float32), after

    def _begin(
        self, observed: Observed, state: PolicyState, episode_start: NDArray[Any] | None
    ) -> ControllerState:
        """The state for this period: the given one, replaced by a new one where an episode starts."""
        lead = observed["joint_position"].shape[:-1]
        fresh = self.initial_state(observed)
        return state_to_begin_with(fresh, state, episode_start, lead)

    def _hold(
        self, before: ControllerState, after: ControllerState, limited: NDArray[np.bool_]
    ) -> ControllerState:
        """Hold the integrators where an actuator is at its limit (anti-windup)."""
        if not anywhere(limited):
            return after
        return tuple(
            np.where(limited[..., None], old, new) if index in self.integrators else new
            for index, (old, new) in enumerate(zip(before, after, strict=True))
        )


class StaticBaseline(Baseline[SettingsT]):
    """A stateless controller."""

    @abstractmethod
    def torque(self, observed: Observed) -> Array:
        """The control law.

        Args:
            observed: fields by name, each (..., size), in the units of their declaration.

        Returns:
            (..., joints) joint torques, unlimited [N m, N, N m].
        """

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See `Baseline.control`."""
        return self.torque(observed), state


_JOINT_REFERENCES = JointReferences()
"""Shared, since it holds nothing: controllers with equal parts are seen to be of equal structure."""


def _references(layout: ObservationLayout, model: Model) -> References:
    given: References
    if REFERENCE_FIELDS[0][0] in layout.names or isinstance(model, Link):
        given = _JOINT_REFERENCES
    else:
        given = PoseReferences(model)
    return MovedReferences(given) if set(OFFSET_FIELDS) & set(layout.names) else given
