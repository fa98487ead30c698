"""An action held over several periods of an inner controller: time, sums, divergence, memory, refusals."""

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.envs import PRPEnv
from prp_gym.errors import EpisodeError, InvalidValueError, NonFiniteError, ShapeError
from tests.support.mode_episodes import KINDS, made, random_actions
from tests.support.synthetic_mode import NEVER, WILD, violent_in
from tests.support.vector_episodes import MODES, assert_same, one_by_one, single, together

RATE, PERIODS = 50, 10
SHOWN = ("ground_truth", "commanded_torque", "applied_torque")
COPIES: dict[str, Callable[[PRPEnv], PRPEnv]] = {
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "deepcopy": copy.deepcopy,
}


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """MuJoCo writes warnings of diverging simulations to a file in the working directory."""
    monkeypatch.chdir(tmp_path)


def run(env: Any, actions: Any) -> list[Any]:
    return [env.step(action) for action in actions]


@pytest.mark.parametrize(("environment_id", "mode"), KINDS)
def test_action_held_is_the_same_action_given_in_every_inner_period(environment_id: str, mode: str) -> None:
    held, given = (
        made(environment_id, mode, scenario="realistic", control_frequency=rate) for rate in (RATE, 500)
    )
    assert_same(held.reset(seed=3), given.reset(seed=3), "reset")
    shares = {"last": 0.0, "sum": 1.0, "mean": 1.0 / PERIODS}
    share = {field.name: shares[field.over_periods] for field in held.info_fields}
    for count, action in enumerate(random_actions(held, 8, share=1.3)):
        outcome, steps = held.step(action), run(given, [action] * PERIODS)
        assert_same(outcome[0], steps[-1][0], f"observation {count}")
        reward, info = 0.0, dict.fromkeys(share, 0.0)
        for step in steps:
            reward += step[1] * shares["mean"]
            info = {
                name: info[name] + value * share[name] if share[name] else value
                for name, value in step[4].items()
            }
        assert outcome[1:] == (reward, *steps[-1][2:4], info)
        for name in SHOWN:
            assert_same(getattr(held, name), getattr(given, name), name)


def test_costs_are_counted_in_every_period_and_forces_are_the_last() -> None:
    env = made("PRP-ForcePosition-v0", "force_position")
    rules = {field.name: field.over_periods for field in env.info_fields}
    assert {rules[name] for name in rules if name.startswith("reward_")} == {"mean"}
    assert {rules[name] for name in rules if name.startswith("cost_")} == {"sum"}
    assert rules["time"] == rules["contact_force"] == "last"


def test_step_of_a_saturated_controller_counts_every_period() -> None:
    env = made("PRP-JointRegulation-v0", "joint_position", control_frequency=RATE, torque_limit=1e-3)
    env.reset(seed=0)
    assert env.step(np.ones(3))[4]["cost_saturation"] == 3 * PERIODS


@pytest.mark.parametrize("rate", [50, 125, 500])
def test_terms_in_info_sum_to_the_reward_and_time_goes_on(rate: int) -> None:
    env = made("PRP-Impedance-v0", "variable_impedance", control_frequency=rate, duration=0.2)
    env.reset(seed=5)
    outcomes = run(env, random_actions(env, round(0.2 * rate)))
    for count, (_, reward, _, _, info) in enumerate(outcomes, start=1):
        terms = [value for name, value in info.items() if name.startswith("reward_")]
        assert sum(terms) == pytest.approx(reward, rel=1e-14)  # ten sums of a few terms, in another order
        assert info["time"] == pytest.approx(count / rate, rel=1e-15)  # one rounding
    assert [outcome[3] for outcome in outcomes] == [False] * (len(outcomes) - 1) + [True]


@pytest.mark.parametrize(("environment_id", "mode"), KINDS)
@pytest.mark.parametrize("how", [*COPIES, "state"])
def test_copy_and_saved_state_go_on_as_the_original(environment_id: str, mode: str, how: str) -> None:
    env = made(environment_id, mode, scenario="realistic", control_frequency=RATE)
    env.reset(seed=21)
    actions = random_actions(env, 8)
    seen = run(env, actions[:4])[-1][0]
    if how == "state":
        clone = made(environment_id, mode, scenario="realistic", control_frequency=RATE)
        np.testing.assert_array_equal(clone.set_state(env.get_state()), seen)
    else:
        clone = COPIES[how](env)
    assert_same(run(clone, actions[4:]), run(env, actions[4:]), how)
    assert_same(clone.reset(), env.reset(), how)
    assert_same(run(clone, actions[:3]), run(env, actions[:3]), how)


