"""Settings of a controller: allowed values, and how vectors get the size of the robot."""

from dataclasses import FrozenInstanceError, dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from prp_gym.baselines import Settings, Vector
from prp_gym.errors import InvalidValueError, ShapeError, UnknownNameError
from prp_gym.robot import NOMINAL, NOMINAL_LINK

SIZES = {"joint": 3, "pose": 6, "parameter": 12}


@dataclass(frozen=True, eq=False)
class Numbers(Settings):
    gain: Any
    pose_gain: Any = 0.0
    share: float = 0.5
    mode: str = "slow"

    vectors: ClassVar = {"gain": Vector("joint", "N·m"), "pose_gain": Vector("pose", "N/m")}
    numbers: ClassVar = {"share": "s"}
    choices: ClassVar = {"mode": ("slow", "fast")}


@pytest.mark.parametrize("given", [3, 3.0, np.float64(3.0), [3.0], [3, 3, 3], np.full(3, 3.0)])
def test_one_number_or_several_fill_the_vector(given: Any) -> None:
    sized = Numbers(given).sized(SIZES)
    assert sized.gain.dtype == np.float64
    np.testing.assert_array_equal(sized.gain, [3.0, 3.0, 3.0])
    np.testing.assert_array_equal(sized.pose_gain, np.zeros(6))


def test_each_vector_gets_the_length_of_what_it_is_for() -> None:
    sized = Numbers([1.0, 2.0], pose_gain=np.arange(6.0)).sized({"joint": 2, "pose": 6})
    np.testing.assert_array_equal(sized.gain, [1.0, 2.0])
    np.testing.assert_array_equal(sized.pose_gain, np.arange(6.0))


def test_sizing_keeps_everything_else() -> None:
    sized = Numbers(1.0, share=2.0, mode="fast", model=NOMINAL_LINK).sized(SIZES)
    assert (sized.share, sized.mode, sized.model) == (2.0, "fast", NOMINAL_LINK)


@pytest.mark.parametrize(
    ("name", "value"), [("gain", [1.0, 2.0]), ("gain", [1.0] * 6), ("gain", []), ("pose_gain", [1.0] * 3)]
)
def test_vector_of_another_length_is_refused(name: str, value: Any) -> None:
    with pytest.raises(ShapeError, match=f"setting '{name}' has shape") as caught:
        Numbers(**{"gain": 1.0, name: value}).sized(SIZES)
    assert caught.value.shape == (len(value),)


def test_vector_is_a_copy_that_cannot_be_written() -> None:
    given = np.array([1.0, 2.0, 3.0])
    settings = Numbers(given)
    given[0] = 9.0
    for vector in (settings.gain, settings.sized(SIZES).gain):
        np.testing.assert_array_equal(vector, [1.0, 2.0, 3.0])
        with pytest.raises(ValueError, match="read-only"):
            vector[0] = 9.0
    with pytest.raises(FrozenInstanceError):
        settings.gain = 1.0  # type: ignore[misc]


@pytest.mark.parametrize("value", [-1.0, [1, 2, -1e-9], float("nan"), [1, float("inf"), 1], [[1.0]], 1e308])
def test_vector_that_is_negative_or_not_finite_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"gain is .* N·m; allowed: finite and at least 0") as caught:
        Numbers(value)
    assert (caught.value.what, caught.value.unit) == ("gain", "N·m")


@pytest.mark.parametrize("value", ["fast", ["a", "b", "c"], [[1.0], [1.0, 2.0]]])
def test_vector_of_something_else_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValueError, match="allowed: a number or numbers"):
        Numbers(value)


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf"), "1", None, True, 1j, 1e308])
def test_number_that_is_none_negative_or_not_finite_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValueError, match="share is") as caught:
        Numbers(1.0, share=value)
    assert caught.value.unit == "s"


def test_several_numbers_for_one_are_refused() -> None:
    with pytest.raises(ShapeError, match="share has shape"):
        Numbers(1.0, share=[1.0])  # type: ignore[arg-type]


def test_number_becomes_a_float() -> None:
    share = Numbers(1.0, share=2).share
    assert (type(share), share) == (float, 2.0)


def test_word_that_is_no_choice_gets_the_nearest_one() -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean 'fast'\? Valid: fast, slow\.") as caught:
        Numbers(1.0, mode="fasst")
    assert caught.value.kind == "mode"


@pytest.mark.parametrize("model", [1, "nominal", {"inertia": 1.0}])
def test_model_that_is_no_robot_is_refused(model: Any) -> None:
    with pytest.raises(InvalidValueError, match="allowed: a RobotParameters, a LinkParameters or None"):
        Numbers(1.0, model=model)
    assert Numbers(1.0, model=NOMINAL).model is NOMINAL
    assert Numbers(1.0).model is None


def test_unknown_name_gets_the_nearest_one() -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean 'gain'\?") as caught:
        Numbers.from_mapping("hold", {"gian": 1.0})
    assert caught.value.kind == "setting of controller 'hold'"
    assert set(caught.value.valid) == {"model", "gain", "pose_gain", "share", "mode"}


def test_mapping_makes_the_same_settings() -> None:
    made = Numbers.from_mapping("hold", {"gain": [1, 2, 3], "mode": "fast"})
    np.testing.assert_array_equal(made.gain, [1.0, 2.0, 3.0])
    assert made.mode == "fast"


def test_settings_are_equal_only_to_themselves() -> None:
    first, second = Numbers(1.0), Numbers(1.0)
    assert first == first
    assert first != second
