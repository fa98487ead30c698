"""The springs of a surface change while the surface stays where it is."""

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.physics.mjcf import PhysicsSettings
from prp_gym.physics.simulation import Physics
from prp_gym.physics.surface import Surface

PLANES = Surface(
    np.array([100.0, 2000.0]),
    np.array([0.0, 5.0]),
    np.array([[0.3, -0.8, 0.1], [0.0, 0.0, -1.0]]),
    np.array([0.2, -0.1]),
)
BOTH = np.arange(2)


@pytest.fixture
def world() -> Physics:
    physics = Physics(settings=PhysicsSettings(surface=True), num_simulations=2)
    physics.set_surface(BOTH, PLANES)
    return physics


def test_surface_is_the_one_that_was_set(world: Physics) -> None:
    for row in BOTH:
        surface = world.surface(int(row))
        assert surface.stiffness == PLANES.stiffness[row]
        assert surface.damping == PLANES.damping[row]
        assert surface.normal[0] == pytest.approx(PLANES.normal[row], abs=1e-12)  # by way of a quaternion
        assert surface.offset[0] == pytest.approx(PLANES.offset[row], abs=1e-12)


def test_springs_are_those_of_a_surface_that_was_set_with_them(world: Physics) -> None:
    other = Physics(settings=PhysicsSettings(surface=True), num_simulations=2)
    stiffness, damping = np.array([50.0, 700.0]), np.array([2.0, 0.0])
    other.set_surface(BOTH, Surface(stiffness, damping, PLANES.normal, PLANES.offset))
    world.set_springs(BOTH, stiffness, damping)
    one, two = world.snapshot(), other.snapshot()
    assert one.model_fields.keys() == two.model_fields.keys()
    for name, values in one.model_fields.items():
        assert (values == two.model_fields[name]).all(), name


def test_springs_of_another_simulation_stay(world: Physics) -> None:
    before = world.snapshot().model_fields["pair_solref"]
    world.set_springs(np.array([1]), np.array([10.0]), np.array([0.0]))
    after = world.snapshot().model_fields["pair_solref"]
    assert (after[0] == before[0]).all()
    assert world.surface(0).stiffness == 100.0


def test_refused_springs_change_nothing(world: Physics) -> None:
    before = world.snapshot().model_fields["pair_solref"]
    with pytest.raises(InvalidValueError, match="above 0"):
        world.set_springs(BOTH, np.array([1.0, 0.0]), np.zeros(2))
    with pytest.raises(InvalidValueError, match="at least 0"):
        world.set_springs(BOTH, np.ones(2), np.array([1.0, np.nan]))
    with pytest.raises(ShapeError):
        world.set_springs(BOTH, np.ones(3), np.zeros(2))
    assert (world.snapshot().model_fields["pair_solref"] == before).all()


def test_world_without_a_surface_has_no_springs() -> None:
    free = Physics()
    with pytest.raises(InvalidValueError, match="surface was set"):
        free.surface()
    with pytest.raises(InvalidValueError, match="surface"):
        free.set_springs(np.array([0]), np.ones(1), np.zeros(1))
