"""The world: the MuJoCo model, its elastic surface, and simulations of it."""

from prp_gym.physics.mjcf import CAMERAS, TIP_RADIUS, PhysicsSettings, to_mjcf
from prp_gym.physics.simulation import MEASUREMENT_SIZE, Physics, PhysicsState
from prp_gym.physics.surface import Surface

__all__ = [
    "CAMERAS",
    "MEASUREMENT_SIZE",
    "TIP_RADIUS",
    "Physics",
    "PhysicsSettings",
    "PhysicsState",
    "Surface",
    "to_mjcf",
]
