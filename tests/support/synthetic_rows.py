"""Short episodes of every kind of task with known metrics, and rows of a table made of them."""

import json
from typing import Any

import numpy as np

from prp_gym.artifacts import to_plain
from prp_gym.evaluation import Estimate, Evaluation, Rollout, ScoreSummary
from prp_gym.evaluation.results import describe_evaluation
from prp_gym.evaluation.table import Row
from tests.support.synthetic_episodes import Array, make_rollout

LONGEST_NAME = "operational_inverse_dynamics"
STEPS = np.ones((3, 1))  # two, and the reset


def joints(error: Any = (0.0, 0.0, 0.0)) -> dict[str, Array]:
    """Two steps to a goal of (1 rad, -0.1 m, 1 rad), arrived at once but for given errors."""
    goal = np.array([1.0, -0.1, 1.0])[: len(error)]
    arrived = np.array([[0.0], [1.0], [1.0]])
    return {
        "joint_position": arrived * (goal - np.asarray(error)),
        "joint_velocity": STEPS * np.ones(len(error)),
        "desired_joint_position": STEPS * goal,
    }


def tip(error: Any = (0.003, 0.0, 0.0, 0.004, 0.0, 0.0)) -> dict[str, Array]:
    """A tip that starts 0.1 m along x away from its goal and arrives at once but for an error."""
    away = np.array([[-0.1], [0.0], [0.0]]) * np.eye(6)[0] - np.array([[0.0], [1.0], [1.0]]) * error
    resting = {name: STEPS * np.zeros(6) for name in ("desired_pose", "desired_velocity")}
    measured = {"joint_velocity": STEPS * np.ones(3), "end_effector_velocity": STEPS * 0.1 * np.ones(6)}
    return {**resting, **measured, "end_effector_pose": away}


PRESSING = {"contact_force": np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 0.0]])}
MODEL = {"model_pose": tip()["end_effector_pose"] + np.array([0.0, 0.0, 0.02, 0.0, 0.005, 0.0])}
KINDS: dict[str, dict[str, Array]] = {
    "joint": joints(),
    "link": joints([0.1]),
    "pose": tip(),
    "model": {**tip(), **PRESSING, **MODEL},
    "force": {**tip(), **PRESSING, "desired_force": STEPS * np.array([0.0, 2.0, 0.0])},
}
"""Fields of an episode by kind of task."""

IDS = {
    "joint": "PRP-JointTracking-v0",
    "link": "PRP-Adaptive-v0",
    "pose": "PRP-PoseRegulation-v0",
    "model": "PRP-Admittance-v0",
    "force": "PRP-ForcePosition-v0",
}
"""A task of each kind, whose columns are shown."""


def episode(seed: int = 0, fields: dict[str, Array] = KINDS["joint"], **changes: Any) -> Rollout:
    count = fields["joint_velocity"].shape[-1]
    info = {name: np.zeros(2) for name in ("cost_saturation", "cost_joint_stop", "cost_force_bound")}
    torque = np.zeros((2, count))
    content = {"seed": seed, "applied_torque": torque, "reward": np.full(2, 0.5), "info": info, **changes}
    return make_rollout(fields, count, duration=0.02, compute_time=np.full(2, 42e-6), **content)


def summary(value: float, low: float, high: float) -> ScoreSummary:
    """Scores whose mean and interquartile mean are the same, without failures."""
    estimate = Estimate(value, low, high)
    return ScoreSummary(estimate, estimate, value, np.zeros(4))


def row_of(controller: str, evaluation: Evaluation) -> Row:
    """A row that has been a file's text."""
    return Row.of(
        json.loads(json.dumps(to_plain(describe_evaluation(evaluation, controller, {})), allow_nan=False))
    )


def row(controller: str = LONGEST_NAME, **changes: Any) -> Row:
    return row_of(controller, Evaluation([episode(seed, **changes) for seed in range(3)], 0))
