"""One environment among many diverges: it restarts as it would alone, and the others are unaffected."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import EpisodeError
from tests.support.covering import by_turns
from tests.support.vector_episodes import (
    IDS,
    MODES,
    Outcome,
    assert_history,
    assert_same,
    history_of,
    one_by_one,
    outcomes,
    together,
)

N, WILD = 4, 2
GENTLE = 1e-6  # of the limit that stands for none: 1 N m
UNLIMITED: dict[str, Any] = {"torque_limit": None, "control_frequency": 50, "duration": 0.16}
# control frequency [Hz] and action: in 20 ms so violent that MuJoCo meets numbers that are not finite,
# in 2 ms beyond the declared speeds only
VIOLENCE = ((50, 1.0), (500, 0.5))


def keywords(rate: int) -> dict[str, Any]:
    return {"scenario": "realistic", **UNLIMITED, "control_frequency": rate, "duration": 8 / rate}


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """MuJoCo writes warnings of diverging simulations to a file in the working directory."""
    monkeypatch.chdir(tmp_path)


def actions(env: Any, violence: float, count: int = 20) -> Any:
    """Actions (count, N, joints): gentle, but for one environment's in the second step and the sixth."""
    rng = np.random.default_rng(3)
    values = rng.uniform(-GENTLE, GENTLE, (count, *env.action_space.shape))
    values[[1, 5], WILD] = violence
    return values.astype(np.float32)


def run(env: Any, values: Any, mode: str) -> list[list[Outcome]]:
    """What each environment returned; with autoreset disabled those that ended are reset by hand."""
    env.reset(seed=20)
    history = []
    for action in values:
        step = env.step(action)
        history.append(outcomes(step))
        ended = step[2] | step[3]
        if mode == "Disabled" and ended.any():
            env.reset(options={"reset_mask": ended})
    return history


@pytest.mark.parametrize(("environment_id", "mode", "rate_and_violence"), by_turns(IDS, MODES, VIOLENCE))
def test_neighbours_of_an_environment_that_diverges_go_on_to_the_bit(
    environment_id: str, mode: str, rate_and_violence: tuple[int, float]
) -> None:
    rate, violence = rate_and_violence
    env, within_limits = (together(environment_id, mode, N, **keywords(rate)) for _ in range(2))
    values = actions(env, violence)
    found, expected = run(env, values, mode), run(within_limits, actions(within_limits, GENTLE), mode)
    terminated = np.array([[outcome[2] for outcome in step] for step in found])
    assert terminated[:, WILD].sum() >= 1
    assert not np.delete(terminated, WILD, axis=1).any()
    assert not any(outcome[2] for step in expected for outcome in step)
    for index in set(range(N)) - {WILD}:
        assert_history(history_of(found, index), history_of(expected, index), f"environment {index}")


@pytest.mark.parametrize(("rate", "violence"), VIOLENCE)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("environment_id", ["PRP-Adaptive-v0", "PRP-JointTracking-v0", "PRP-Force-v0"])
def test_environment_that_diverges_begins_anew_as_it_does_alone(
    environment_id: str, mode: str, rate: int, violence: float
) -> None:
    ours, theirs = (make(environment_id, mode, N, **keywords(rate)) for make in (together, one_by_one))
    for env in (ours, theirs):
        env.reset(seed=20)
    for count, action in enumerate(actions(ours, violence)):
        found, expected = ours.step(action), theirs.step(action)
        assert_same(found, expected, f"step {count}")
        assert ours.observation_space.contains(found[0])
        ended = found[2] | found[3]
        if mode == "Disabled" and ended.any():
            options = [{"reset_mask": ended}, {"reset_mask": ended}]
            assert_same(ours.reset(options=options[0]), theirs.reset(options=options[1]), f"reset {count}")


def test_all_environments_may_diverge_at_once() -> None:
    ours, theirs = (make("PRP-Impedance-v0", "NextStep", N, **UNLIMITED) for make in (together, one_by_one))
    for env in (ours, theirs):
        env.reset(seed=20)
    for value in (1.0, 1.0, 1e-6, 1.0, 1.0):
        action = np.full((N, 3), value, dtype=np.float32)
        assert_same(ours.step(action), theirs.step(action), "step")


@pytest.mark.parametrize("mode", MODES)
def test_divergence_in_the_last_step_is_a_termination_and_no_truncation(mode: str) -> None:
    env = together("PRP-Impedance-v0", mode, N, **{**UNLIMITED, "duration": 0.04})
    env.reset(seed=20)
    values = actions(env, 1.0)
    env.step(values[0])
    _, reward, terminated, truncated, _ = env.step(values[1])
    assert terminated.tolist() == [False, False, True, False]
    assert truncated.tolist() == [True, True, False, True]
    assert (reward == 0.0).tolist() == terminated.tolist()


def test_step_after_an_end_names_the_environments_that_must_be_reset() -> None:
    env, twin = (together("PRP-PoseTracking-v0", "Disabled", N, **UNLIMITED) for _ in range(2))
    values = actions(env, 1.0)
    for each in (env, twin):
        each.reset(seed=20)
        each.step(values[0])
        assert each.step(values[1])[2].tolist() == [False, False, True, False]
    for _ in range(2):
        with pytest.raises(EpisodeError, match=r"environments \[2\] have ended: reset them \(reset_mask\)"):
            env.step(values[2])
    others = np.array([True, False, False, False])
    env.reset(seed=4, options={"reset_mask": others})
    with pytest.raises(EpisodeError, match=r"environments \[2\]"):
        env.step(values[2])
    env.reset(seed=4, options={"reset_mask": ~others})
    twin.reset(seed=4)
    assert_same(env.step(values[2]), twin.step(values[2]), "step")


def test_torques_of_diverged_environments_are_numbers() -> None:
    env = together("PRP-JointRegulation-v0", "NextStep", N, **UNLIMITED)
    env.reset(seed=20)
    for action in actions(env, 1.0)[:2]:
        env.step(action)
    assert np.isfinite(env.applied_torque).all()
    assert np.isfinite(env.commanded_torque).all()


@pytest.mark.parametrize("mode", MODES)
def test_divergence_writes_nothing_where_the_process_runs(
    mode: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    env = together("PRP-Force-v0", mode, N, **UNLIMITED)
    found = run(env, actions(env, 1.0), mode)
    assert any(step[WILD][2] for step in found)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")
