"""Saved states of environments, and the checks that a damaged one does not pass."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import check_finite
from prp_gym.envs.config import EnvConfig
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.core.loop_state import LoopState
from prp_gym.envs.vector_info import Mask
from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError
from prp_gym.physics.abstract_simulation import PhysicsState
from prp_gym.robot.arrays import Array

_WHAT, _MEMORY, _ROWS = "saved state", "_memory", "_rows"


class EnvState(NamedTuple):
    """The saved state of environments; see `PRPEnv.get_state`."""

    loop: LoopState
    config: EnvConfig
    options: object
    generators: tuple[Mapping[str, Any], ...]


class VectorState(NamedTuple):
    """The saved state of environments, and which of them wait for their reset; see `get_state`."""

    environments: EnvState
    ended: Mask


def check_parts(state: EnvState) -> None:
    """Refuse a state whose parts are of other kinds than those of any saved state.

    Raises:
        InvalidValueError: a value that is not a saved state, or with a part of another kind.
    """
    if not isinstance(state, EnvState):
        allowed = "an EnvState, from get_state of such an environment"
        raise InvalidValueError(_WHAT, type(state).__name__, allowed)
    for name, part, kind in (
        ("loop", state.loop, LoopState),
        ("config", state.config, EnvConfig),
        ("generators", state.generators, tuple),
    ):
        _require_kind(f"{_WHAT}'s {name}", part, kind)
    _require_kind(f"{_WHAT}'s physics", state.loop.physics, PhysicsState)
    _require_kind(f"{_WHAT}'s episodes", state.loop.rest, dict)


def is_equal(given: object, own: object) -> bool:
    """Whether two values are equal; those that cannot be compared are not."""
    try:
        return bool(given == own)
    except Exception:  # the comparison of arrays, or of damaged objects
        return False


def check_like(state: LoopState, loop: EpisodeLoop) -> None:
    """Refuse a state that a loop with the same keywords cannot have.

    Args:
        state: state of a loop, with parts of the right kinds.
        loop: loop in which it is to be restored.

    Raises:
        InvalidValueError: parts that differ from those of the loop in kind or in number, or episodes at
            impossible times.
        ShapeError: arrays of another shape.
        NonFiniteError: NaN or infinity where the loop has numbers.
    """
    own = loop.current_state()
    fields, own_fields = state.physics.model_fields, own.physics.model_fields
    _require_kind(f"{_WHAT}'s model fields", fields, dict)
    common = {name: own_fields.get(name, value) for name, value in fields.items()}
    physics = own.physics._replace(model_fields=common)
    _Comparison().compare(_WHAT, state, LoopState(physics, own.rest))
    state.rest["_window"].check_times(loop.config.horizon)


def restore_loop(state: LoopState, loop: EpisodeLoop) -> Array:
    """Restore the state of a loop, or leave the loop as it is.

    Returns:
        Observations (N, size).

    Raises:
        InvalidValueError: a damaged state; nothing is changed.
    """
    before = loop.current_state()
    try:
        observation = loop.set_state(state)
        check_finite("observation", observation)
    except Exception as error:  # whatever the parts of a damaged state raise
        loop.physics.restore(before.physics)
        vars(loop).update(before.rest)
        loop.load()
        raise InvalidValueError(_WHAT, str(error), "one that is not damaged") from error
    return observation


def check_generators(states: object, generators: tuple[np.random.Generator, ...]) -> None:
    """Refuse states that the generators of the environments cannot have.

    Raises:
        InvalidValueError: another number of states, or one of another kind of generator.
    """
    if not isinstance(states, tuple) or len(states) != len(generators):
        raise InvalidValueError(f"{_WHAT}'s generators", states, f"the states of {len(generators)}")
    for state, generator in zip(states, generators, strict=True):
        kind = type(generator.bit_generator)
        try:
            kind(0).state = dict(state)
        except Exception as error:  # NumPy raises errors of several kinds
            allowed = f"a state of a {kind.__name__}"
            raise InvalidValueError(f"{_WHAT}'s generator", state, allowed) from error


class _Comparison:
    """The comparison of the parts of a state with those of a loop: kinds, shapes, and finite numbers."""

    def __init__(self) -> None:
        self._seen: set[int] = set()

    def compare(self, what: str, given: Any, own: Any) -> None:
        """Compare one part, and what it consists of.

        Raises:
            PRPError: see `check_like`.
        """
        if own is None or id(given) in self._seen:
            return
        if isinstance(own, np.ndarray):
            _compare_arrays(what, given, own)
            return
        _require_kind(what, given, type(own))
        if isinstance(own, float):
            if np.isfinite(own) and not np.isfinite(given):
                raise NonFiniteError(what, given)
        elif isinstance(own, np.random.Generator):
            _require_kind(f"{what}'s generator", given.bit_generator, type(own.bit_generator))
        elif isinstance(own, (tuple, list, dict)) or hasattr(own, "__dict__"):
            self._seen.add(id(given))
            self._compare_members(what, given, own)

    def _compare_members(self, what: str, given: Any, own: Any) -> None:
        mine, theirs = _members(own), _members(given)
        if set(mine) != set(theirs):
            raise InvalidValueError(f"parts of {what}", sorted(map(str, theirs)), f"{sorted(map(str, mine))}")
        for name, value in mine.items():
            if name == _MEMORY and theirs[name] is None:
                continue  # after a reset an action mode has none
            if name == _ROWS and isinstance(theirs[name], np.ndarray) and len(value):
                value = np.broadcast_to(value[:1], (len(theirs[name]), *value.shape[1:]))  # of any number
            self.compare(f"{what}'s {str(name).strip('_')}", theirs[name], value)


def _members(value: Any) -> Mapping[Any, Any]:
    """The parts of a value by name or position; none of a class or a function."""
    if isinstance(value, dict):
        return value
    if isinstance(value, (tuple, list)):
        return dict(enumerate(value))
    if isinstance(value, type) or callable(value):
        return {}
    kind = type(value)
    return {n: v for n, v in vars(value).items() if not isinstance(getattr(kind, n, None), cached_property)}


def _compare_arrays(what: str, given: Any, own: NDArray[Any]) -> None:
    """Refuse an array of another shape or type, or with NaN or infinity where the loop has numbers."""
    _require_kind(what, given, np.ndarray)
    if given.dtype != own.dtype:
        raise InvalidValueError(f"type of {what}", given.dtype.name, own.dtype.name)
    if own.size and given.shape != own.shape:
        raise ShapeError(what, given.shape, f"{own.shape}")
    if own.dtype.kind != "f" or np.isfinite(given).all():
        return
    if not own.size or (np.isfinite(own) & ~np.isfinite(given)).any():
        raise NonFiniteError(what, given)


def _require_kind(what: str, given: object, kind: type) -> None:
    if type(given) is not kind:
        raise InvalidValueError(what, given, f"of class {kind.__name__}")
