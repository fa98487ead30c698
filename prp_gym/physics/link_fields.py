"""Model fields of the link that may differ between simulations: inertia, friction, gravity moment."""

from typing import ClassVar

from mujoco.batch import Batch

from prp_gym.physics.link_mjcf import PointMass, inertia_and_gravity, mass_distribution
from prp_gym.physics.model_fields import Ids, ModelFields, check_link
from prp_gym.robot.arrays import Array


class LinkFields(ModelFields):
    """Fields of the link's model that have a value for each simulation.

    Args:
        batch: Batch of simulations whose fields these are.
    """

    names: ClassVar[tuple[str, ...]] = ("body_mass", "body_inertia", "body_ipos", "dof_damping")

    def __init__(self, batch: Batch) -> None:
        super().__init__(batch)
        self._link = batch.model.body("link_1").id

    def set_parameters(
        self, ids: Ids, inertia: Array, viscous_friction: Array, gravity_moment: Array
    ) -> None:
        """See `LinkPhysics.set_parameters`."""
        check_link(ids, inertia, viscous_friction, gravity_moment)
        mass, center, moment = mass_distribution(inertia, gravity_moment)
        self.batch.expand("body_mass")[ids, self._link] = mass
        self.batch.expand("body_ipos")[ids, self._link] = center
        self.batch.expand("body_inertia")[ids, self._link] = moment[:, None]
        self.batch.expand("dof_damping")[ids, 0] = viscous_friction
        self.batch.set_const(ids)

    def parameters_of(self, simulation: int) -> tuple[Array, Array, Array]:
        """See `LinkSimulation.parameters_of`."""
        names = ("body_mass", "body_ipos", "body_inertia")
        mass, center, moment = (self.value(name, simulation)[None, self._link] for name in names)
        inertia, gravity_moment = inertia_and_gravity(PointMass(mass, center, moment[:, 0]))
        return inertia, self.value("dof_damping", simulation), gravity_moment
