"""`CompiledLoop`: what an episode loop leaves to compiled code, and takes back where its state is saved."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from prp_gym.envs.base.error_observation import ErrorObservation
from prp_gym.envs.core.compiled_run import CompiledPeriods
from prp_gym.envs.core.loop_state import STATE, LoopState
from prp_gym.envs.core.period_parts import PeriodParts
from prp_gym.envs.core.single_period import LOST, SingleStep
from prp_gym.envs.core.step import Step
from prp_gym.errors import CompilerError, EpisodeError, UntraceableError
from prp_gym.physics.abstract_simulation import Simulation
from prp_gym.robot.arrays import Array


def ignore(_: Step) -> None:
    """The listener of a loop without one."""


class CompiledLoop(ABC):
    """The periods of N environments in compiled code, where there is any, and their states.

    Attributes:
        physics: Simulations of the environments.
        state_names: Attributes that make up the state of the loop.
    """

    state_names: ClassVar[tuple[str, ...]] = STATE
    physics: Simulation
    _compiled: CompiledPeriods | None = None
    _may_compile: bool
    _errors: ErrorObservation | None
    _space: Box
    _needs_reset: NDArray[np.bool_]
    _all_ready: bool
    _on_period: Callable[[Step], None] = staticmethod(ignore)

    @abstractmethod
    def judge(self, command: Array, saturated: NDArray[np.bool_] | None) -> Step:
        """The result of a period that the physics has simulated, computed by NumPy.

        Args:
            command: Commanded torques (N, joints) [N m, N, N m].
            saturated: Which actions were at or beyond the actuator limits (N, joints); None if none was.
        """

    @abstractmethod
    def period_parts(self) -> PeriodParts:
        """The parts whose formulas make up a control period, besides the physics."""

    @property
    @abstractmethod
    def started(self) -> bool:
        """Whether every environment has been reset at least once."""

    @abstractmethod
    def _restored(self) -> Array:
        """The observations (N, size) after a state was restored."""

    def present_parts(self) -> PeriodParts:
        """See `period_parts`, with what the parts keep at present, which compiled code may hold."""
        self._store()
        return self.period_parts()

    def load(self) -> None:
        """Let compiled code go on from the present state, with the compiled engine."""
        if not self._may_compile:
            return
        try:
            self._compiled = self._compiled or CompiledPeriods(self)
            self._compiled.load()
        except (UntraceableError, CompilerError):  # a task of another package, which NumPy computes
            self._compiled, self._may_compile = None, False

    def _begin_compiled(self, ids: NDArray[np.intp]) -> bool:
        """Let compiled code begin new episodes in some environments; whether it has done so."""
        try:
            return self._compiled is not None and self._compiled.begin(ids)
        except UntraceableError:
            self._compiled, self._may_compile = None, False
            return False

    def _store(self) -> None:
        """Let the loop's parts know what compiled code has kept."""
        if self._compiled is not None:
            self._compiled.store()

    def step_alone(self, action: NDArray[Any]) -> SingleStep | None:
        """Advance a single environment by one control period, if compiled code can do so in one call.

        Args:
            action: Action (joints), numbers of any kind.

        Returns:
            The results, as those of `step`; None where `step` has to be called: nothing has changed then.
        """
        periods = self._compiled
        if periods is None or periods.single is None or not self._all_ready:
            return None
        if self.has_listener or self._errors is not None:
            return None
        flags = periods.single.advance(action)
        if not flags & LOST:
            return periods.single.results(flags) if flags else None
        if periods.simulates:
            outcome = self._watched(periods.last_outcome())
        else:
            periods.store()
            outcome = self.judge(*periods.commanded())
        observation, reward, terminated, truncated, info = outcome
        return observation[0], reward.item(), terminated.item(), truncated.item(), info[0]

    def _watched(self, outcome: Step) -> Step:
        """The result of a period of compiled code; environments that diverged in it wait for a reset."""
        self._stop(outcome.terminated)
        if not self._all_ready:
            outcome.truncated[outcome.terminated] = False
            which = self._needs_reset
            outcome.observation[which] = np.clip(
                outcome.observation[which], self._space.low, self._space.high
            )
        self._on_period(outcome)
        return outcome

    def _stop(self, diverged: NDArray[np.bool_]) -> None:
        """Have environments (a mask of N) that left the declared bounds wait for a reset."""
        if np.count_nonzero(diverged):
            self._needs_reset |= diverged
            self._all_ready = False

    def require_ready(self, idle: NDArray[np.bool_]) -> None:
        """Refuse to step environments that need a reset, except those that only wait for it.

        Args:
            idle: Mask (N) of environments that only wait for their reset.

        Raises:
            EpisodeError: one of the others was never reset, or has diverged.
        """
        stuck = np.flatnonzero(self._needs_reset & ~idle).tolist()
        if stuck:
            raise EpisodeError(
                f"environments {stuck} cannot be stepped: never reset, or diverged; call reset first."
            )

    def listen(self, listener: Callable[[Step], None] | None) -> None:
        """Call a listener with the result of every control period; None removes the listener."""
        self._on_period = listener or ignore

    @property
    def has_listener(self) -> bool:
        """Whether a listener is called with the result of every control period."""
        return self._on_period is not ignore

    def get_state(self) -> LoopState:
        """A copy of the complete state of the environments."""
        return copy.deepcopy(self.current_state())

    def set_state(self, state: LoopState) -> Array:
        """Restore a state of this loop or of one made with the same keywords.

        Returns:
            Observations (N, size).

        Raises:
            InvalidValueError: a state of another number of environments.
        """
        rest = copy.deepcopy(state.rest)
        self.physics.restore(state.physics)
        self.__dict__.update(rest)
        self._compiled = None  # whose numbers may be those of another task
        self.load()
        return self._restored()

    def current_state(self) -> LoopState:
        """The complete state of the environments, whose arrays change with them."""
        self._store()
        return LoopState(self.physics.snapshot(), {name: getattr(self, name) for name in self.state_names})

    def __getstate__(self) -> dict[str, Any]:
        self._store()
        return {**self.__dict__, "_compiled": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if self.started:
            self.load()
