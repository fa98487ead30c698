"""The state of stateful controllers in `predict`, over episodes, batches, and saturated actuators."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import Baseline, ControlInterface, JointPDController, JointPDSettings, Settings, Vector
from prp_gym.errors import InvalidValueError, MissingFieldError, ShapeError
from prp_gym.robot import NOMINAL, NOMINAL_LINK, Link, LinkParameters, PRPArm
from prp_gym.tasks.fields import MEASURED_FIELDS, ObservationLayout
from tests.support.control_interface import INTERFACE, LIMIT, LINK_INTERFACE, PERIOD

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CountSettings(Settings):
    torque: Any = 0.0
    vectors: ClassVar = {"torque": Vector("joint", "N·m")}


class Count(Baseline[CountSettings]):
    """Adds q to an integral and 1 to a clock at every call; asks for `torque` times the clock."""

    name = "count"
    summary = "counts"
    measured_fields = ("joint_position",)
    settings_class = CountSettings
    integrators = (0,)

    def initial_state(self, observed: Any) -> tuple[Array, ...]:
        q = observed["joint_position"]
        return -q, np.zeros((*q.shape[:-1], 1))

    def control(self, observed: Any, state: tuple[Array, ...]) -> tuple[Array, tuple[Array, ...]]:
        integral, clock = state
        after = (integral + observed["joint_position"], clock + 1.0)
        return self.settings.torque * after[1] + 0.0 * observed["joint_position"], after


def count(torque: Any = 0.0) -> Count:
    return Count(INTERFACE, CountSettings(torque))


def observations(*positions: float) -> Array:
    """One observation per number, at which all joints are; without numbers a single one at 1."""
    flat = np.zeros((len(positions), INTERFACE.layout.size))
    flat[:, INTERFACE.layout.index("joint_position")] = np.array(positions)[:, None]
    return flat


def parts(state: Any) -> tuple[list[float], list[float]]:
    """First component of the integral, and the clock, per environment."""
    return np.atleast_2d(state[0])[:, 0].tolist(), np.atleast_2d(state[1])[:, 0].tolist()


def test_state_starts_with_the_first_observation_and_goes_on() -> None:
    controller, state = count(), None
    seen = []
    for position in (2.0, 3.0, 5.0):
        _, state = controller.predict(observations(position)[0], state)
        seen.append(parts(state))
    assert seen == [([0.0], [1.0]), ([3.0], [2.0]), ([8.0], [3.0])]


@pytest.mark.parametrize("start", [np.array([True]), np.array(True), True, [True]])
def test_state_of_a_single_environment_starts_anew_with_an_episode(start: Any) -> None:
    controller = count()
    _, state = controller.predict(observations(2.0)[0])
    _, state = controller.predict(observations(3.0)[0], state, episode_start=np.array([False]))
    assert parts(state) == ([3.0], [2.0])
    _, state = controller.predict(observations(5.0)[0], state, episode_start=start)
    assert parts(state) == ([0.0], [1.0])
    assert state is not None
    assert [part.shape for part in state] == [(3,), (1,)]


def test_each_environment_of_a_batch_starts_anew_on_its_own() -> None:
    controller = count()
    _, state = controller.predict(observations(1.0, 2.0, 3.0), episode_start=np.ones(3, dtype=bool))
    _, state = controller.predict(
        observations(4.0, 5.0, 6.0), state, episode_start=np.array([False, True, False])
    )
    assert parts(state) == ([4.0, 0.0, 6.0], [2.0, 1.0, 2.0])


def test_batch_of_one_keeps_its_axis() -> None:
    controller = count()
    _, state = controller.predict(observations(1.0))
    action, state = controller.predict(observations(2.0), state, episode_start=np.array([False]))
    assert action.shape == (1, 3)
    assert state is not None
    assert [part.shape for part in state] == [(1, 3), (1, 1)]


def test_given_state_is_left_as_it_was() -> None:
    controller = count()
    _, state = controller.predict(observations(1.0, 2.0))
    assert state is not None
    for part in state:
        part.flags.writeable = False
    controller.predict(observations(4.0, 5.0), state, episode_start=np.array([False, True]))
    assert parts(state) == ([0.0, 0.0], [1.0, 1.0])


@pytest.mark.parametrize(
    "state",
    [
        (np.zeros((3, 3)), np.zeros((3, 1))),
        (np.zeros(3), np.zeros(1)),
        (np.zeros((2, 3)), np.zeros((2, 2))),
        (np.zeros((2, 3)),),
        (np.zeros((2, 3)), np.zeros((2, 1)), np.zeros((2, 1))),
    ],
)
def test_state_of_another_batch_or_controller_is_refused(state: Any) -> None:
    with pytest.raises(ShapeError, match="state has shape"):
        count().predict(observations(1.0, 2.0), state)


def test_state_of_a_batch_is_refused_for_a_single_observation() -> None:
    _, state = count().predict(observations(1.0, 2.0))
    with pytest.raises(ShapeError, match="state has shape"):
        count().predict(observations(1.0)[0], state)


def test_flags_of_another_batch_are_refused() -> None:
    _, state = count().predict(observations(1.0, 2.0))
    with pytest.raises(ShapeError, match="episode_start has shape"):
        count().predict(observations(1.0, 2.0), state, episode_start=np.array([True, False, True]))


def test_integrators_stand_still_where_an_actuator_is_at_its_limit() -> None:
    controller = count([0.0, 0.0, 4.0])  # of 10 N m: at the limit in the third call, in joint 3 alone
    _, state = controller.predict(observations(1.0))
    integrals, clocks = [], []
    for _ in range(4):
        _, state = controller.predict(observations(1.0), state)
        integral, clock = parts(state)
        integrals += integral
        clocks += clock
    assert integrals == [1.0, 1.0, 1.0, 1.0]
    assert clocks == [2.0, 3.0, 4.0, 5.0]


def test_only_the_environment_that_is_limited_holds() -> None:
    controller = count([30.0, 0.0, 0.0])  # of 50 N m, at the limit from the second call
    _, state = controller.predict(observations(1.0, 1.0))
    _, state = controller.predict(observations(2.0, 2.0), state, episode_start=np.array([False, True]))
    assert parts(state) == ([0.0, 0.0], [2.0, 1.0])
    _, state = controller.predict(observations(7.0, 7.0), state, episode_start=np.array([True, False]))
    assert parts(state) == ([0.0, 0.0], [1.0, 2.0])


def test_full_torque_is_not_beyond_the_limit() -> None:
    _, state = count([50.0, 0.0, 0.0]).predict(observations(3.0))
    _, state = count([25.0, 0.0, 0.0]).predict(observations(3.0), state)
    assert parts(state) == ([3.0], [2.0])


def test_stateless_controller_has_no_state() -> None:
    controller = JointPDController(INTERFACE, JointPDSettings(1.0, 1.0))
    observation = observations(1.0, 2.0)
    action, state = controller.predict(observation, None, np.array([True, False]))
    assert state is None
    np.testing.assert_array_equal(action, controller.predict(observation, deterministic=False)[0])
    with pytest.raises(ShapeError, match="a tuple of 0 arrays"):
        controller.predict(observation, (np.zeros((2, 1)),))


def test_model_of_the_controller_is_the_nominal_one_or_its_own() -> None:
    heavy = NOMINAL.with_masses((2.0, 1.0, 1.0))
    assert JointPDController(INTERFACE, JointPDSettings(1.0, 1.0)).model == PRPArm()
    assert JointPDController(INTERFACE, JointPDSettings(1.0, 1.0, model=heavy)).model == PRPArm(heavy)
    light = LinkParameters(inertia=0.1)
    assert JointPDController(LINK_INTERFACE, JointPDSettings(1.0, 1.0, model=light)).model == Link(light)


def test_model_of_another_robot_is_refused() -> None:
    with pytest.raises(
        InvalidValueError, match=r"model of PRP-JointTracking-v0 is .*; allowed: a RobotParam"
    ):
        JointPDController(INTERFACE, JointPDSettings(1.0, 1.0, model=NOMINAL_LINK))
    with pytest.raises(InvalidValueError, match=r"model of PRP-Adaptive-v0 is .*; allowed: a LinkParameters"):
        JointPDController(LINK_INTERFACE, JointPDSettings(1.0, 1.0, model=NOMINAL))


def test_gains_get_the_robot_s_size() -> None:
    assert JointPDController(LINK_INTERFACE, JointPDSettings(1.0, 1.0)).settings.proportional_gain.shape == (
        1,
    )
    assert JointPDController(INTERFACE, JointPDSettings(1.0, 1.0)).settings.proportional_gain.shape == (3,)
    with pytest.raises(ShapeError, match="setting 'derivative_gain'"):
        JointPDController(LINK_INTERFACE, JointPDSettings(1.0, [1.0, 2.0, 3.0]))


def test_either_reference_will_do_and_none_is_named() -> None:
    interface = ControlInterface("PRP-A-v0", ObservationLayout(MEASURED_FIELDS), LIMIT, PERIOD, PRPArm())
    with pytest.raises(MissingFieldError, match="desired_joint_position or desired_pose"):
        JointPDController(interface, JointPDSettings(1.0, 1.0))
