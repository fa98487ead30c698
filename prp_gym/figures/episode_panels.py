"""The panels of one episode: motion, errors, torques, contact force and reward, as far as a task has them."""

from collections.abc import Sequence
from dataclasses import dataclass

from prp_gym.evaluation.rollout import Rollout
from prp_gym.figures.curve import EpisodeCurve, EpisodePanel
from prp_gym.robot.arrays import Array

ACTUAL, REFERENCE, MODEL = "actual", "reference", "model"
"""What a line shows: the motion itself, the desired one, or that of the target model."""


@dataclass(frozen=True)
class _Motion:
    """Components of a motion with the same unit.

    Attributes:
        name: name of the quantity.
        symbols: symbols of all components (mathematical text).
        chosen: components of the group.
        unit: unit of the components.
        small_unit: unit of their errors, a thousandth of the unit.
    """

    name: str
    symbols: tuple[str, ...]
    chosen: tuple[int, ...]
    unit: str
    small_unit: str


_JOINTS = ("q_1", "q_2", "q_3")
_POSE = ("x", "y", "z", r"\alpha", r"\beta")  # γ is the same in every configuration of the arm
_MOTIONS = {
    "joint_position": (
        _Motion("revolute joints", _JOINTS, (0, 2), "rad", "mrad"),
        _Motion("prismatic joint", _JOINTS, (1,), "m", "mm"),
    ),
    "end_effector_pose": (
        _Motion("tip position", _POSE, (0, 1, 2), "m", "mm"),
        _Motion("tip angles", _POSE, (3, 4), "rad", "mrad"),
    ),
}
"""What is drawn of a motion, by its field."""

_REFERENCES = {"joint_position": "desired_joint_position", "end_effector_pose": "desired_pose"}
_MODELS = {"end_effector_pose": "model_pose"}
_TORQUES = (("joint torque", (0, 2), "N m"), ("joint force", (1,), "N"))
_THOUSAND = 1e3
_ROOM = 1.05  # of a scale of 0 to 1


def episode_panels(rollout: Rollout) -> list[EpisodePanel]:
    """The panels of an episode, in the order in which they are read.

    Args:
        rollout: the episode.

    Returns:
        position and error of the motion for which the task has a reference, in joint or operational space;
        torques, contact force and reward.
    """
    panels: list[EpisodePanel] = []
    for field, groups in _MOTIONS.items():
        if field in rollout.fields and _REFERENCES[field] in rollout.fields:
            panels += _motion_panels(rollout, field, groups)
    panels += _torque_panels(rollout)
    if "contact_force" in rollout.fields:
        panels.append(_force_panel(rollout))
    return [*panels, _reward_panel(rollout)]


def _motion_panels(rollout: Rollout, field: str, groups: Sequence[_Motion]) -> list[EpisodePanel]:
    """Position and error of each group of components that the motion has."""
    model = _MODELS.get(field, "")
    compared = model if model in rollout.fields else _REFERENCES[field]
    error = rollout.fields[compared] - rollout.fields[field]
    whose = "to target model" if compared == model else "to reference"
    shown = [(field, ACTUAL, "{}"), (_REFERENCES[field], REFERENCE, "{}_d"), (model, MODEL, "{}_m")]
    panels = []
    for group in groups:
        chosen = [index for index in group.chosen if index < error.shape[-1]]
        if not chosen:
            continue
        curves = [
            curve
            for name, role, pattern in shown
            if name in rollout.fields
            for curve in _curves(rollout.fields[name], group.symbols, chosen, role, pattern)
        ]
        panels.append(EpisodePanel(f"{group.name}\n[{group.unit}]", tuple(curves)))
        errors = _curves(_THOUSAND * error, group.symbols, chosen, ACTUAL, r"\tilde{{{}}}")
        panels.append(EpisodePanel(f"error {whose}\n[{group.small_unit}]", tuple(errors)))
    return panels


def _curves(
    values: Array, symbols: Sequence[str], chosen: Sequence[int], role: str, pattern: str
) -> list[EpisodeCurve]:
    """Some components of values (n, components)."""
    return [
        EpisodeCurve(f"${_with_index(symbols[index], pattern)}$", index % 3, role, values[:, index])
        for index in chosen
    ]


def _with_index(symbol: str, pattern: str) -> str:
    """A symbol in a pattern; an index that it has already comes to stand beside the new one."""
    base, _, index = symbol.partition("_")
    if pattern.startswith("{}_"):
        return f"{base}_{{{pattern[3:]}{index}}}"
    return f"{pattern.format(base)}_{index}" if index else pattern.format(base)


def _torque_panels(rollout: Rollout) -> list[EpisodePanel]:
    """The torques that acted on the joints, and the limits of the actuators."""
    panels = []
    for name, group, unit in _TORQUES:
        chosen = [index for index in group if index < rollout.applied_torque.shape[-1]]
        if not chosen:
            continue
        symbols = (r"\tau_1", r"\tau_2", r"\tau_3")
        curves = _curves(rollout.applied_torque, symbols, chosen, ACTUAL, "{}")
        limits = tuple(
            (f"limit of ${symbols[index]}$", float(rollout.torque_limit[index])) for index in chosen
        )
        panels.append(EpisodePanel(f"{name}\n[{unit}]", tuple(curves), limits))
    return panels


def _force_panel(rollout: Rollout) -> EpisodePanel:
    """The contact force and, where the task has one, the desired force."""
    symbols, every = ("f_x", "f_y", "f_z"), (0, 1, 2)
    curves = _curves(rollout.fields["contact_force"], symbols, every, ACTUAL, "{}")
    if "desired_force" in rollout.fields:
        curves += _curves(rollout.fields["desired_force"], symbols, every, REFERENCE, "{}_d")
    return EpisodePanel("contact force\nby the tip [N]", tuple(curves))


def _reward_panel(rollout: Rollout) -> EpisodePanel:
    curve = EpisodeCurve("reward", 0, ACTUAL, rollout.reward)
    return EpisodePanel("reward of\na period [1]", (curve,), fixed_range=(0.0, _ROOM))
