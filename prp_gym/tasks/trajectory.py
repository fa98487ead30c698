"""Reference trajectories: position, velocity and acceleration at any time, for N environments.

A position has d components: the joints [rad, m, rad], one joint, or a pose [m, m, m, rad, rad, rad].
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import as_array, bounded, check_finite
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array, zeros

_LEAST_INTERVAL = 1e-9  # s
_FREQUENCIES = (1e-9, 1e12)  # rad/s


@cache
def _names(kind: "type[Trajectory]") -> tuple[str, ...]:
    """The names of a kind's attributes, in order."""
    return tuple(entry.name for entry in fields(kind))


@dataclass(frozen=True, eq=False)
class Trajectory(ABC):
    """N trajectories of one kind; every attribute is an array with N rows.

    The trajectory of a new episode replaces that of the last one with `assign`.

    Raises:
        InvalidValueError: attributes that are not numbers, or are too large or too small to be computed with.
        NonFiniteError: NaN or infinity.
        ShapeError: attributes of other shapes.
    """

    def __post_init__(self) -> None:
        for name in _names(type(self)):
            given = getattr(self, name)
            numbers = as_array(name, given)
            check_finite(name, numbers)
            if numbers is not given:
                object.__setattr__(self, name, numbers)
        self._check_shapes()

    def _check_shapes(self) -> None:
        """Refuse attributes that are not (N, d) alike, N at least 1."""
        expected: tuple[int, ...] | None = None
        for name in _names(type(self)):
            shape = getattr(self, name).shape
            if len(shape) != 2 or not shape[0] or shape != (expected or shape):
                raise ShapeError(name, shape, f"{expected or '(N, d)'}")
            expected = shape

    @abstractmethod
    def sample(self, time: Array) -> Array:
        """The trajectories at given times.

        Args:
            time: Time since the start of each episode (..., N) [s].

        Returns:
            Position (d), velocity (d) per second and acceleration (d) per second squared (..., N, 3d).

        Raises:
            InvalidValueError: times that are not numbers.
            NonFiniteError: NaN or infinity.
            ShapeError: times for another number of trajectories.
        """

    def _times(self, time: object) -> Array:
        """Times (..., N) as numbers; of one trajectory, times of any shape."""
        times, count = as_array("time", time, "s"), len(getattr(self, _names(type(self))[0]))
        check_finite("time", times, "s")
        if times.ndim == 0 or count not in (1, times.shape[-1]):
            raise ShapeError("time", times.shape, f"(..., {count})")
        return times

    @property
    @abstractmethod
    def is_constant(self) -> bool:
        """Whether the trajectory never moves."""

    @property
    @abstractmethod
    def goal(self) -> Array:
        """The position where the trajectory ends or about which it moves (N, d)."""

    def rows(self, ids: NDArray[np.intp]) -> Self:
        """The trajectories of some rows, as copies."""
        taken = object.__new__(type(self))  # without the checks, which all rows have passed
        vars(taken).update({name: values[ids] for name, values in vars(self).items()})
        return taken

    def assign(self, ids: NDArray[np.intp], rows: Self) -> None:
        """Replace some rows."""
        own, others = vars(self), vars(rows)
        for name in _names(type(self)):
            own[name][ids] = others[name]


@dataclass(frozen=True, eq=False)
class Constant(Trajectory):
    """A constant position.

    Attributes:
        position: Position (N, d).
    """

    position: Array

    def sample(self, time: Array) -> Array:
        """See `Trajectory.sample`."""
        time = self._times(time)
        size = self.position.shape[-1]
        values = zeros((*time.shape, 3 * size), self.position)
        values[..., :size] = self.position
        return values

    @property
    def is_constant(self) -> bool:
        """See `Trajectory.is_constant`: always true."""
        return True

    @property
    def goal(self) -> Array:
        """The position."""
        return self.position


@dataclass(frozen=True, eq=False)
class Sine(Trajectory):
    """center + amplitude sin(angular_frequency t + phase), per component.

    Attributes:
        center: Mean position (N, d).
        amplitude: Amplitude of each component (N, d).
        angular_frequency: Angular frequency of each component (N, d) [rad/s].
        phase: Phase at t = 0 of each component (N, d) [rad].
    """

    center: Array
    amplitude: Array
    angular_frequency: Array
    phase: Array

    def sample(self, time: Array) -> Array:
        """See `Trajectory.sample`."""
        time = self._times(time)
        angle = self.angular_frequency * time[..., None] + self.phase
        sine, cosine = self.amplitude * np.sin(angle), self.amplitude * np.cos(angle)
        rate = self.angular_frequency
        return np.concatenate([self.center + sine, rate * cosine, -(rate**2) * sine], axis=-1)

    @property
    def is_constant(self) -> bool:
        """Whether no joint moves."""
        return not np.any(self.amplitude)

    @property
    def goal(self) -> Array:
        """The centre."""
        return self.center


