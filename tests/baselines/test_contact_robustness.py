"""The controller of each contact task, with `tuned` gains, on 30 episodes of the scenario `randomized`.

Surfaces of 50 to 5000 N/m lie anywhere in reach. These are properties of the controllers, not closed
forms: each bound says what it would mean to break it.
"""

from contextlib import closing

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym
from prp_gym.evaluation import Evaluation, evaluate
from prp_gym.evaluation.rollout import Rollout

Array = NDArray[np.float64]

TASK_CONTROLLER = {
    "PRP-Compliance-v0": "compliance",
    "PRP-Impedance-v0": "impedance",
    "PRP-Admittance-v0": "admittance",
    "PRP-Force-v0": "force_inner_position",
    "PRP-ForcePosition-v0": "parallel_force_position",
}
MOTION_CONTROLLERS = (
    "joint_pd",
    "joint_inverse_dynamics",
    "adaptive",
    "operational_pd",
    "operational_inverse_dynamics",
)
SEEDS = 30
DURATION = 3.5  # s, of which the references take up to 1.5 s


def evaluated(environment_id: str, controller: str) -> Evaluation:
    with closing(gymnasium.make(environment_id, scenario="randomized", duration=DURATION)) as env:
        return evaluate(prp_gym.make_baseline(controller, env), env, SEEDS, seed=0)


def force_of(rollout: Rollout) -> Array:
    """Magnitude of the contact force over the last second (T) [N]."""
    force: Array = np.linalg.norm(rollout.fields["contact_force"], axis=-1)[rollout.time >= DURATION - 1.0]
    return force


def assert_stable(environment_id: str, rollout: Rollout) -> None:
    assert not rollout.diverged
    force = force_of(rollout)
    # a tip that bounces, or a loop that rings on, is on the surface and off it, or swings the force
    steady = (force > 0.0).all() or (force == 0.0).all()
    assert steady or environment_id == "PRP-Admittance-v0", rollout.seed
    assert np.ptp(force[len(force) // 2 :]) <= 0.05 * force.max() + 0.01, rollout.seed


def assert_off_the_stops(rollout: Rollout) -> None:
    at_stop = rollout.info["cost_joint_stop"] > 0
    hits = np.count_nonzero(at_stop[1:] & ~at_stop[:-1])
    assert hits <= 1, rollout.seed  # one touch is a touch, more are hammering


@pytest.mark.parametrize(
    ("environment_id", "motion_controller"), list(zip(TASK_CONTROLLER, MOTION_CONTROLLERS, strict=True))
)
def test_controller_of_the_task_is_stable_on_every_seed_keeps_off_the_stops_and_beats_a_motion_controller(
    environment_id: str, motion_controller: str
) -> None:
    """Every task, and every motion controller, once; one test, so that the task's own runs once."""
    own = evaluated(environment_id, TASK_CONTROLLER[environment_id])
    assert len(own.rollouts) == SEEDS
    for rollout in own.rollouts:
        assert_stable(environment_id, rollout)
        assert_off_the_stops(rollout)
    asks_for_force = environment_id in ("PRP-Force-v0", "PRP-ForcePosition-v0")
    assert ("force_settling_time" in own.metrics) == asks_for_force
    if asks_for_force:  # the estimated stiffness settles on it
        assert np.isfinite(own.metrics["force_settling_time"][:, 0]).mean() >= 0.95
    score = own.metrics["score"]
    other = evaluated(environment_id, motion_controller).metrics["score"]
    assert score.mean() > other.mean()
    assert (score > other).mean() > 0.95  # and not by a few lucky seeds
