"""What holds where the parts meet: wrappers and records, gains and rates, masses and springs."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RescaleAction

import prp_gym
from prp_gym.baselines import BASELINES
from prp_gym.baselines.base.gains import gain_sets, load_gains
from prp_gym.envs import PRPEnv
from prp_gym.errors import EpisodeError, InvalidValueError, NonFiniteError, UnknownNameError
from prp_gym.evaluation import record_episode
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.registry import NOT_IN_THE_REPORT

TRACKING = "PRP-JointTracking-v0"


class Half:
    """A policy that always commands the middle of the upper half of the original action range."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        return np.full(3, 0.5, dtype=np.float32), state


def test_recorded_torques_are_those_of_the_actuators_behind_a_wrapper() -> None:
    env = RescaleAction(gymnasium.make(TRACKING, duration=0.1), np.float32(-2), np.float32(2))
    rollout = record_episode(Half(), env, seed=0)
    # 0.5 of [-2, 2] is a quarter of the limits
    np.testing.assert_allclose(rollout.torque, np.tile([12.5, 25.0, 2.5], (50, 1)), rtol=1e-6)  # float32
    np.testing.assert_array_equal(rollout.applied_torque, rollout.torque)


def test_applied_torques_have_delay_and_noise_in_the_realistic_scenario() -> None:
    env = gymnasium.make(TRACKING, scenario="realistic", duration=1.0)
    policy = prp_gym.make_baseline("joint_pd", env)
    rollout = record_episode(policy, env, seed=3)
    late = rollout.applied_torque[1:] - rollout.torque[:-1]
    # 499 samples of white noise of (0.25, 0.5, 0.05): its deviation is known to 3 %, five sigma 16 %
    np.testing.assert_allclose(late.std(axis=0), [0.25, 0.5, 0.05], rtol=0.16)


@pytest.mark.parametrize("controller", ["joint_pd", "joint_inverse_dynamics"])
def test_tuned_gains_are_refused_at_control_frequencies_for_which_they_were_not_tuned(
    controller: str,
) -> None:
    env = gymnasium.make(TRACKING, control_frequency=50)
    with pytest.raises(InvalidValueError, match=r"control_frequency is 50\.0 Hz; allowed: at least 500"):
        prp_gym.make_baseline(controller, env)
    assert prp_gym.make_baseline(controller, env, "tuned_50hz").interface.period == 0.02


def test_every_tuned_set_declares_its_control_frequency() -> None:
    for controller, spec in BASELINES.items():
        rates = {"tuned": 500.0, "tuned_50hz": 50.0}
        declared = {name for name in gain_sets(controller) if name.startswith("tuned")}
        assert declared == set(rates) or (spec.chapter == NOT_IN_THE_REPORT and declared < set(rates))
        for name in declared:
            for environment_id in prp_gym.list_envs():
                # impedance has no motion control inside that would need more, where no search made it stiffer
                numbers = load_gains(controller, name, environment_id)
                slow = controller == "impedance" and not numbers["source"].startswith("prp-gym tune")
                assert numbers["minimum_frequency"] == (50.0 if slow else rates[name])


@pytest.mark.parametrize("scenario", ["randomized", "realistic"])
@pytest.mark.parametrize("controller", ["joint_pd", "joint_inverse_dynamics"])
def test_gains_for_fifty_hertz_neither_diverge_nor_chatter(controller: str, scenario: str) -> None:
    env = gymnasium.make(TRACKING, control_frequency=50, scenario=scenario)
    median = prp_gym.evaluate(prp_gym.make_baseline(controller, env, "tuned_50hz"), env, episodes=6).median
    assert median["divergence"] == 0.0
    assert median["saturation"] < 5.0  # [%]: more would be chatter


def test_springs_do_not_depend_on_how_often_masses_were_drawn() -> None:
    settings, ids, still = PhysicsSettings(surface=True), np.array([0]), np.zeros((1, 3))
    once, often = Physics(settings=settings), Physics(settings=settings)
    for physics in (once, often):
        physics.set_surface(ids, Surface.single(500.0, (0.0, -1.0, 0.0), 0.5))
    for factor in (*np.random.default_rng(0).uniform(0.7, 1.3, 50), 1.1):
        often.set_dynamics(ids, np.full((1, 3), factor), still, still)
    once.set_dynamics(ids, np.full((1, 3), 1.1), still, still)
    np.testing.assert_array_equal(once.model().pair_solref, often.model().pair_solref)
    np.testing.assert_array_equal(once.model().pair_solreffriction, often.model().pair_solreffriction)


def test_torque_of_the_physics_cannot_be_set_without_its_check() -> None:
    physics = Physics()
    with pytest.raises(ValueError, match="read-only"):
        physics.torque[:] = np.nan
    physics.set_torque(np.array([[1.0, 2.0, 3.0]]))
    np.testing.assert_array_equal(physics.torque, [[1.0, 2.0, 3.0]])


def test_misspelt_option_leaves_the_generator_alone() -> None:
    env, twin = (gymnasium.make(TRACKING).unwrapped for _ in range(2))
    env.reset(seed=0)
    twin.reset(seed=0)
    with pytest.raises(UnknownNameError, match="goal"):
        env.reset(seed=1, options={"gaol": (0.0, -0.1, 0.0)})
    np.testing.assert_array_equal(env.reset()[0], twin.reset()[0])


def test_state_of_an_environment_that_was_never_reset_is_refused() -> None:
    env = gymnasium.make(TRACKING).unwrapped
    assert isinstance(env, PRPEnv)
    with pytest.raises(EpisodeError, match=r"get_state\(\) needs an episode"):
        env.get_state()


def test_inverse_kinematics_turns_towards_the_seed_where_the_limits_permit() -> None:
    wide = prp_gym.RobotParameters(joint_lower=(-7.0, -0.3, -7.0), joint_upper=(7.0, 0.0, 7.0))
    arm, q = prp_gym.PRPArm(wide), np.array([5.0, -0.1, -4.5])
    np.testing.assert_allclose(arm.inverse_kinematics(arm.forward_kinematics(q)[:3], q), q, atol=1e-12)
    with pytest.raises(NonFiniteError, match="seed"):
        arm.inverse_kinematics(arm.forward_kinematics(q)[:3], (np.nan, 0.0, 0.0))
