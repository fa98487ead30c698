"""The law made for a contact task, with `tuned` gains, on 50 episodes of the scenario `randomized`.

Surfaces of 50 to 5000 N/m lie anywhere in reach. These are properties of the laws, not closed forms: each
bound says what it would mean to break it.
"""

from contextlib import closing

import gymnasium
import numpy as np
import pytest
from _pytest.mark import ParameterSet
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


def play(environment_id: str, law: str) -> Evaluation:
    with closing(gymnasium.make(environment_id, scenario="randomized")) as env:
        return evaluate(prp_gym.make_baseline(law, env), env, SEEDS, seed=0)


def on_one_worker(*names: str) -> list[ParameterSet]:
    """Environments whose tests follow each other on one worker, so that the task's law is played once."""
    return [pytest.param(name, id=name, marks=pytest.mark.xdist_group(name)) for name in names]


@pytest.fixture(params=on_one_worker(*OWN_LAW), scope="module")
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def own(environment_id: str) -> Evaluation:
    """The law of the task, played once for all tests of the environment."""
    return play(environment_id, OWN_LAW[environment_id])


def force_of(rollout: Rollout) -> Array:
    """Magnitude of the contact force over the last second (T) [N]."""
    force: Array = np.linalg.norm(rollout.fields["contact_force"], axis=-1)[rollout.time >= 4.0]
    return force


def test_law_of_the_task_is_stable_on_every_seed(environment_id: str, own: Evaluation) -> None:
    for rollout in own.rollouts:
        assert not rollout.diverged
        force = force_of(rollout)
        # a tip that bounces, or a loop that rings on, is on the surface and off it, or swings the force
        assert (force > 0.0).all() or (force == 0.0).all() or environment_id == "PRP-Admittance-v0", (
            rollout.seed
        )
        assert np.ptp(force[len(force) // 2 :]) <= 0.05 * force.max() + 0.01, rollout.seed


def test_law_of_the_task_keeps_off_the_joint_stops(own: Evaluation) -> None:
    for rollout in own.rollouts:
        at_stop = rollout.info["cost_joint_stop"] > 0
        hits = np.count_nonzero(at_stop[1:] & ~at_stop[:-1])
        assert hits <= 1, rollout.seed  # one touch is a touch, more are hammering


@pytest.mark.parametrize("law", MOTION_LAWS)
def test_law_of_the_task_beats_every_motion_law(environment_id: str, law: str, own: Evaluation) -> None:
    score, other = own.metrics["score"], play(environment_id, law).metrics["score"]
    assert len(score) == len(other) == SEEDS
    assert score.mean() > other.mean()
    assert (score > other).mean() > 0.95  # and not by a few lucky seeds


@pytest.mark.parametrize(
    "environment_id", on_one_worker("PRP-Force-v0", "PRP-ForcePosition-v0"), indirect=True, scope="module"
)
def test_estimated_stiffness_settles_on_the_force_on_nearly_every_seed(own: Evaluation) -> None:
    settled = own.metrics["force_settling_time"][:, 0]
    assert np.isfinite(settled).mean() >= 0.95
