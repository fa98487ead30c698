"""The engines that simulate a world: MuJoCo, the reference, and the compiled closed form."""

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.physics.abstract_simulation import ArmSimulation, LinkSimulation, Simulation
from prp_gym.physics.compiled_arm import CompiledArm
from prp_gym.physics.compiled_link import CompiledLink
from prp_gym.physics.compiled_simulation import CompiledSimulation
from prp_gym.physics.link_simulation import LinkPhysics
from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.physics.simulation import Physics
from prp_gym.robot.link import NOMINAL_LINK
from prp_gym.robot.parameters import NOMINAL
from prp_gym.tasks.setup import COMPILED


def make_arm(engine: str, settings: PhysicsSettings, num_simulations: int, num_threads: int) -> ArmSimulation:
    """Simulations of the nominal arm.

    Args:
        engine: `mujoco` or `compiled`.
        settings: settings of the world.
        num_simulations: number of simulations.
        num_threads: number of worker threads; 0 uses all cores.

    Raises:
        CompilerError: the engine `compiled` on a machine with neither the compiled code nor a compiler.
    """
    if engine == COMPILED:
        return CompiledArm(settings, num_simulations, num_threads)
    return Physics(NOMINAL, settings, num_simulations, num_threads)


def make_link(engine: str, timestep: float, num_simulations: int, num_threads: int) -> LinkSimulation:
    """Simulations of the nominal link; see `make_arm`.

    Args:
        engine: `mujoco` or `compiled`.
        timestep: time step of the integration [s].
        num_simulations: number of simulations.
        num_threads: number of worker threads; 0 uses all cores.
    """
    if engine == COMPILED:
        return CompiledLink(timestep, num_simulations, num_threads)
    return LinkPhysics(NOMINAL_LINK, timestep, num_simulations, num_threads)


def in_closed_form(physics: Simulation, simulation: int = 0) -> CompiledSimulation:
    """One simulation of either engine in closed form, in the same state and with the same torques.

    Args:
        physics: simulations.
        simulation: index of one of them.

    Returns:
        one simulation, which is a copy.

    Raises:
        InvalidValueError: what the closed form lacks: surface friction, another robot than the nominal ones.
        CompilerError: this machine has neither the compiled code nor a compiler.
    """
    row, one = np.zeros(1, dtype=np.intp), slice(simulation, simulation + 1)
    if isinstance(physics, ArmSimulation):
        made = _arm_in_closed_form(physics, simulation)
    elif isinstance(physics, LinkSimulation):
        made = CompiledLink(physics.timestep)
        made.set_parameters(row, *physics.parameters_of(simulation))
    else:
        raise InvalidValueError("physics", type(physics).__name__, "a simulation of the arm or of the link")
    made.reset(row, physics.joint_position[one], physics.joint_velocity[one])
    made.set_torque(physics.torque[one])
    made.advance(0)
    return made


def _arm_in_closed_form(physics: ArmSimulation, simulation: int) -> CompiledSimulation:
    """The masses, friction and surface of an arm in closed form."""
    if physics.parameters != NOMINAL:
        raise InvalidValueError("parameters of the arm", physics.parameters, "the nominal ones")
    row, made = np.zeros(1, dtype=np.intp), CompiledArm(physics.settings)
    made.set_dynamics(row, *physics.dynamics(simulation))
    if physics.settings.surface and physics.has_surface(simulation):
        made.set_surface(row, physics.surface(simulation))
    return made