@dataclass(frozen=True, eq=False)
class SquareAcceleration(Trajectory):
    """Acceleration of constant magnitude whose sign is that of cos(angular_frequency t); at rest at t = 0.

    Velocity is a triangle wave about zero, so that the position returns to the start in every period.

    Attributes:
        start: Initial position (N, d).
        magnitude: Magnitude of the acceleration (N, d) per second squared.
        angular_frequency: Angular frequency of each component (N, d) [rad/s].
    """

    start: Array
    magnitude: Array
    angular_frequency: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        bounded("angular_frequency", self.angular_frequency, _FREQUENCIES, "rad/s")

    def sample(self, time: Array) -> Array:
        """See `Trajectory.sample`."""
        time = self._times(time)
        quarter = np.pi / 2 / self.angular_frequency
        phase = time[..., None] / quarter % 4.0  # in quarters of a period
        sign = np.where((phase < 1.0) | (phase >= 3.0), 1.0, -1.0)
        peak = self.magnitude * quarter
        velocity = peak * (1.0 - np.abs((phase + 1.0) % 4.0 - 2.0))
        rising, back = np.minimum(phase, 1.0), np.clip(phase - 1.0, 0.0, 2.0)
        last = np.maximum(phase - 3.0, 0.0)
        covered = rising**2 / 2 + back - back**2 / 2 - last + last**2 / 2
        return np.concatenate(
            [self.start + peak * quarter * covered, velocity, sign * self.magnitude], axis=-1
        )

    @property
    def is_constant(self) -> bool:
        """Whether no component moves."""
        return not np.any(self.magnitude)

    @property
    def goal(self) -> Array:
        """The middle of the motion."""
        middle: Array = self.start + self.magnitude * (np.pi / 2 / self.angular_frequency) ** 2 / 2
        return middle


@dataclass(frozen=True, eq=False)
class QuinticWaypoints(Trajectory):
    """Quintic segments that rest (zero velocity and acceleration) at every waypoint.

    The first waypoint is held before its time, the last one after its time.

    Attributes:
        times: Times of the waypoints (N, K), strictly increasing [s].
        positions: Positions of the waypoints (N, K, d).

    Raises:
        InvalidValueError: fewer than two waypoints, or times that do not increase.

    Source: [S] 4.2.2; boundary conditions of [R] 7.1.
    """

    times: Array
    positions: Array

    def _check_shapes(self) -> None:
        if (
            self.times.ndim != 2
            or self.positions.ndim != 3
            or not len(self.times)
            or self.times.shape[-1] < 2
            or self.positions.shape[:-1] != self.times.shape
        ):
            raise InvalidValueError(
                "waypoints' shape", self.positions.shape, "(N, K, d) with K times, K >= 2"
            )
        apart = self.times[:, 1:] - self.times[:, :-1]
        if np.count_nonzero(apart >= _LEAST_INTERVAL) < apart.size:
            allowed = f"strictly increasing, by {_LEAST_INTERVAL:g} s at least"
            raise InvalidValueError("waypoint times", self.times.tolist(), allowed, "s")

    def sample(self, time: Array) -> Array:
        """See `Trajectory.sample`."""
        time = self._times(time)
        if time.size == len(self.times) == 1 and type(time) is np.ndarray is type(self.times):
            return self._sample_one(time)
        last = self.times.shape[-1] - 2
        passed = (time[..., None] >= self.times).sum(axis=-1)
        segment = np.minimum(np.maximum(passed - 1, 0), last)
        row = np.arange(self.times.shape[0])
        begin, end = self.times[row, segment], self.times[row, segment + 1]
        start, stop = self.positions[row, segment], self.positions[row, segment + 1]
        span = (end - begin)[..., None]
        s = np.minimum(np.maximum((time - begin)[..., None] / span, 0.0), 1.0)
        return np.concatenate(quintic(start, stop - start, s, span), axis=-1)

    def _sample_one(self, time: Array) -> Array:
        """A sample of one trajectory at one time: numbers are faster than arrays, with the same bits."""
        now, times = time.item(), self.times[0].tolist()
        passed = sum(now >= moment for moment in times)
        segment = min(max(passed - 1, 0), len(times) - 2)
        span = times[segment + 1] - times[segment]
        s = min(max((now - times[segment]) / span, 0.0), 1.0)
        start, stop = self.positions[0, segment : segment + 2].tolist()
        motions = [quintic(begin, end - begin, s, span) for begin, end in zip(start, stop, strict=True)]
        return np.array(list(zip(*motions, strict=True))).reshape(*time.shape, -1)

    @property
    def is_constant(self) -> bool:
        """Whether all waypoints coincide."""
        return not np.any(self.positions - self.positions[:, :1])

    @property
    def goal(self) -> Array:
        """The last waypoint."""
        return self.positions[:, -1]


def quintic(start: Any, move: Any, s: Any, span: Any) -> tuple[Any, Any, Any]:
    """Position, velocity and acceleration on a quintic segment between two rests; numbers or arrays.

    Args:
        start: Position at the beginning.
        move: Way to the end.
        s: Share of the segment's time, 0 to 1.
        span: The segment's time [s].

    Source: [S] 4.2.2; boundary conditions of [R] 7.1.
    """
    square, rest = s * s, 1.0 - s
    position = start + move * (s * square * (10.0 - 15.0 * s + 6.0 * square))
    velocity = move * (30.0 * square * (rest * rest)) / span
    acceleration = move * (60.0 * s * rest * (1.0 - 2.0 * s)) / (span * span)
    return position, velocity, acceleration
