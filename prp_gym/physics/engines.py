"""The engines that simulate a world: MuJoCo, the reference, and the compiled closed form."""

from prp_gym.physics.abstract_simulation import ArmSimulation, LinkSimulation
from prp_gym.physics.compiled_arm import CompiledArm
from prp_gym.physics.compiled_link import CompiledLink
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
