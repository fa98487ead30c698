"""The law made for a contact task, with `tuned` gains, on 50 episodes of the scenario `randomized`.

Surfaces of 50 to 5000 N/m lie anywhere in reach. These are properties of the laws, not closed forms: each
bound says what it would mean to break it.
"""

from contextlib import closing
from functools import cache

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym
from prp_gym.evaluation import Evaluation, evaluate
from prp_gym.evaluation.rollout import Rollout

Array = NDArray[np.float64]

OWN_LAW = {
    "PRP-Compliance-v0": "compliance",
    "PRP-Impedance-v0": "impedance",
    "PRP-Admittance-v0": "admittance",
    "PRP-Force-v0": "force_inner_position",
    "PRP-ForcePosition-v0": "parallel_force_position",
}
MOTION_LAWS = (
    "joint_pd",
    "joint_inverse_dynamics",
    "adaptive",
    "operational_pd",
    "operational_inverse_dynamics",
)
SEEDS = 50


@cache
def played(environment_id: str, law: str) -> Evaluation:
    with closing(gymnasium.make(environment_id, scenario="randomized")) as env:
        return evaluate(prp_gym.make_baseline(law, env), env, SEEDS, seed=0)


@pytest.fixture(params=OWN_LAW, ids=str)
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def force_of(rollout: Rollout) -> Array:
    """Magnitude of the contact force over the last second (T) [N]."""
    force: Array = np.linalg.norm(rollout.fields["contact_force"], axis=-1)[rollout.time >= 4.0]
    return force


def test_law_of_the_task_is_stable_on_every_seed(environment_id: str) -> None:
    for rollout in played(environment_id, OWN_LAW[environment_id]).rollouts:
        assert not rollout.diverged
        force = force_of(rollout)
        # a tip that bounces, or a loop that rings on, is on the surface and off it, or swings the force
        assert (force > 0.0).all() or (force == 0.0).all() or environment_id == "PRP-Admittance-v0", (
            rollout.seed
        )
        assert np.ptp(force[len(force) // 2 :]) <= 0.05 * force.max() + 0.01, rollout.seed


def test_law_of_the_task_keeps_off_the_joint_stops(environment_id: str) -> None:
    for rollout in played(environment_id, OWN_LAW[environment_id]).rollouts:
        at_stop = rollout.info["cost_joint_stop"] > 0
        hits = np.count_nonzero(at_stop[1:] & ~at_stop[:-1])
        assert hits <= 1, rollout.seed  # one touch is a touch, more are hammering


@pytest.mark.parametrize("law", MOTION_LAWS)
def test_law_of_the_task_beats_every_motion_law(environment_id: str, law: str) -> None:
    own, other = (played(environment_id, name).metrics["score"] for name in (OWN_LAW[environment_id], law))
    assert own.mean() > other.mean()
    assert (own > other).mean() > 0.95  # and not by a few lucky seeds


@pytest.mark.parametrize("environment_id", ["PRP-Force-v0", "PRP-ForcePosition-v0"], indirect=True)
def test_estimated_stiffness_settles_on_the_force_on_nearly_every_seed(environment_id: str) -> None:
    settled = played(environment_id, OWN_LAW[environment_id]).metrics["force_settling_time"][:, 0]
    assert np.isfinite(settled).mean() >= 0.95
