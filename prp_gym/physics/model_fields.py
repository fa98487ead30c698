"""Model fields that may differ between the simulations of a batch."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError
from prp_gym.robot.arrays import Array

Ids = NDArray[np.intp]


def check_rows(what: str, values: Array, shape: tuple[int, ...]) -> None:
    """Check the shape of an array.

    Raises:
        ShapeError: the array has another shape.
    """
    if np.shape(values) != shape:
        raise ShapeError(what, np.shape(values), f"{shape}")


def check_states(shape: tuple[int, int], joint_position: Array, joint_velocity: Array) -> None:
    """Check what `Simulation.reset` takes.

    Raises:
        ShapeError: an array of another shape.
        NonFiniteError: NaN or infinity.
    """
    for what, values in (("joint_position", joint_position), ("joint_velocity", joint_velocity)):
        check_rows(what, values, shape)
        if np.count_nonzero(np.isfinite(values)) < np.size(values):
            raise NonFiniteError(what, np.asarray(values).tolist())


def rows_of(ids: Ids, count: int) -> slice | Ids:
    """The index of some simulations among `count`; that of all in order is a slice, which is faster."""
    if len(ids) != count or ids[0] != 0 or ids[-1] != count - 1:
        return ids
    rising = count < 3 or np.count_nonzero(ids[1:] > ids[:-1]) == count - 1
    return slice(None) if rising else ids


def check_positive(what: str, values: Array, shape: tuple[int, ...], unit: str = "") -> None:
    """Check that an array has a shape and that its values are above 0 and finite.

    Raises:
        ShapeError: the array has another shape.
        InvalidValueError: a value is outside this range.
    """
    check_rows(what, values, shape)
    _check_range(what, values, np.asarray(values) > 0.0, "above 0 and finite", unit)


def check_not_negative(what: str, values: Array, shape: tuple[int, ...], unit: str = "") -> None:
    """Check that an array has a shape and that its values are at least 0 and finite.

    Raises:
        ShapeError: the array has another shape.
        InvalidValueError: a value is outside this range.
    """
    check_rows(what, values, shape)
    _check_range(what, values, np.asarray(values) >= 0.0, "at least 0 and finite", unit)


def check_dynamics(ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array) -> None:
    """Check what `ArmSimulation.set_dynamics` takes; see there."""
    shape = (len(ids), 3)
    check_positive("mass_factor", mass_factor, shape)
    check_not_negative("viscous_friction", viscous_friction, shape)
    check_not_negative("coulomb_friction", coulomb_friction, shape)


def check_link(ids: Ids, inertia: Array, viscous_friction: Array, gravity_moment: Array) -> None:
    """Check what `LinkSimulation.set_parameters` takes; see there."""
    shape = (len(ids),)
    check_positive("inertia", inertia, shape, "kg·m²")
    check_not_negative("viscous_friction", viscous_friction, shape, "N·m·s/rad")
    check_not_negative("gravity_moment", gravity_moment, shape, "N·m")


def _check_range(what: str, values: Array, within: NDArray[np.bool_], allowed: str, unit: str) -> None:
    good = np.isfinite(values) & within
    if np.count_nonzero(good) < good.size:
        raise InvalidValueError(what, float(np.asarray(values)[~good][0]), allowed, unit)


class ModelFields:
    """Model fields that have a value for each simulation; all other fields are shared.

    Args:
        batch: Batch of simulations whose fields these are, also as an attribute.

    Attributes:
        names: Names of the fields that may differ.
    """

    names: ClassVar[tuple[str, ...]]

    def __init__(self, batch: Batch) -> None:
        self.batch = batch

    def value(self, name: str, simulation: int) -> Array:
        """A copy of the field of one simulation."""
        own = self.batch.expanded(name)
        return np.array(getattr(self.batch.model, name) if own is None else own[simulation])

    def copy(self) -> dict[str, Array]:
        """Values of all fields that differ, by name."""
        fields = {name: self.batch.expanded(name) for name in self.names}
        return {name: np.array(values) for name, values in fields.items() if values is not None}

    def restore(self, kept: Mapping[str, Array]) -> None:
        """Restore the values that `copy` returned; shared fields get the model's values."""
        for name in self.names:
            if name in kept:
                self.batch.expand(name)[:] = kept[name]
            elif self.batch.expanded(name) is not None:
                self.batch.expand(name)[:] = getattr(self.batch.model, name)
        if self.batch.expanded("body_mass") is not None:
            self.batch.set_const()
