"""Scenarios: how much the conditions of an episode differ from the ideal ones, as data."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array, elementwise

SCENARIOS = ("report", "randomized", "realistic")


@dataclass(frozen=True)
class Range:
    """A box from which vectors are drawn uniformly; nested lists of a data file are flattened.

    Attributes:
        low: Lower corner of the box.
        high: Upper corner of the box.
        logarithmic: Whether the logarithms of the values are uniformly distributed, instead of the values.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    logarithmic: bool = False

    @cached_property
    def _corners(self) -> tuple[Array, Array]:
        low, high = np.array(self.low), np.array(self.high)
        return (elementwise(math.log, low), elementwise(math.log, high)) if self.logarithmic else (low, high)

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "Range":
        """Make a range from a table of a data file."""
        low, high = (tuple(np.ravel(table[name]).tolist()) for name in ("low", "high"))
        return cls(low, high, bool(table.get("logarithmic", False)))

    def draw(self, rng: np.random.Generator) -> Array:
        """Draw one vector."""
        drawn = rng.uniform(*self._corners)
        return elementwise(math.exp, drawn) if self.logarithmic else drawn


@dataclass(frozen=True, eq=False)
class PlantDraw:
    """How one episode's plant differs from the nominal arm.

    Attributes:
        mass_factor: Factors on the link masses (3).
        viscous_friction: Viscous friction F_v of the joints (3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: Coulomb friction F_s of the joints (3) [N m, N, N m].
    """

    mass_factor: Array
    viscous_friction: Array
    coulomb_friction: Array


@dataclass(frozen=True)
class Scenario:
    """The conditions of the episodes of a task.

    Attributes:
        name: Name of the scenario, one of `SCENARIOS`.
        description: Description for the documentation.
        deterministic: Whether every episode is the same.
        draws: Name of the task's ranges from which starts and goals are drawn.
        joint_stops: Whether the joints stop at their limits.
        torque_limit_factor: Ratio of the actuator limits to the nominal ones.
        mass_factor: Range of the factors on the link masses (3).
        viscous_friction: Range of the viscous friction F_v (3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: Range of the Coulomb friction F_s (3) [N m, N, N m].
        torque_noise: Standard deviation of white noise on the torques, as a fraction of the nominal limits.
        delay_steps: Actuation delay in control periods.
        force_noise: Standard deviation of white noise on each axis of the force sensor [N].
        force_bias: Largest bias of each axis of the force sensor [N].
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
        """Make a scenario from a table of a data file."""
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
        """Draw the plant of one episode."""
        return PlantDraw(
            self.mass_factor.draw(rng), self.viscous_friction.draw(rng), self.coulomb_friction.draw(rng)
        )
