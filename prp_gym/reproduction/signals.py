"""Signals of a recorded episode that can be drawn and measured: fields, torques, errors."""

from collections.abc import Sequence
from dataclasses import dataclass

from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array

_JOINTS = ("rad", "m", "rad")
_POSE = ("m", "m", "m", "rad", "rad", "rad")
_LINK = ("kg·m²", "N·m·s/rad", "N·m")


@dataclass(frozen=True)
class Signal:
    """A quantity over time.

    Attributes:
        symbols: symbols of the components, for axes (mathematical text).
        units: units of the components.
        difference: names of the two fields whose difference is the signal; empty for a field or the torque.
    """

    symbols: tuple[str, ...]
    units: tuple[str, ...]
    difference: tuple[str, ...] = ()


def _indexed(pattern: str) -> tuple[str, ...]:
    return tuple(f"${pattern}_{index}$" for index in (1, 2, 3))


_COORDINATES = ("x", "y", "z", r"\alpha", r"\beta", r"\gamma")

SIGNALS = {
    "joint_position": Signal(_indexed("q"), _JOINTS),
    "desired_joint_position": Signal(tuple(f"$q_{{d{i}}}$" for i in (1, 2, 3)), _JOINTS),
    "joint_error": Signal(_indexed(r"\tilde{q}"), _JOINTS, ("desired_joint_position", "joint_position")),
    "torque": Signal(_indexed(r"\tau"), ("N·m", "N", "N·m")),
    "end_effector_pose": Signal(tuple(f"${name}$" for name in _COORDINATES), _POSE),
    "desired_pose": Signal(tuple(f"${name}_d$" for name in _COORDINATES), _POSE),
    "model_pose": Signal(tuple(f"${name}_m$" for name in _COORDINATES), _POSE),
    "pose_error": Signal(
        tuple(rf"$\tilde{{{name}}}$" for name in _COORDINATES), _POSE, ("desired_pose", "end_effector_pose")
    ),
    "model_error": Signal(
        tuple(f"${name}_m - {name}$" for name in _COORDINATES), _POSE, ("model_pose", "end_effector_pose")
    ),
    "contact_force": Signal(("$f_x$", "$f_y$", "$f_z$"), ("N", "N", "N")),
    "desired_force": Signal(("$f_{dx}$", "$f_{dy}$", "$f_{dz}$"), ("N", "N", "N")),
    "parameter_estimate": Signal((r"$\hat{I}$", r"$\hat{F}$", r"$\hat{G}$"), _LINK),
}
"""Signals by name. `parameter_estimate` is a state of the adaptive controller, recorded if a run names it."""


def find_signal(name: str) -> Signal:
    """A signal by name.

    Raises:
        UnknownNameError: no such signal.
    """
    if name not in SIGNALS:
        raise UnknownNameError("signal", name, SIGNALS)
    return SIGNALS[name]


def series(rollout: Rollout, name: str, components: Sequence[int] = ()) -> tuple[Array, Array]:
    """A signal of a recorded episode.

    Args:
        rollout: the episode, of T steps.
        name: name of the signal.
        components: components of the signal; all by default.

    Returns:
        time (n) [s] and values (n, components) in the signal's units; n is T + 1, for torques T:
        each belongs to the start of the period for which it is held.

    Raises:
        UnknownNameError: no such signal.
        InvalidValueError: the episode lacks the signal or one of the components.
    """
    signal = find_signal(name)
    needed = [field for field in signal.difference or (name,) if field != "torque"]
    for field in needed:
        if field not in rollout.fields:
            raise InvalidValueError(
                f"signal {name!r}", rollout.environment_id, f"a run that records {field!r}"
            )
    if name == "torque":
        values = rollout.torque
    elif signal.difference:
        values = rollout.fields[needed[0]] - rollout.fields[needed[1]]
    else:
        values = rollout.fields[name]
    chosen = list(components or range(values.shape[1]))
    if max(chosen) >= values.shape[1]:
        raise InvalidValueError(f"component of {name!r}", max(chosen), f"at most {values.shape[1] - 1}")
    return rollout.time[: len(values)], values[:, chosen]
