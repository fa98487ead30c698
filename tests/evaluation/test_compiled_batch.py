"""Whole episodes in compiled code: every number that is recorded is that of the loop of control periods."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from gymnasium.wrappers import RescaleAction, TimeLimit

from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.baselines.base.gains import load_gains
from prp_gym.envs import PRPEnv
from prp_gym.evaluation import compiled_batch, evaluate, record_episode
from prp_gym.evaluation.batch import record_episodes
from prp_gym.evaluation.compiled_batch import begin, record_compiled
from prp_gym.evaluation.compiled_controller import CompiledController
from prp_gym.tasks import SCENARIOS
from tests.support.compiled_episodes import assert_same_episodes, compiled, looped, made
from tests.support.compiler import needs_compiler
from tests.support.controller_episodes import COMBINATIONS

pytestmark = [needs_compiler, pytest.mark.usefixtures("timed_once")]

BRIEF = 0.08  # duration [s]: 40 periods, in which a start in contact, delays and integrators show
TRACKING = "PRP-JointTracking-v0"


@cache
def brief(environment_id: str, scenario: str) -> Any:
    return made(environment_id, scenario, duration=BRIEF)


TRACED = [
    (environment_id, name) for environment_id, name in COMBINATIONS if CONTROLLERS.find(name).policy.compiled
]


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(("environment_id", "name"), TRACED)
def test_every_controller_on_every_task_has_the_episodes_of_the_loop(
    environment_id: str, name: str, scenario: str
) -> None:
    env = brief(environment_id, scenario)
    policy, seeds = make_baseline(name, env), (3,) if env.task.scenario.deterministic else (3, 8)
    found = compiled(policy, env, seeds)
    assert_same_episodes(found, looped(policy, env, seeds))
    assert [rollout.seed for rollout in found] == list(seeds)
    for rollout in found:
        assert len(rollout.reward) == 40
        assert np.ptp(rollout.fields["joint_velocity"], axis=0).all()


def test_only_the_optimising_controller_is_run_period_by_period() -> None:
    assert {name for _, name in COMBINATIONS} - {name for _, name in TRACED} == {"model_predictive"}
    env = brief(TRACKING, "randomized")
    assert record_compiled(make_baseline("model_predictive", env), env, (3,)) is None


LONG = [
    ("PRP-Adaptive-v0", "randomized", "adaptive", 5.0),
    ("PRP-Force-v0", "realistic", "parallel_force_position", 1.5),
    ("PRP-ForcePosition-v0", "randomized", "force_inner_position", 1.5),
    ("PRP-Impedance-v0", "realistic", "impedance", 1.5),
]


@pytest.mark.parametrize(("environment_id", "scenario", "name", "duration"), LONG)
def test_long_episodes_are_those_of_the_loop(
    environment_id: str, scenario: str, name: str, duration: float
) -> None:
    """With contact that begins on the way, several windows of the reference and several blocks of noise."""
    env = made(environment_id, scenario, duration=duration)
    policy = make_baseline(name, env)
    found = compiled(policy, env, range(3))
    assert_same_episodes(found, looped(policy, env, range(3)))
    assert {len(rollout.reward) for rollout in found} == {round(500 * duration)}
    for rollout in found:
        force = rollout.info.get("contact_force")
        assert force is None or (force[0] == 0.0 and force[-1] > 0.0)


SATURATED = [
    (TRACKING, "joint_inverse_dynamics", (4.0, 20.0, 0.6)),
    ("PRP-PoseTracking-v0", "operational_inverse_dynamics", (4.0, 20.0, 0.6)),
    ("PRP-Force-v0", "force_inner_position", (4.0, 20.0, 0.6)),
]


@pytest.mark.parametrize(("environment_id", "name", "limit"), SATURATED)
def test_integrators_are_held_at_the_actuator_limits(
    environment_id: str, name: str, limit: tuple[float, ...]
) -> None:
    env = made(environment_id, "randomized", duration=0.4, torque_limit=limit)
    policy = make_baseline(name, env)
    found = compiled(policy, env, range(4))
    assert_same_episodes(found, looped(policy, env, range(4)))
    shares = [float((rollout.info["cost_saturation"] > 0.0).mean()) for rollout in found]
    assert 0.02 < np.mean(shares) < 0.98
    wound = type("WoundUp", (type(policy),), {"integrators": ()})(policy.interface, policy.settings)
    others = compiled(wound, env, range(4))
    assert any((one.torque != other.torque).any() for one, other in zip(found, others, strict=True))


@pytest.mark.parametrize(("name", "gains"), [("joint_pd", "figures"), ("adaptive", "report")])
def test_episodes_that_diverge_end_as_those_of_the_loop(name: str, gains: str) -> None:
    limit = (5e3, 1e4, 1e3)  # with the nominal limits and stops the unstable arm only rattles
    env = made(TRACKING, duration=2.0, control_frequency=50, torque_limit=limit)
    numbers = load_gains(name, gains, TRACKING)
    # with all gains given, any control frequency is allowed
    own = {setting: numbers[setting] for setting in CONTROLLERS[name].settings_class.vectors}
    policy = make_baseline(name, env, gains, **own)
    found = compiled(policy, env, range(8))
    assert_same_episodes(found, looped(policy, env, range(8)))
    ended = [rollout for rollout in found if rollout.diverged]
    assert len(ended) >= 5
    assert len({len(rollout.reward) for rollout in found}) >= 4  # others go on when the first has ended
    for rollout in ended:
        assert len(rollout.reward) < 100
        assert rollout.reward[-1] == 0.0
        assert rollout.reward[:-1].all()


COUNTS = (1, 3, 64, 65)


def test_the_number_of_episodes_does_not_change_them() -> None:
    env = brief("PRP-Force-v0", "realistic")
    policy = make_baseline("parallel_force_position", env)
    whole = record_episodes(policy, env, range(5, 5 + COUNTS[-1]))
    for count in COUNTS[:-1]:
        assert_same_episodes(record_episodes(policy, env, range(5, 5 + count)), whole[:count])
    assert_same_episodes(compiled(policy, env, [69]), whole[64:])
    assert_same_episodes(looped(policy, env, range(5, 8)), whole[:3])


def test_threads_do_not_change_the_episodes(monkeypatch: pytest.MonkeyPatch) -> None:
    env = brief("PRP-Force-v0", "realistic")
    policy = make_baseline("parallel_force_position", env)
    alone, loops = compiled(policy, env, range(200)), []

    def with_threads(count: int) -> Any:
        loops.append(env.new_loop(count, 3))
        return loops[-1]

    monkeypatch.setattr(env, "make_loop", with_threads)
    assert_same_episodes(compiled(policy, env, range(200)), alone)
    assert [loop.physics._threads is not None for loop in loops if loop.num_envs == 200] == [True]


def test_controllers_with_other_gains_share_their_compiled_code() -> None:
    env = brief(TRACKING, "realistic")
    _, _, observation = begin(env.make_loop, (1,))
    soft, stiff = (make_baseline("joint_pd", env, proportional_gain=gain) for gain in (50.0, 90.0))
    functions = [CompiledController(policy, observation) for policy in (soft, stiff)]
    assert functions[0].function.value == functions[1].function.value
    assert (functions[0].numbers != functions[1].numbers).any()
    for policy in (soft, stiff):
        assert_same_episodes(compiled(policy, env, (1, 2)), looped(policy, env, (1, 2)))


def test_evaluations_run_in_compiled_code_and_leave_the_environment_alone() -> None:
    env, twin = (made(TRACKING, duration=BRIEF) for _ in range(2))
    policy, heard = make_baseline("joint_pd", env), []
    for each in (env, twin):
        each.reset(seed=4)
    found = evaluate(policy, env, episodes=3, seed=7, on_episode=lambda: heard.append(1))
    assert len(heard) == 3
    assert_same_episodes(found.rollouts, compiled(policy, env, (7, 8, 9)))
    assert all((rollout.compute_time > 0.0).all() for rollout in found.rollouts)
    np.testing.assert_array_equal(env.step(np.ones(3))[0], twin.step(np.ones(3))[0])


class HalfTorque(PRPEnv):
    """Steps in its own way."""

    def step(self, action: Any) -> Any:
        return super().step(0.5 * np.asarray(action))


BOUND = np.full(3, 2.0, dtype=np.float32)
ORDINARY: dict[str, Callable[[], Any]] = {
    "action_mode": lambda: made(TRACKING, duration=BRIEF, action_mode="joint_position"),
    "time_limit": lambda: TimeLimit(made(TRACKING, duration=BRIEF), 10),
    "rescaled_action": lambda: RescaleAction(made(TRACKING, duration=BRIEF), -BOUND, BOUND),
    "own_step": lambda: HalfTorque(TRACKING, engine="compiled", scenario="realistic", duration=BRIEF),
}


@pytest.mark.parametrize("name", ORDINARY)
def test_what_compiled_code_cannot_run_is_run_as_before(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled_batch, "CompiledController", lambda *_: pytest.fail("compiled"))
    env, policy = ORDINARY[name](), make_baseline("joint_pd", brief(TRACKING, "realistic"))
    found = evaluate(policy, env, episodes=2, seed=1).rollouts
    assert_same_episodes(found, [record_episode(policy, env, seed) for seed in (1, 2)])
