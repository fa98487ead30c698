"""What differs between the simulations of a batch: the fields of the model with a value for each."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array

Ids = NDArray[np.intp]


def check_rows(what: str, values: Array, shape: tuple[int, ...]) -> None:
    """Refuse an array of another shape.

    Raises:
        ShapeError: another shape.
    """
    if np.shape(values) != shape:
        raise ShapeError(what, np.shape(values), f"{shape}")


def check_positive(what: str, values: Array, shape: tuple[int, ...], unit: str = "") -> None:
    """Refuse an array of another shape or with a value that is not above 0 and finite.

    Raises:
        ShapeError: another shape.
        InvalidValueError: such a value.
    """
    check_rows(what, values, shape)
    _check_range(what, values, np.asarray(values) > 0.0, "above 0 and finite", unit)


def check_not_negative(what: str, values: Array, shape: tuple[int, ...], unit: str = "") -> None:
    """Refuse an array of another shape or with a value that is negative or not finite.

    Raises:
        ShapeError: another shape.
        InvalidValueError: such a value.
    """
    check_rows(what, values, shape)
    _check_range(what, values, np.asarray(values) >= 0.0, "at least 0 and finite", unit)


def _check_range(what: str, values: Array, within: NDArray[np.bool_], allowed: str, unit: str) -> None:
    good = np.isfinite(values) & within
    if not good.all():
        raise InvalidValueError(what, float(np.asarray(values)[~good][0]), allowed, unit)


class ModelFields:
    """Fields of the model with a value a simulation; the rest is shared.

    Args:
        batch: whose fields these are.

    Attributes:
        names: of the fields that may differ.
    """

    names: ClassVar[tuple[str, ...]]

    def __init__(self, batch: Batch) -> None:
        self._batch = batch

    def copy(self) -> dict[str, Array]:
        """The values of all fields that differ, by name."""
        fields = {name: self._batch.expanded(name) for name in self.names}
        return {name: np.array(values) for name, values in fields.items() if values is not None}

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Go back to what `copy` gave, shared fields to the model's values."""
        for name in self.names:
            if name in kept:
                self._batch.expand(name)[:] = kept[name]
            elif self._batch.expanded(name) is not None:
                self._batch.expand(name)[:] = getattr(self._batch.model, name)
        if self._batch.expanded("body_mass") is not None:
            self._batch.set_const()
