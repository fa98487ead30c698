"""What is refused where declarations, keywords and saved states meet the environments."""

from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.envs import EnvConfig, EpisodeLoop, PRPEnv
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.tasks import Field, ObservationLayout, Reward, RewardTerm

TRACKING = "PRP-JointTracking-v0"


def made(**keywords: Any) -> PRPEnv:
    env = gymnasium.make(TRACKING, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


@pytest.mark.parametrize(
    "others",
    [
        {"scenario": "report"},
        {"reference": "sine"},
        {"control_frequency": 50},
        {"torque_limit": (1.0, 2.0, 3.0)},
    ],
)
def test_state_of_an_environment_with_other_keywords_is_refused(others: dict[str, Any]) -> None:
    env, other = made(), made(**others)
    env.reset(seed=0)
    other.reset(seed=0)
    before = env.get_state()
    with pytest.raises(InvalidValueError, match="saved state's keywords"):
        env.set_state(other.get_state())
    np.testing.assert_array_equal(env.get_state().loop.physics.integration, before.loop.physics.integration)


def test_state_of_an_environment_that_is_looked_at_in_another_way_is_taken() -> None:
    env, other = made(), made(width=64, height=64, camera="top", torque_limit="scenario")
    env.reset(seed=0)
    expected, _ = other.reset(seed=1)
    np.testing.assert_array_equal(env.set_state(other.get_state()), expected)


@pytest.mark.parametrize("ids", [[2, 0], [1, 1], [], [-1, 0], [0, 3]])
def test_ids_that_are_out_of_order_or_range_are_refused_before_anything_changes(ids: list[int]) -> None:
    loop = EpisodeLoop(made(scenario="realistic").task, EnvConfig(scenario="realistic"), num_envs=3)
    rngs = [np.random.default_rng(seed) for seed in range(3)]
    loop.reset(np.arange(3), rngs, {})
    twin = EpisodeLoop(made(scenario="realistic").task, EnvConfig(scenario="realistic"), num_envs=3)
    twin.reset(np.arange(3), [np.random.default_rng(seed) for seed in range(3)], {})
    with pytest.raises(InvalidValueError, match="ids"):
        loop.reset(np.array(ids, dtype=np.intp), rngs[: len(ids)], {})
    action = np.full((3, 3), 0.1)
    np.testing.assert_array_equal(loop.step(action).observation, twin.step(action).observation)


def test_first_reset_of_some_environments_only_is_refused() -> None:
    loop = EpisodeLoop(made().task, EnvConfig(), num_envs=3)
    with pytest.raises(InvalidValueError, match="first reset"):
        loop.reset(np.array([0, 2]), [np.random.default_rng(0)] * 2, {})


def test_centre_of_the_reports_sine_may_be_asked_for() -> None:
    env = made(scenario="report", reference="sine")
    drawn, _ = env.reset(seed=0)
    target_impedance, _ = env.reset(seed=0, options={"goal": (np.pi / 2, -0.2, np.pi)})
    np.testing.assert_array_equal(target_impedance, drawn)


@pytest.mark.parametrize(
    ("keyword", "value"),
    [
        ("control_frequency", "500"),
        ("control_frequency", None),
        ("control_frequency", 1e-320),
        ("duration", None),
        ("width", "a"),
        ("width", 10.5),
        ("height", float("nan")),
        ("torque_limit", 1e300),
    ],
)
def test_keyword_of_another_type_or_size_is_refused_by_name(keyword: str, value: object) -> None:
    with pytest.raises(InvalidValueError, match=keyword):
        EnvConfig(**{keyword: value})  # type: ignore[arg-type]


def test_scenario_that_is_no_name_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="scenario"):
        EnvConfig(scenario=["report"])  # type: ignore[arg-type]


def test_words_for_numbers_are_refused() -> None:
    env = made()
    with pytest.raises(InvalidValueError, match="reset option 'goal'"):
        env.reset(seed=0, options={"goal": "there"})
    env.reset(seed=0)
    with pytest.raises(InvalidValueError, match="action"):
        env.step("left")  # type: ignore[arg-type]


def test_equal_keywords_make_equal_values() -> None:
    assert EnvConfig(torque_limit=5) == EnvConfig(torque_limit=np.float64(5.0))
    assert EnvConfig(torque_limit=np.array([1.0, 2.0, 3.0])) == EnvConfig(torque_limit=[1, 2, 3])  # type: ignore[arg-type]


def test_negative_weight_is_refused() -> None:
    terms = [RewardTerm("a", 1.5, (1.0,), ("m",)), RewardTerm("b", -0.5, (1.0,), ("m",))]
    with pytest.raises(InvalidValueError, match="weight of reward term 'b'"):
        Reward(terms)


def test_declarations_that_do_not_fit_are_refused() -> None:
    field = Field("a", ("m",), "world", (-1.0,), (1.0,), "")
    with pytest.raises(InvalidValueError, match="observation fields"):
        ObservationLayout((field, field))
    with pytest.raises(InvalidValueError, match="observation fields"):
        ObservationLayout(())
    with pytest.raises(InvalidValueError, match="sizes of field 'a'"):
        Field("a", ("m", "m"), "world", (-1.0,), (1.0,), "")
