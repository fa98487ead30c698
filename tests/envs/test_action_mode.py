"""The parts of an action: what they mean, and which are refused."""

import numpy as np
import pytest
from gymnasium.spaces import Box

from prp_gym.envs.action_mode import ActionField, torque_field
from prp_gym.errors import InvalidValueError
from prp_gym.robot import NOMINAL
from tests.support.mode_episodes import COVERING, made

OFFSET = ActionField("offset", ("m", "rad"), "world", (0.05, 0.3), "an offset")
FACTOR = ActionField("factor", ("1", "1"), "world", (10.0, 4.0), "a factor", factor=True)


def test_offset_is_the_share_of_its_bound() -> None:
    action = np.array([[1.0, -1.0], [0.0, 0.5]])
    np.testing.assert_array_equal(OFFSET.value(action), [[0.05, -0.3], [0.0, 0.15]])
    assert OFFSET.low == (-0.05, -0.3)
    assert OFFSET.size == 2


def test_factor_goes_from_one_over_the_bound_to_the_bound_in_equal_ratios() -> None:
    action = np.array([[1.0, 1.0], [0.0, 0.0], [-1.0, -1.0], [0.5, -0.5]])
    expected = [[10.0, 4.0], [1.0, 1.0], [0.1, 0.25], [np.sqrt(10.0), 0.5]]
    np.testing.assert_allclose(FACTOR.value(action), expected, rtol=1e-15)  # one rounding of a power
    np.testing.assert_array_equal(FACTOR.value(np.zeros(2)), 1.0)
    assert FACTOR.low == (0.1, 0.25)


@pytest.mark.parametrize(("factor", "bound"), [(False, 0.0), (False, -1.0), (True, 1.0), (True, np.nan)])
def test_bound_that_leaves_no_choice_is_refused(factor: bool, bound: float) -> None:
    with pytest.raises(InvalidValueError, match="bound of action field 'x'"):
        ActionField("x", ("m",), "world", (bound,), "", factor=factor)


def test_bounds_are_as_many_as_units() -> None:
    with pytest.raises(InvalidValueError, match="2 numbers above 0"):
        ActionField("x", ("m", "m"), "world", (1.0,), "")


def test_torques_are_bounded_by_the_actuators() -> None:
    field = torque_field(np.array(NOMINAL.torque_limit))
    assert field.bound == NOMINAL.torque_limit
    assert field.units == ("N·m", "N", "N·m")
    assert torque_field(np.array([30.0])).units == ("N·m",)


@pytest.mark.parametrize(("environment_id", "mode"), COVERING)
def test_action_space_has_a_component_for_every_unit_of_the_fields(environment_id: str, mode: str) -> None:
    env = made(environment_id, mode)
    space = env.action_space
    assert space.shape == (sum(len(field.units) for field in env.action_fields),)
    assert space == Box(-1.0, 1.0, space.shape, np.float32)
    assert env.action_mode == mode
    assert all(field.description and field.frame for field in env.action_fields)
