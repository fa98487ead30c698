"""Whether the reward orders policies as the physical errors do that it stands for."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from prp_gym.comparison.statistics import score_of
from prp_gym.comparison.values import Entry, Place
from prp_gym.errors import ShapeError
from prp_gym.robot.arrays import Array

LEAST_CORRELATION = 0.8
"""Rank correlation below which a reward is flagged."""


@dataclass(frozen=True)
class Gauge:
    """The physical error of a task: the norm of some metrics, each in units of what counts as much as others.

    Attributes:
        parts: by metric, the values of its components that count the same.
        ties: the same for policies that are equal in the median of `parts`, as those that never settle;
            empty for none.
        reason: why it is this error.
    """

    parts: Mapping[str, tuple[float, ...]]
    reason: str
    ties: Mapping[str, tuple[float, ...]]

    @property
    def name(self) -> str:
        """For tables."""
        text = " + ".join(self.parts)
        return f"{text}, then {' + '.join(self.ties)}" if self.ties else text


_JOINTS = (0.02, 0.01, 0.042)
"""[rad, m, rad]: each moves the tip by about 1 cm, joint 1 being 0.5 m and joint 3 a_3 = 0.24 m from it."""

_ANGLES = (0.042,)
"""[rad]: what turns the last link by as much as moves the tip by 1 cm."""

_CENTIMETRE = (0.01,)
_MODEL = {"model_position_rmse": _CENTIMETRE, "model_orientation_rmse": _ANGLES}
_FORCE = {"force_rmse": (1.0,), "orientation_rmse": _ANGLES}
_MODEL_REASON = "the task asks for the motion of the reference model that the measured force drives"
_FORCE_REASON = (
    "the desired force and the angles; the tip's distance to x_d is left out, as pressing moves it off x_d"
    " along the normal"
)
_TRACKING_REASON = "the task asks for small errors at all times"
_SETTLING_REASON = (
    "how soon the goal is kept for good, and how far off it is by those that never settle; the root mean"
    " square tells of the first distance rather than of the policy"
)

GAUGES: Mapping[str, Gauge] = {
    "PRP-JointRegulation-v0": Gauge(
        {"settling_time": (1.0,)}, _SETTLING_REASON, {"steady_state_error": _JOINTS}
    ),
    "PRP-JointTracking-v0": Gauge({"joint_rmse": _JOINTS}, _TRACKING_REASON, {}),
    "PRP-Adaptive-v0": Gauge({"joint_rmse": (1.0,)}, _TRACKING_REASON, {}),
    "PRP-PoseRegulation-v0": Gauge(
        {"position_settling_time": (1.0,)}, _SETTLING_REASON, {"position_steady_state_error": _CENTIMETRE}
    ),
    "PRP-PoseTracking-v0": Gauge(
        {"position_rmse": _CENTIMETRE, "orientation_rmse": _ANGLES},
        _TRACKING_REASON,
        {},
    ),
    "PRP-Compliance-v0": Gauge(_MODEL, _MODEL_REASON, {}),
    "PRP-Impedance-v0": Gauge(_MODEL, _MODEL_REASON, {}),
    "PRP-Admittance-v0": Gauge(_MODEL, _MODEL_REASON, {}),
    "PRP-Force-v0": Gauge(_FORCE, _FORCE_REASON, {}),
    "PRP-ForcePosition-v0": Gauge(_FORCE, _FORCE_REASON, {}),
}
"""The physical error of each environment, chosen without regard to how its reward is built."""


def average_ranks(values: Array) -> Array:
    """Ranks from 0, equal values sharing the mean of theirs: (n) -> (n)."""
    _, index, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts) - 1
    ranks: Array = (last - (counts - 1) / 2.0)[index]
    return ranks


def rank_correlation(x: Array, y: Array) -> float:
    """Spearman's rank correlation, ties having average ranks; NaN where all of x or all of y are equal.

    Args:
        x: (n), infinite values allowed.
        y: (n), likewise.

    Raises:
        ShapeError: not as many values of y as of x.

    Source: Spearman 1904.
    """
    if np.shape(x) != np.shape(y):
        raise ShapeError("y", np.shape(y), f"{np.shape(x)}, as x")
    first, second = (average_ranks(values) - (len(values) - 1) / 2.0 for values in (x, y))
    norm = np.sqrt((first @ first) * (second @ second))
    return float(first @ second / norm) if norm > 0.0 else float("nan")


def physical_error(entry: Entry, gauge: Gauge) -> tuple[float, float]:
    """Median over the episodes of a policy's error, and of that which decides between equal ones.

    An episode that diverged has an infinite error, and so has one without the metric.

    Args:
        entry: a policy at a place.
        gauge: of the place's environment.
    """
    return _median_norm(entry, gauge.parts), _median_norm(entry, gauge.ties)


def _median_norm(entry: Entry, parts: Mapping[str, tuple[float, ...]]) -> float:
    squares = [
        ((entry.metrics[name] / np.array(scale)[: entry.metrics[name].shape[-1]]) ** 2).sum(axis=-1)
        for name, scale in parts.items()
    ]
    if not squares:
        return 0.0
    error = np.sqrt(np.sum(squares, axis=0))
    return float(np.median(np.where(np.isnan(error), np.inf, error)))


@dataclass(frozen=True)
class Audit:
    """Reward against physical error at a place.

    Attributes:
        environment_id: of the place.
        scenario: of the place.
        measure: name of the physical error.
        policies: by name, score, error, and the error that decides between equal ones.
        correlation: Spearman's, between score and smallness of the error; 1 if both order alike.
    """

    environment_id: str
    scenario: str
    measure: str
    policies: Mapping[str, tuple[float, float, float]]
    correlation: float

    @property
    def flagged(self) -> bool:
        """Whether the correlation is too low, or is none."""
        return not self.correlation >= LEAST_CORRELATION


def audit_rewards(places: Iterable[Place]) -> list[Audit]:
    """An audit of every place over all its policies, the bad ones included.

    Args:
        places: with their policies.
    """
    return [_audit(place, GAUGES[place.environment_id]) for place in places]


def _audit(place: Place, gauge: Gauge) -> Audit:
    errors = [physical_error(entry, gauge) for entry in place.entries]
    scores = [score_of(entry) for entry in place.entries]
    correlation = rank_correlation(np.array(scores), -_order(errors))
    policies = {
        entry.policy: (score, *error)
        for entry, score, error in zip(place.entries, scores, errors, strict=True)
    }
    return Audit(place.environment_id, place.scenario, gauge.name, policies, correlation)


def _order(errors: Sequence[tuple[float, float]]) -> Array:
    """Numbers in the order of the errors, equal where these are."""
    place = {error: index for index, error in enumerate(sorted(set(errors)))}
    return np.array([place[error] for error in errors], dtype=np.float64)
