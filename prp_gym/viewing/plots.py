"""The live plots of a session: contact force, error, torques, with what theory predicts."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from prp_gym.physics.surface import Surface
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, dot
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.viewing.plot import Line, Plot
from prp_gym.viewing.predicted_force import predicted_forces, pressing_force
from prp_gym.viewing.predicted_motion import predicted_joint_errors, predicted_tip_error
from prp_gym.viewing.session import Session
from prp_gym.viewing.signals import Signals

_MILLIMETRES = 1000.0
_AXES = ("x", "y", "z")
_AT_REST = 1e-9  # joint speed up to which an episode starts at rest [rad/s, m/s]


def make_plots(session: Session) -> tuple[Plot, ...]:
    """The plots of the last seconds of a session."""
    signals, settings = session.signals, getattr(session.policy, "settings", None)
    plots = []
    if session.has_surface:
        surface = session.inner.physics.surface()
        plots.append(_force_plot(settings, signals, surface))
        if "model_pose" in signals.fields:
            return (*plots, _displacement_plot(signals, surface), _torque_plot(signals))
        return (*plots, _tangential_plot(signals, surface), _torque_plot(signals))
    if "desired_joint_position" in signals.fields:
        plots.append(
            _joint_plot(settings, signals, _starts_at_rest(session, signals), session.inner.task.layout)
        )
    else:
        plots.append(_tip_plot(settings, signals, session.inner.arm))
    return (*plots, _torque_plot(signals))


def _force_plot(settings: Any, signals: Signals, surface: Surface) -> Plot:
    """The contact force into the surface, with the desired force and what theory predicts."""
    lines = [Line("measured", pressing_force(signals.fields["contact_force"], surface))]
    if "desired_force" in signals.fields:
        lines.append(Line("desired", pressing_force(signals.fields["desired_force"], surface), "desired"))
    lines += predicted_forces(settings, signals, surface)
    return Plot("Contact force on the surface", "N", signals.time, tuple(lines))


def _displacement_plot(signals: Signals, surface: Surface) -> Plot:
    """How far the contact holds the tip back from its reference, beside the target model of the task."""
    into = -surface.normal[0]
    desired, measured = signals.fields["desired_pose"][:, :3], signals.fields["end_effector_pose"][:, :3]
    model = signals.fields["model_pose"][:, :3]
    lines = (
        Line("measured", dot(desired - measured, into) * _MILLIMETRES),
        Line("predicted: target model of the task", dot(desired - model, into) * _MILLIMETRES, "predicted"),
    )
    return Plot("Tip behind its reference, into the surface", "mm", signals.time, lines)


def _tangential_plot(signals: Signals, surface: Surface) -> Plot:
    """The error of the tip's position along the surface; across it the force is controlled."""
    errors = (signals.fields["desired_pose"] - signals.fields["end_effector_pose"])[:, :3]
    along = errors - dot(errors, surface.normal[0])[:, None] * surface.normal[0]
    lines = tuple(_components(_AXES, along * _MILLIMETRES))
    return Plot("Tip position error along the surface", "mm", signals.time, lines)


def _joint_plot(settings: Any, signals: Signals, from_rest: bool, layout: ObservationLayout) -> Plot:
    """The joint errors, each in the unit of its joint."""
    errors = signals.fields["desired_joint_position"] - signals.fields["joint_position"]
    units = next(field.units for field in layout.fields if field.name == "joint_position")
    names = [f"joint {index + 1} [{unit}]" for index, unit in enumerate(units)]
    predicted = predicted_joint_errors(settings, signals, from_rest)
    lines = [*_components(names, errors), *_predicted(names, predicted, 1.0)]
    return Plot("Joint error", ", ".join(dict.fromkeys(units)), signals.time, tuple(lines))


def _tip_plot(settings: Any, signals: Signals, arm: PRPArm) -> Plot:
    """The error of the tip's position along the axes of the world."""
    errors = (signals.fields["desired_pose"] - signals.fields["end_effector_pose"])[:, :3]
    lines = [
        *_components(_AXES, errors * _MILLIMETRES),
        *_predicted(_AXES, predicted_tip_error(settings, signals, arm), _MILLIMETRES),
    ]
    return Plot("Tip position error", "mm", signals.time, tuple(lines))


def _torque_plot(signals: Signals) -> Plot:
    """The commanded torques as shares of the actuator limits, which are ±1."""
    shares = signals.torque / signals.torque_limit
    names = [f"joint {index + 1}" for index in range(shares.shape[1])]
    limits = [Line(f"limit {sign:+.0f}", np.full(len(shares), sign), "limit") for sign in (1.0, -1.0)]
    lines = (*_components(names, shares), *limits)
    return Plot("Torque / actuator limit", "1", signals.time, lines)


def _components(names: Any, values: Array) -> Iterator[Line]:
    for index, name in enumerate(names):
        yield Line(name, values[:, index])


def _predicted(names: Any, predicted: tuple[str, Array] | None, factor: float) -> Iterator[Line]:
    """The predicted lines; none where there is no prediction."""
    if predicted is not None:
        label, values = predicted
        for index, name in enumerate(names):
            if not np.isnan(values[:, index]).all():
                yield Line(f"{name}, {label}", values[:, index] * factor, "predicted")


def _starts_at_rest(session: Session, signals: Signals) -> bool:
    """Whether the window holds an unchanged episode from its start at rest, with a constant reference."""
    if session.changed or signals.time[0] > 0.0:
        return False
    resting = bool((np.abs(signals.fields["joint_velocity"][0]) <= _AT_REST).all())
    desired = signals.fields["desired_joint_position"]
    return resting and bool((desired == desired[0]).all())