def env_size(env: PRPEnv) -> int:
    """Number of components of an action."""
    return sum(field.size for field in env.action_fields)


@pytest.mark.parametrize(("environment_id", "mode"), KINDS)
def test_new_episode_resets_the_state_of_the_inner_controller(environment_id: str, mode: str) -> None:
    used, fresh = (made(environment_id, mode, control_frequency=RATE) for _ in range(2))
    used.reset(seed=1)
    run(used, np.ones((20, env_size(used))))
    assert_same(used.reset(seed=2), fresh.reset(seed=2), "reset")
    actions = random_actions(fresh, 5)
    assert_same(run(used, actions), run(fresh, actions), "steps")


def test_state_of_another_mode_is_refused() -> None:
    env, other = (made("PRP-Impedance-v0", mode) for mode in ("impedance", "variable_stiffness"))
    env.reset(seed=0)
    with pytest.raises(InvalidValueError, match="saved state's keywords"):
        other.set_state(env.get_state())


def test_state_goes_from_a_registered_environment_to_one_that_is_not() -> None:
    env, other = made("PRP-Impedance-v0"), PRPEnv("PRP-Impedance-v0")
    observation, _ = env.reset(seed=0)
    np.testing.assert_array_equal(other.set_state(env.get_state()), observation)


def test_step_before_reset_is_refused() -> None:
    env = made("PRP-Impedance-v0", "impedance")
    with pytest.raises(EpisodeError, match="call reset first"):
        env.step(np.zeros(5))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_action_that_is_not_a_number_changes_nothing(value: float) -> None:
    env, twin = (made("PRP-Impedance-v0", "impedance", scenario="realistic") for _ in range(2))
    many = together("PRP-Impedance-v0", num_envs=2, action_mode="impedance", scenario="realistic")
    for each in (env, twin, many):
        each.reset(seed=4)
        run(each, [np.zeros(each.action_space.shape)])
    with pytest.raises(NonFiniteError, match="action is "):
        env.step(np.array([0.0, 0.0, value, 0.0, 0.0]))
    with pytest.raises(NonFiniteError, match=r"action of environments \[1\]"):
        many.step(np.array([[0.0] * 5, [value] * 5]))
    expected = twin.step(np.ones(5))
    assert_same(env.step(np.ones(5)), expected, "step")
    assert_same(many.step(np.ones((2, 5)))[0][0], expected[0], "many")


@pytest.mark.parametrize("mode", ["variable_impedance", "residual:joint_pd"])
def test_action_beyond_one_is_clipped(mode: str) -> None:
    env, twin = (made("PRP-Impedance-v0", mode) for _ in range(2))
    assert_same(env.reset(seed=4), twin.reset(seed=4), "reset")
    action = np.linspace(-2.0, 2.0, env_size(env))
    assert_same(env.step(action), twin.step(np.clip(action, -1.0, 1.0)), "step")


def test_action_of_another_shape_is_refused() -> None:
    env = made("PRP-Impedance-v0", "impedance")
    env.reset(seed=0)
    for shape in ((3,), (6,), (1, 5), ()):
        with pytest.raises(ShapeError, match=r"expected \(5,\)"):
            env.step(np.zeros(shape))
    with pytest.raises(ShapeError, match=r"expected \(1, 5\)"):
        env.loop.step(np.zeros((1, 3)))


