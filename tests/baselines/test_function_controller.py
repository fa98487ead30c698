"""Plain functions of observation fields as controllers."""

import pickle
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.baselines import BASELINES, ControllerSpec, FunctionControllerSpec, make_baseline
from prp_gym.errors import InvalidValueError, MissingFieldError, ShapeError, UnknownNameError
from prp_gym.robot import PRPArm, RobotParameters
from prp_gym.tasks.fields import ObservationLayout

ENVIRONMENT = "PRP-JointTracking-v0"


@prp_gym.controller
def proportional_derivative(
    joint_position: Any,
    joint_velocity: Any,
    desired_joint_position: Any,
    desired_joint_velocity: Any,
    model: Any,
    *,
    proportional_gain: Any = 50.0,
    derivative_gain: Any = (10.0, 10.0, 10.0),
) -> Any:
    """PD control with gravity compensation.

    As in chapter 6.
    """
    error = desired_joint_position - joint_position
    torque = model.gravity_vector(joint_position) + proportional_gain * error
    return torque + derivative_gain * (desired_joint_velocity - joint_velocity)


@prp_gym.controller(name="damper", summary="brakes the joints")
def brake(joint_velocity: Any, *, damping: float = 2.0) -> Any:
    return -damping * joint_velocity


@pytest.fixture
def env() -> Any:
    with closing(gymnasium.make(ENVIRONMENT)) as made:
        yield made


def observations(env: Any, count: int) -> Any:
    layout: ObservationLayout = env.get_wrapper_attr("observation_layout")
    return np.random.default_rng(4).normal(size=(count, layout.size))


@pytest.mark.parametrize(("gains", "frequency"), [("tuned", 500), ("report", 500), ("figures", 1000)])
def test_pd_function_is_joint_pd_with_the_same_gains_to_the_last_bit(gains: str, frequency: int) -> None:
    with closing(gymnasium.make(ENVIRONMENT, control_frequency=frequency, torque_limit=1e5)) as env:
        theirs = make_baseline("joint_pd", env, gains)
        values = {name: getattr(theirs.settings, name) for name in theirs.settings.vectors}
        ours = make_baseline(proportional_derivative, env, **values)
        given = observations(env, 20)
        for observation in (given, given[0]):
            expected, _ = theirs.predict(observation)
            assert np.abs(expected).max() < 1.0  # no limit hides a difference
            np.testing.assert_array_equal(ours.predict(observation)[0], expected)


def test_declaration_takes_name_and_summary_from_the_function_unless_given() -> None:
    assert isinstance(proportional_derivative, ControllerSpec)
    assert proportional_derivative.name == "proportional_derivative"
    assert proportional_derivative.summary == "PD control with gravity compensation."
    assert (brake.name, brake.summary) == ("damper", "brakes the joints")
    assert brake.gain_sets == ("tuned",)


def test_declaration_can_be_called_as_the_function() -> None:
    np.testing.assert_array_equal(brake(np.array([1.0, 2.0, 3.0]), damping=0.5), [-0.5, -1.0, -1.5])
    assert brake.__name__ == "brake"  # type: ignore[attr-defined]
    assert proportional_derivative.__doc__.startswith("PD control")  # type: ignore[union-attr]


def test_settings_have_defaults_that_gains_and_overrides_replace(env: Any) -> None:
    observation = np.zeros(observations(env, 1)[0].size)
    observation[env.get_wrapper_attr("observation_layout").index("joint_velocity")] = [1.0, 2.0, 0.5]
    limit = env.unwrapped.torque_limit
    for given, damping in (
        ({}, 2.0),
        ({"damping": 3.0}, 3.0),
        ({"gains": {"damping": 4}}, 4.0),
        ({"gains": {"damping": 4}, "damping": -0.5}, -0.5),
        ({"damping": [1.0, 2.0, 3.0]}, np.array([1.0, 2.0, 3.0])),
    ):
        settings: Any = given
        action, _ = make_baseline(brake, env, **settings).predict(observation)
        np.testing.assert_array_equal(
            action, (-damping * np.array([1.0, 2.0, 0.5]) / limit).astype(np.float32)
        )


def test_model_is_the_nominal_robot_unless_another_is_given(env: Any) -> None:
    seen: list[Any] = []

    @prp_gym.controller
    def look(joint_position: Any, model: Any) -> Any:
        seen.append(model)
        return 0.0 * joint_position

    heavy = RobotParameters().with_masses((0.9, 0.5, 0.7))
    observation = observations(env, 1)[0]
    make_baseline(look, env).predict(observation)
    make_baseline(look, env, model=heavy).predict(observation)
    assert seen == [PRPArm(), PRPArm(heavy)]


