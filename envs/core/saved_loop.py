"""`SavedLoop`: how the state of an episode loop is saved, restored and pickled."""

import copy
from abc import abstractmethod
from typing import Any, ClassVar

from prp_gym.envs.core.compiled_loop import CompiledLoop
from prp_gym.envs.core.loop_state import STATE, LoopState
from prp_gym.physics.abstract_simulation import Simulation
from prp_gym.robot.arrays import Array


class SavedLoop(CompiledLoop):
    """The states of N environments; a base of `EpisodeLoop`.

    Attributes:
        physics: Simulations of the environments.
        state_names: Attributes that make up the state of the loop.
    """

    state_names: ClassVar[tuple[str, ...]] = STATE
    physics: Simulation

    @property
    @abstractmethod
    def started(self) -> bool:
        """Whether every environment has been reset at least once."""

    @abstractmethod
    def _restored(self) -> Array:
        """The observations (N, size) after a state was restored."""

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
