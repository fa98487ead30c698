"""The keywords of the environments: what they mean, and what each refuses, with its facts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs import PRPEnv
from prp_gym.envs.action_mode import list_action_modes
from prp_gym.envs.config import (
    RENDER_MODES,
    SUBSTEPS_PER_SECOND,
    UNLIMITED_TORQUE,
    EnvConfig,
    TorqueLimit,
    parse_keywords,
)
from prp_gym.errors import InvalidValueError, PRPError, UnknownKeywordError, UnknownNameError
from prp_gym.physics import CAMERAS
from prp_gym.robot import NOMINAL
from prp_gym.tasks import SCENARIOS

NAN, INFINITY = math.nan, math.inf


@dataclass(frozen=True)
class Options:
    """Keywords of an imaginary task."""

    flavour: str = "plain"


def test_defaults_are_those_of_the_design_document() -> None:
    config = EnvConfig()
    assert config.scenario == "randomized"
    assert config.control_frequency == 500
    assert config.duration == 5.0
    assert config.action_mode == "torque"
    assert config.render_mode is None
    assert config.substeps == 2
    assert config.horizon == 2500
    np.testing.assert_array_equal(config.limits(NOMINAL.torque_limit), NOMINAL.torque_limit)


def test_every_keyword_says_its_unit_and_meaning() -> None:
    for entry in fields(EnvConfig):
        assert set(entry.metadata) == {"unit", "description"}
        assert entry.metadata["description"]


DIVISORS = [rate for rate in range(1, SUBSTEPS_PER_SECOND + 1) if SUBSTEPS_PER_SECOND % rate == 0]


@pytest.mark.parametrize("rate", DIVISORS)
def test_control_frequency_may_be_any_divisor_of_the_substep_rate(rate: int) -> None:
    config = EnvConfig(control_frequency=rate, duration=2.0)
    assert config.substeps * rate == SUBSTEPS_PER_SECOND
    assert config.horizon == 2 * rate


def test_control_period_may_be_a_whole_number_of_substeps_at_a_fractional_rate() -> None:
    config = EnvConfig(control_frequency=1000 / 3, duration=3.0)
    assert config.substeps == 3
    assert config.horizon == 1000


@pytest.mark.parametrize("rate", [0, -500, 3, 300, 999, 2000, 1e9, NAN, INFINITY, -INFINITY])
def test_control_frequency_that_does_not_divide_is_refused(rate: float) -> None:
    with pytest.raises(InvalidValueError, match=r"control_frequency is .* Hz; allowed: a divisor of 1000"):
        EnvConfig(control_frequency=rate)


@pytest.mark.parametrize("duration", [0.0, -1.0, 0.003, 1.0001, 1e-9, NAN, INFINITY])
def test_duration_that_is_not_a_whole_number_of_periods_is_refused(duration: float) -> None:
    with pytest.raises(InvalidValueError, match=r"control periods of 0\.002 s") as caught:
        EnvConfig(duration=duration)
    assert caught.value.what == "duration"
    assert caught.value.unit == "s"
    np.testing.assert_equal(caught.value.value, duration)


def test_duration_is_checked_against_the_control_period() -> None:
    assert EnvConfig(control_frequency=1000, duration=0.003).horizon == 3
    with pytest.raises(InvalidValueError, match="duration"):
        EnvConfig(control_frequency=50, duration=0.03)


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenario_sets_the_torque_limits(name: str) -> None:
    config = EnvConfig(scenario=name)
    factor = config.load_scenario().torque_limit_factor
    for nominal in (NOMINAL.torque_limit, (30.0,)):
        np.testing.assert_array_equal(config.limits(nominal), [factor * limit for limit in nominal])


@pytest.mark.parametrize(
    ("given", "limits"),
    [
        (7, (7.0, 7.0, 7.0)),
        (2.5, (2.5, 2.5, 2.5)),
        ((1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
        (None, (UNLIMITED_TORQUE,) * 3),
    ],
)
def test_torque_limit_may_be_a_number_three_numbers_or_lifted(
    given: TorqueLimit, limits: tuple[float, float, float]
) -> None:
    config = EnvConfig(scenario="report", torque_limit=given)
    np.testing.assert_array_equal(config.limits(NOMINAL.torque_limit), limits)


@pytest.mark.parametrize(
    "limit", [0.0, -1.0, NAN, INFINITY, (50.0, 0.0, 10.0), (50.0, 100.0, NAN), (50.0, -100.0, 10.0)]
)
def test_torque_limit_must_be_positive_and_finite(limit: TorqueLimit) -> None:
    with pytest.raises(InvalidValueError, match=r"1e-06 to 1e\+06, or None") as caught:
        EnvConfig(torque_limit=limit)
    assert caught.value.what == "torque_limit"
    assert caught.value.value is limit
    assert caught.value.unit == "N·m, N, N·m"


@pytest.mark.parametrize("limit", [(), {}, ((50.0, 100.0, 10.0),), ("a", "b", "c")])
def test_torque_limit_of_another_kind_is_refused(limit: Any) -> None:
    with pytest.raises(InvalidValueError, match="a number or one number for each joint") as caught:
        EnvConfig(torque_limit=limit)
    assert caught.value.value is limit


@pytest.mark.parametrize("limit", [(50.0, 100.0), (50.0, 100.0, 10.0, 1.0)])
@pytest.mark.parametrize("environment_id", ["PRP-JointTracking-v0", "PRP-Adaptive-v0"])
def test_torque_limit_for_another_number_of_joints_is_refused(
    limit: tuple[float, ...], environment_id: str
) -> None:
    joints = 1 if environment_id == "PRP-Adaptive-v0" else 3
    with pytest.raises(InvalidValueError, match=f"allowed: one number or {joints}") as caught:
        gymnasium.make(environment_id, torque_limit=limit)
    assert caught.value.what == "torque_limit"
    assert caught.value.value == limit


def test_torque_limit_by_an_unknown_word_is_refused() -> None:
    with pytest.raises(
        InvalidValueError, match="'scenario', None, a number or one number for each joint"
    ) as caught:
        EnvConfig(torque_limit="nominal")
    assert caught.value.value == "nominal"


@pytest.mark.parametrize(
    ("keyword", "valid"),
    [
        ("scenario", SCENARIOS),
        ("action_mode", list_action_modes()),
        ("render_mode", RENDER_MODES),
        ("camera", CAMERAS),
    ],
)
def test_name_that_does_not_exist_is_refused_with_the_valid_ones(keyword: str, valid: Sequence[str]) -> None:
    wrong = f"{valid[0]}_"
    with pytest.raises(UnknownNameError, match=f"unknown {keyword} '{wrong}'") as caught:
        replace(EnvConfig(), **{keyword: wrong})  # type: ignore[arg-type]
    assert caught.value.kind == keyword
    assert caught.value.name == wrong
    assert caught.value.valid == tuple(sorted(valid))
    assert f"Did you mean '{valid[0]}'?" in str(caught.value)


@pytest.mark.parametrize("keyword", ["width", "height"])
@pytest.mark.parametrize("pixels", [0, -64])
def test_frame_size_must_be_positive(keyword: str, pixels: int) -> None:
    with pytest.raises(InvalidValueError, match=f"{keyword} is {pixels} pixels") as caught:
        replace(EnvConfig(), **{keyword: pixels})  # type: ignore[arg-type]
    assert caught.value.what == keyword


def test_keywords_are_sorted_into_common_and_own() -> None:
    config, options = parse_keywords({"duration": 1.0, "flavour": "sour", "camera": "top"}, Options)
    assert config == EnvConfig(duration=1.0, camera="top")
    assert options == Options("sour")


def test_no_keywords_give_the_defaults() -> None:
    assert parse_keywords({}, Options) == (EnvConfig(), Options())


def test_unknown_keyword_is_refused_with_common_and_own_ones_listed() -> None:
    with pytest.raises(UnknownKeywordError, match="unexpected keyword argument 'flavor'") as caught:
        parse_keywords({"flavor": "sour"}, Options)
    assert set(caught.value.valid) == {entry.name for entry in fields(EnvConfig)} | {"flavour"}
    assert "Did you mean 'flavour'?" in str(caught.value)


@pytest.mark.parametrize(
    ("keyword", "value", "kind"),
    [
        ("scenario", "reports", UnknownNameError),
        ("camera", "side", UnknownNameError),
        ("render_mode", "ansi", UnknownNameError),
        ("action_mode", "position", UnknownNameError),
        ("reference", "cubic", UnknownNameError),
        ("start", "anywhere", UnknownNameError),
        ("gravity", 1.6, UnknownNameError),
        ("control_frequency", 300, InvalidValueError),
        ("duration", NAN, InvalidValueError),
        ("torque_limit", "none", InvalidValueError),
    ],
)
def test_wrong_keyword_is_refused(keyword: str, value: Any, kind: type[PRPError]) -> None:
    with pytest.raises(kind, match=keyword):
        PRPEnv("PRP-JointTracking-v0", **{keyword: value})


def test_wrong_keyword_is_refused_through_make_too() -> None:
    with pytest.raises(UnknownKeywordError, match="unexpected keyword argument 'gravity'") as caught:
        gymnasium.make("PRP-JointRegulation-v0", gravity=1.6)
    origin = caught.value.__cause__ or caught.value.__context__  # Gymnasium raises one of its class again
    assert isinstance(origin, UnknownKeywordError)
    assert {"control_frequency", "torque_limit"} < set(origin.valid)


def test_keyword_of_one_task_is_unknown_to_another() -> None:
    with pytest.raises(UnknownNameError, match="unexpected keyword argument 'reference'"):
        PRPEnv("PRP-JointRegulation-v0", reference="sine")


def test_refusals_can_be_caught_as_this_packages_error_or_as_value_error() -> None:
    for kind in (PRPError, ValueError):
        with pytest.raises(kind, match="duration"):
            EnvConfig(duration=0.0)