@pytest.mark.usefixtures("late_mode")
@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
def test_divergence_within_a_period_ends_the_step_there(scenario: str) -> None:
    env, fine = (
        single("PRP-ForcePosition-v0", **WILD, scenario=scenario, control_frequency=rate)
        for rate in (RATE, 500)
    )
    env.reset(seed=6)
    fine.reset(seed=6)
    action = np.array([violent_in(4), 1.0])
    delay = scenario == "realistic"  # one-step actuation delay
    steps = run(fine, [action] * (4 + delay))
    outcome = env.step(action)
    assert [step[2] for step in steps] == [False] * (3 + delay) + [True]
    assert_same(outcome[0], steps[-1][0], "observation")
    # the mean over the periods of the step; those after the divergence count as 0; some roundings
    assert outcome[1] == pytest.approx(sum(step[1] for step in steps) / PERIODS, rel=1e-14)
    assert outcome[2:4] == (True, False)
    assert outcome[4]["time"] == pytest.approx((4 + delay) * 0.002, rel=1e-15)  # one rounding
    for name in SHOWN:
        assert_same(getattr(env, name), getattr(fine, name), name)
    with pytest.raises(EpisodeError, match="diverged"):
        env.step(action)


@pytest.mark.usefixtures("late_mode")
@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
@pytest.mark.parametrize("mode", MODES)
def test_many_of_which_some_diverge_within_a_period_are_those_of_single_ones(
    mode: str, scenario: str
) -> None:
    keywords = {**WILD, "scenario": scenario, "control_frequency": RATE, "duration": 0.1}
    ours, theirs = (make("PRP-ForcePosition-v0", mode, 4, **keywords) for make in (together, one_by_one))
    assert_same(ours.reset(seed=20), theirs.reset(seed=20), "reset")
    when: list[list[float]] = [
        [0, 3, 0, 9],
        [0, 15, 0, 0],
        [27, 0, 0, 2],
        [3, 4, 4, 5],
        [0, 0, 0, 0],
        [5, 0, 6, 0],
        [0] * 4,
    ]
    pulls, ends = np.random.default_rng(1).uniform(-1.0, 1.0, (len(when), 4)), 0
    stepped = np.ones(4, dtype=np.bool_)
    for count, (periods, pull) in enumerate(zip(when, pulls, strict=True)):
        action = np.stack([np.array([violent_in(period) for period in periods]), pull], axis=1)
        found, expected = ours.step(action), theirs.step(action)
        assert_same(found, expected, f"step {count}")
        ends += int(found[2].sum())
        for name in SHOWN if mode != "SameStep" else ():  # there the next episode has begun
            shown, alone = getattr(ours, name), np.array(theirs.get_attr(name))
            assert_same(shown[stepped], alone[stepped], f"{name} {count}")
        ended = found[2] | found[3]
        if mode == "Disabled":
            reset_one_after_the_other(ended, ours, theirs)
        stepped = ~ended | (mode == "Disabled")
    assert ends >= 4


def reset_one_after_the_other(ended: Any, ours: Any, theirs: Any) -> None:
    """Environments that wait for their reset are left as they were."""
    for index in np.flatnonzero(ended):
        mask = np.arange(len(ended)) == index
        again, expected = (env.reset(options={"reset_mask": mask.copy()}) for env in (ours, theirs))
        assert_same(again, expected, f"reset of {index}")


@pytest.mark.usefixtures("late_mode")
def test_state_saved_after_a_divergence_shows_the_same_observation() -> None:
    keywords = {**WILD, "scenario": "realistic", "control_frequency": RATE}
    env = together("PRP-ForcePosition-v0", "Disabled", 2, **keywords)
    env.reset(seed=0)
    seen, _, terminated, *_ = env.step(np.array([[violent_in(3), 1.0], [NEVER, 1.0]]))
    assert terminated.tolist() == [True, False]
    assert_same(env.set_state(env.get_state()), seen, "observation")


@pytest.mark.parametrize("steps", [3, 1000])
def test_limit_of_steps_counts_actions(steps: int) -> None:
    keywords: dict[str, Any] = {"action_mode": "joint_position", "max_episode_steps": steps, "duration": 0.1}
    ours, theirs = (
        make("PRP-JointTracking-v0", num_envs=2, control_frequency=RATE, **keywords)
        for make in (together, one_by_one)
    )
    assert_same(ours.reset(seed=2), theirs.reset(seed=2), "reset")
    for count, action in enumerate(random_actions(ours, 8)):
        assert_same(ours.step(action), theirs.step(action), f"step {count}")