def test_function_runs_where_its_fields_are_observed_and_needs_no_reference(env: Any) -> None:
    layout: ObservationLayout = env.get_wrapper_attr("observation_layout")
    bare = ObservationLayout([field for field in layout.fields if field.name == "joint_velocity"])
    assert brake.missing_fields(bare) == []
    assert proportional_derivative.missing_fields(bare) == [
        "joint_position",
        "desired_joint_position",
        "desired_joint_velocity",
    ]


def test_field_that_the_environment_does_not_have_is_named_with_those_that_it_has(env: Any) -> None:
    @prp_gym.controller
    def wishful(joint_position: Any, joint_torque: Any) -> Any:
        return joint_position + joint_torque

    with pytest.raises(
        MissingFieldError, match=r"'wishful' reads .*: joint_torque\. Fields given: .*velocity"
    ):
        make_baseline(wishful, env)


@pytest.mark.parametrize("returned", [1.0, np.zeros(2), np.zeros((4, 3, 1)), np.zeros((1, 3))])
def test_torques_of_another_shape_are_refused(env: Any, returned: Any) -> None:
    @prp_gym.controller
    def wrong(joint_position: Any) -> Any:
        return returned

    policy = make_baseline(wrong, env)
    with pytest.raises(
        ShapeError, match=r"controller function 'wrong' .* \(4, 3\), one torque for every joint"
    ):
        policy.predict(observations(env, 4))


def test_what_is_no_number_is_refused(env: Any) -> None:
    @prp_gym.controller
    def wordy(joint_position: Any) -> Any:
        return ["a", "b", "c"]

    with pytest.raises(InvalidValueError, match="torques returned by controller function 'wordy'"):
        make_baseline(wordy, env).predict(observations(env, 1)[0])


@pytest.mark.parametrize(
    ("setting", "value", "error"),
    [
        ("derivative_gain", [1.0, 2.0], ShapeError),
        ("proportional_gain", [1.0, 2.0], ShapeError),
        ("proportional_gain", [[1.0]], InvalidValueError),
        ("proportional_gain", "stiff", InvalidValueError),
        ("proportional_gain", float("inf"), InvalidValueError),
        ("proportional_gian", 1.0, UnknownNameError),
    ],
)
def test_setting_that_does_not_fit_is_refused(env: Any, setting: str, value: Any, error: Any) -> None:
    with pytest.raises(error, match=setting):
        make_baseline(proportional_derivative, env, **{setting: value})


def positional_default(joint_position: Any, joint_velocity: Any = 0.0) -> Any: ...
def no_default(joint_position: Any, *, gain: float) -> Any: ...
def text(joint_position: Any, *, gain: str = "high") -> Any: ...
def model_as_setting(joint_position: Any, *, model: Any = None) -> Any: ...
def many(*fields: Any) -> Any: ...
def named(joint_position: Any, **fields: Any) -> Any: ...


@pytest.mark.parametrize(
    ("function", "parameter"),
    [
        (positional_default, "joint_velocity"),
        (no_default, "gain"),
        (text, "gain"),
        (model_as_setting, "model"),
        (many, "fields"),
        (named, "fields"),
    ],
)
def test_parameter_that_means_nothing_is_refused(function: Any, parameter: str) -> None:
    with pytest.raises(
        InvalidValueError, match=f"{parameter!r} of controller function '{function.__name__}'"
    ):
        prp_gym.controller(function)


def test_what_is_no_function_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="a function of observation fields"):
        prp_gym.controller(3)  # type: ignore[call-overload]


def test_declaration_and_policy_survive_pickling(env: Any) -> None:
    assert pickle.loads(pickle.dumps(brake)) is brake
    policy = make_baseline(brake, env, damping=[1.0, 2.0, 3.0])
    again = pickle.loads(pickle.dumps(policy))
    observation = observations(env, 1)[0]
    np.testing.assert_array_equal(again.predict(observation)[0], policy.predict(observation)[0])


def test_registered_function_is_listed_and_evaluated_by_its_name(env: Any) -> None:
    prp_gym.register_controller(brake)
    try:
        assert prp_gym.list_baselines()[-1] == "damper"
        assert isinstance(BASELINES["damper"], FunctionControllerSpec)
        result = prp_gym.evaluate(make_baseline("damper", env), env, episodes=1)
        assert result.median["divergence"] == 0.0
        assert "damper" in prp_gym.list_baselines(env.get_wrapper_attr("observation_layout"))
    finally:
        BASELINES.unregister("damper")
    assert "damper" not in prp_gym.list_baselines()
