"""`CompiledArm`: simulations of the arm in closed form, in code compiled from the formulas."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.physics.abstract_simulation import ArmSimulation
from prp_gym.physics.compiled_arm_source import TURNS_SIZE, arm_source
from prp_gym.physics.compiled_simulation import CompiledSimulation
from prp_gym.physics.derivatives_source import arm_derivatives_source
from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.physics.model_fields import Ids
from prp_gym.physics.plants import Plants
from prp_gym.physics.simulation import MEASUREMENT_SIZE, Physics
from prp_gym.physics.surface import Surface
from prp_gym.physics.surfaces import Surfaces
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import NOMINAL


class CompiledArm(CompiledSimulation, ArmSimulation):
    """N simulations of the nominal arm in closed form, with the columns and units of `Physics`.

    Args:
        settings: Settings of the world.
        num_simulations: Number of simulations N, at least 1.
        num_threads: Number of worker threads; 0 uses all cores.

    Raises:
        InvalidValueError: fewer than one simulation, or a surface with friction, which this engine lacks.
        CompilerError: this machine has neither the compiled code nor a compiler.
    """

    joint_count: ClassVar[int] = 3

    def __init__(
        self, settings: PhysicsSettings | None = None, num_simulations: int = 1, num_threads: int = 1
    ) -> None:
        self.settings = PhysicsSettings() if settings is None else settings
        if self.settings.surface_friction > 0.0:
            value = self.settings.surface_friction
            raise InvalidValueError("surface_friction", value, "0 with the compiled engine")
        self.parameters = NOMINAL
        size = MEASUREMENT_SIZE + (3 if self.settings.surface else 0)
        super().__init__(arm_source(self.settings.timestep), size, num_simulations, num_threads)
        self.world.stops, self.world.surface = self.settings.joint_stops, self.settings.surface
        self._turns = np.zeros((num_simulations, TURNS_SIZE))
        self.world.turns = self._turns.ctypes.data
        self._plants, self._surfaces = Plants(num_simulations, self._library), Surfaces(num_simulations)
        self._begin(self._plants.rows, self._surfaces.rows)

    @property
    def timestep(self) -> float:
        """See `Simulation.timestep`."""
        return self.settings.timestep

    @property
    def tip_position(self) -> Array:
        """See `Simulation.tip_position`."""
        return self._measured[:, 6:9]

    @property
    def tip_velocity(self) -> Array:
        """See `ArmSimulation.tip_velocity`."""
        return self._measured[:, 12:15]

    @property
    def contact_force(self) -> Array:
        """See `Simulation.contact_force`."""
        return self._measured[:, MEASUREMENT_SIZE:] if self.settings.surface else self._no_force

    def set_surface(self, ids: Ids, surface: Surface, center: Array | None = None) -> None:
        """See `ArmSimulation.set_surface`."""
        if not self.settings.surface:
            raise InvalidValueError("surface", "given", "nothing: this world was built without a surface")
        self._surfaces.set(ids, surface, center)

    def set_springs(self, ids: Ids, stiffness: Array, damping: Array) -> None:
        """See `ArmSimulation.set_springs`."""
        self._surfaces.set_springs(ids, stiffness, damping)

    def surface(self, simulation: int = 0) -> Surface:
        """See `ArmSimulation.surface`."""
        return self._surfaces.surface(simulation)

    def set_dynamics(
        self, ids: Ids, mass_factor: Array, viscous_friction: Array, coulomb_friction: Array
    ) -> None:
        """See `ArmSimulation.set_dynamics`."""
        self._plants.set(ids, mass_factor, viscous_friction, coulomb_friction)
        self.world.friction = self._plants.have_coulomb_friction

    def has_surface(self, simulation: int = 0) -> bool:
        """See `ArmSimulation.has_surface`."""
        return self._surfaces.is_set(simulation)

    def dynamics(self, simulation: int = 0) -> tuple[Array, Array, Array]:
        """See `ArmSimulation.dynamics`."""
        return self._plants.dynamics(simulation)

    @property
    def derivatives_source(self) -> str:
        """See `CompiledSimulation.derivatives_source`."""
        return arm_derivatives_source(self.settings.timestep)

    def in_mujoco(self, simulation: int) -> Physics:
        """See `CompiledSimulation.in_mujoco`."""
        physics, row = Physics(settings=self.settings), np.zeros(1, dtype=np.intp)
        physics.set_dynamics(row, *self.dynamics(simulation))
        if self.has_surface(simulation):
            physics.set_surface(row, self.surface(simulation), self._surfaces.center(simulation))
        one = slice(simulation, simulation + 1)
        physics.reset(row, self._position[one], self._velocity[one])
        physics.set_torque(self._torque[one])
        return physics

    def _fields(self) -> dict[str, Array]:
        return {**self._plants.copy(), **self._surfaces.copy()}

    def _restore_fields(self, kept: Mapping[str, Array]) -> None:
        self._plants.restore(kept)
        self._surfaces.restore(kept)
        self.world.friction = self._plants.have_coulomb_friction

    def _arguments(self) -> tuple[Any, ...]:
        return self.settings, self.num_simulations, self.num_threads
