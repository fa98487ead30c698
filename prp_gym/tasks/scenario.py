"""Scenarios: how much the conditions of an episode differ from the ideal ones, as data."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.tasks.ranges import Draws, Range

SCENARIOS = ("report", "randomized", "realistic")


@dataclass(frozen=True, eq=False)
class PlantDraw:
    """How the plants of n episodes differ from the nominal arm.

    Attributes:
        mass_factor: Factors on the link masses (n, 3).
        viscous_friction: Viscous friction F_v of the joints (n, 3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: Coulomb friction F_s of the joints (n, 3) [N m, N, N m].
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

    @cached_property
    def ideal_plant(self) -> bool:
        """Whether the plant is the nominal arm in every episode."""
        unit = self.mass_factor.low == self.mass_factor.high == (1.0, 1.0, 1.0)
        return unit and not any(self.viscous_friction.high) and not any(self.coulomb_friction.high)

    @cached_property
    def _plants(self) -> Draws:
        names = ("mass_factor", "viscous_friction", "coulomb_friction")
        return Draws({name: getattr(self, name) for name in names})

    def draw_plants(self, rngs: Sequence[np.random.Generator]) -> PlantDraw:
        """Draw the plants of n episodes, each with its own generator."""
        return PlantDraw(**self._plants.draw(rngs))
