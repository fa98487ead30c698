"""Scenarios: how far the world departs from the ideal, as data."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array

SCENARIOS = ("report", "randomized", "realistic")


@dataclass(frozen=True)
class Range:
    """A box from which vectors are drawn; nested lists of a data file are laid end to end.

    Attributes:
        low: lower corner.
        high: upper corner.
        logarithmic: whether the logarithms are uniform, rather than the values.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    logarithmic: bool = False

    @cached_property
    def _corners(self) -> tuple[Array, Array]:
        corners = np.array(self.low), np.array(self.high)
        return (np.log(corners[0]), np.log(corners[1])) if self.logarithmic else corners

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "Range":
        """A range as it stands in a data file."""
        low, high = (tuple(np.ravel(table[name]).tolist()) for name in ("low", "high"))
        return cls(low, high, bool(table.get("logarithmic", False)))

    def draw(self, rng: np.random.Generator) -> Array:
        """One vector."""
        drawn = rng.uniform(*self._corners)
        return np.exp(drawn) if self.logarithmic else drawn


@dataclass(frozen=True, eq=False)
class PlantDraw:
    """How one episode's plant differs from the nominal arm.

    Attributes:
        mass_factor: (3).
        viscous_friction: (3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: (3) [N m, N, N m].
    """

    mass_factor: Array
    viscous_friction: Array
    coulomb_friction: Array


@dataclass(frozen=True)
class Scenario:
    """The conditions under which a task is played.

    Attributes:
        name: one of `SCENARIOS`.
        description: one sentence for the documentation.
        deterministic: whether every episode is the same.
        draws: the name of the task's ranges from which starts and goals are drawn.
        joint_stops: whether the joints stop at their limits.
        torque_limit_factor: actuator limits, relative to the nominal ones.
        mass_factor: factors on link masses (3).
        viscous_friction: F_v (3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: F_s (3) [N m, N, N m].
        torque_noise: standard deviation of white noise on the torques, a share of the nominal limits.
        delay_steps: control periods by which the torques come late.
        force_noise: standard deviation of white noise on each axis of the force sensor [N].
        force_bias: largest constant error of each axis of the force sensor [N].
    """

    name: str
    description: str
    deterministic: bool
    draws: str
    joint_stops: bool
    torque_limit_factor: float
    mass_factor: Range
    viscous_friction: Range
    coulomb_friction: Range
    torque_noise: float
    delay_steps: int
    force_noise: float
    force_bias: float

    @classmethod
    def from_table(cls, name: str, table: Mapping[str, Any]) -> "Scenario":
        """A scenario as it stands in a data file."""
        return cls(
            name=name,
            description=str(table["description"]),
            deterministic=bool(table["deterministic"]),
            draws=str(table["draws"]),
            joint_stops=bool(table["joint_stops"]),
            torque_limit_factor=float(table["torque_limit_factor"]),
            mass_factor=Range.from_table(table["mass_factor"]),
            viscous_friction=Range.from_table(table["viscous_friction"]),
            coulomb_friction=Range.from_table(table["coulomb_friction"]),
            torque_noise=float(table["torque_noise"]),
            delay_steps=int(table["delay_steps"]),
            force_noise=float(table["force_noise"]),
            force_bias=float(table["force_bias"]),
        )

    @property
    def ideal_plant(self) -> bool:
        """Whether the plant is the nominal arm in every episode."""
        unit = self.mass_factor.low == self.mass_factor.high == (1.0, 1.0, 1.0)
        return unit and not any(self.viscous_friction.high) and not any(self.coulomb_friction.high)

    def draw_plant(self, rng: np.random.Generator) -> PlantDraw:
        """One episode's plant."""
        return PlantDraw(
            self.mass_factor.draw(rng), self.viscous_friction.draw(rng), self.coulomb_friction.draw(rng)
        )
