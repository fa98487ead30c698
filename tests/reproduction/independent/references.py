"""The references of the experiments: functions of time that return position, velocity and acceleration."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from tests.reproduction.independent.arm import Array, ReportArm

Motion = tuple[Array, Array, Array]
Path = Callable[[float], Motion]
Point = Sequence[float] | Array

HOME = (0.0, 0.0, 0.0)
GOAL = (math.pi / 2, -0.2, math.pi)
WAYPOINTS = (
    (math.pi / 3, -0.2, math.pi / 3),
    (-math.pi / 3, -0.1, math.pi / 4),
    (0.0, -0.2, 0.0),
    (math.pi / 2, 0.0, -math.pi / 4),
    (math.pi / 3, -0.1, math.pi / 4),
    HOME,
)
TIMES = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0)


def constant(position: Point) -> Path:
    """A point at rest."""
    point, rest = np.array(position), np.zeros(len(position))
    return lambda time: (point, rest, rest)


def sine(center: Sequence[float], amplitude: float, rate: float) -> Path:
    """center + amplitude sin(rate t) in every component."""
    middle = np.array(center)

    def at(time: float) -> Motion:
        s, c = amplitude * math.sin(rate * time), amplitude * math.cos(rate * time)
        ones = np.ones(len(middle))
        return middle + s * ones, rate * c * ones, -(rate**2) * s * ones

    return at


def square(rate: float) -> Path:
    """A unit acceleration of the sign of cos(rate t), integrated exactly from rest at 0."""
    quarter = math.pi / 2 / rate

    def at(time: float) -> Motion:
        x, v, a, left = 0.0, 0.0, 1.0, time
        stretch = quarter
        while left > stretch:
            x, v, a, left = x + v * stretch + a * stretch**2 / 2, v + a * stretch, -a, left - stretch
            stretch = 2 * quarter
        return np.array([x + v * left + a * left**2 / 2]), np.array([v + a * left]), np.array([a])

    return at


def quintic(times: Sequence[float], points: Sequence[Point]) -> Path:
    """Polynomials of degree 5 that rest at every point, from linear systems of equations."""
    segments = []
    for (begin, end), (first, last) in zip(pairwise(times), pairwise(points), strict=True):
        conditions, T = np.zeros((6, 6)), end - begin
        for row, t in ((0, 0.0), (3, T)):
            conditions[row] = [t**k for k in range(6)]
            conditions[row + 1] = [k * t ** max(k - 1, 0) for k in range(6)]
            conditions[row + 2] = [k * (k - 1) * t ** max(k - 2, 0) for k in range(6)]
        rest = np.zeros(len(first))
        values = np.array([first, rest, rest, last, rest, rest])
        segments.append((begin, end, np.linalg.solve(conditions, values)))

    def at(time: float) -> Motion:
        inside = min(max(time, times[0]), times[-1])
        begin, _, c = next(part for part in segments if inside <= part[1])
        t = inside - begin
        powers = np.array([t**k for k in range(6)])
        rates = np.array([k * t ** max(k - 1, 0) for k in range(6)])
        bends = np.array([k * (k - 1) * t ** max(k - 2, 0) for k in range(6)])
        return powers @ c, rates @ c, bends @ c

    return at


def pose_path(arm: ReportArm, joints: Path) -> Path:
    """The motion of the end effector that a motion of the joints causes."""

    def at(time: float) -> Motion:
        q, v, a = joints(time)
        tip = arm.tip(q, v)
        return tip.pose, tip.jacobian @ v, tip.jacobian @ a + tip.drift

    return at


def pose_quintic(arm: ReportArm, times: Sequence[float], points: Sequence[Sequence[float]]) -> Path:
    """Quintics of the pose through the poses of joint positions."""
    return quintic(times, [arm.tip(np.array(point), np.zeros(3)).pose for point in points])
