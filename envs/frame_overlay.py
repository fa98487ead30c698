"""The overlay of an environment's frames: present reference, trail of the tip, forces, phase of contact."""

import numpy as np

from prp_gym.drawing.contact_ring import FREE, LOST, TOUCHING, ContactRing
from prp_gym.drawing.ghost import Ghost
from prp_gym.drawing.overlay import Arrow, DashedArrow, OverlayItem
from prp_gym.drawing.trail import Trail
from prp_gym.drawing.triad import Triad, tip_axes
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.tip_history import TipHistory
from prp_gym.palette import FORCE, MEASURED, REFERENCE, rgba
from prp_gym.physics.mjcf import TIP_RADIUS
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, norm

_ARROW_LENGTH = 0.14  # [m], of the desired force, or of _USUAL_FORCE where none is desired
_USUAL_FORCE = 2.5  # [N]
_LONGEST = 2.2  # of an arrow, in parts of _ARROW_LENGTH
_BESIDE = 0.06  # between the arrows of the contact force and the desired force [m]
_WIDTH = 0.008  # [m]
_UP = np.array([0.0, 0.0, 1.0])


def episode_overlay(loop: EpisodeLoop, history: TipHistory, index: int) -> list[OverlayItem]:
    """The overlay of one environment: reference path, present reference, trail, forces, phase of contact.

    Args:
        loop: Loop of the environments.
        history: Positions of their tips.
        index: Index of the environment.
    """
    layout = loop.task.ground_truth_layout
    fields = {name: loop.ground_truth[index, layout.index(name)] for name in layout.names}
    overlay = list(loop.task.overlay(index, loop.config.duration))
    if "desired_joint_position" in fields:
        overlay.append(Ghost(fields["desired_joint_position"].copy()))
    if "desired_pose" in fields:
        overlay += _triads(fields["end_effector_pose"], fields["desired_pose"])
    overlay.append(Trail(history.points(loop, index)))
    if "contact_force" in fields:
        overlay += _contact(loop, history, index, fields.get("desired_force", np.zeros(3)))
    return overlay


def _triads(pose: Array, desired: Array) -> list[OverlayItem]:
    """The frame of the tip, thin, and the desired one, translucent around it."""
    present = Triad(pose[:3].copy(), tip_axes(pose[3:]), 0.06, 0.003, rgba(MEASURED))
    wanted = Triad(desired[:3].copy(), tip_axes(desired[3:]), 0.08, 0.005, rgba(REFERENCE, 0.75))
    return [present, wanted]


def _contact(loop: EpisodeLoop, history: TipHistory, index: int, desired: Array) -> list[OverlayItem]:
    """The contact force with the desired force beside it, and the phase of contact."""
    force, last = np.array(loop.physics.contact_force[index]), history.last_force(loop, index)
    size, wanted = float(norm(force)), float(norm(desired))
    phase = TOUCHING if size > 0.0 else (LOST if last.any() else FREE)
    direction = last if last.any() else desired
    if not direction.any():
        return []
    inward = direction / norm(direction)
    tip = np.array(loop.physics.tip_position[index])
    scale = _ARROW_LENGTH / (wanted or _USUAL_FORCE)
    outside = _arm_is_behind(loop, index, inward)
    items: list[OverlayItem] = [ContactRing(tip, inward, phase)]
    for kind, vector, name, color, offset in (
        (Arrow, force, "f", rgba(FORCE), 0.0),
        (DashedArrow, desired, "f_d", rgba(REFERENCE), _BESIDE),
    ):
        newtons = float(norm(vector))
        if newtons > 0.0:
            length = min(scale * newtons, _LONGEST * _ARROW_LENGTH)
            drawn = length * vector / newtons
            contact = tip + TIP_RADIUS * inward + offset * _UP
            start = contact - drawn - 2 * TIP_RADIUS * inward if outside else contact
            items.append(
                kind(start, drawn, _WIDTH, color, f"{name} {newtons:.2f} N", 0.0 if outside else 1.0)
            )
    return items


def _arm_is_behind(loop: EpisodeLoop, index: int, inward: Array) -> bool:
    """Whether the third link passes through the surface, so that arrows have room on the free side."""
    arm = loop.task.model
    if not isinstance(arm, PRPArm):
        return False
    frames = arm.transforms(loop.physics.joint_position[index])
    elbow, tip = frames[2, :3, 3], frames[4, :3, 3]
    return bool((elbow - tip) @ inward > 0.0)
