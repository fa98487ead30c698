"""Scenarios: how far the world departs from the ideal, as data."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array

Range3 = tuple[float, float, float]

SCENARIOS = ("report", "randomized", "realistic")


@dataclass(frozen=True)
class Range:
    """A box from which vectors are drawn uniformly; nested lists of a data file are laid end to end.

    Attributes:
        low: lower corner.
        high: upper corner.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]

    @cached_property
    def _corners(self) -> tuple[Array, Array]:
        return np.array(self.low), np.array(self.high)

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "Range":
        """A range as it stands in a data file."""
        return cls(tuple(np.ravel(table["low"]).tolist()), tuple(np.ravel(table["high"]).tolist()))

    def draw(self, rng: np.random.Generator) -> Array:
        """One vector."""
        return rng.uniform(*self._corners)


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
        torque_noise: standard deviation (3) of white noise on the torques [N m, N, N m].
        delay_steps: control periods by which the torques come late.
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
    torque_noise: Range3
    delay_steps: int

    @classmethod
    def from_table(cls, name: str, table: Mapping[str, Any]) -> "Scenario":
        """A scenario as it stands in a data file."""
        noise = tuple(map(float, table["torque_noise"]))
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
            torque_noise=(noise[0], noise[1], noise[2]),
            delay_steps=int(table["delay_steps"]),
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
