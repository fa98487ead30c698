"""MuJoCo models of the arm and the link, the elastic surface, and simulations of them."""

from prp_gym.physics.abstract_simulation import ArmSimulation, PhysicsState, Simulation
from prp_gym.physics.link_mjcf import link_to_mjcf
from prp_gym.physics.link_simulation import LinkPhysics
from prp_gym.physics.mjcf import TIP_RADIUS, PhysicsSettings, to_mjcf
from prp_gym.physics.scene import CAMERAS
from prp_gym.physics.simulation import MEASUREMENT_SIZE, Physics
from prp_gym.physics.surface import Surface

__all__ = [
    "CAMERAS",
    "MEASUREMENT_SIZE",
    "TIP_RADIUS",
    "ArmSimulation",
    "LinkPhysics",
    "Physics",
    "PhysicsSettings",
    "PhysicsState",
    "Simulation",
    "Surface",
    "link_to_mjcf",
    "to_mjcf",
]
