"""`SceneView`: the arm, its surroundings and what the task wants, in three dimensions."""

from typing import Any

import mujoco
import numpy as np

from prp_gym.drawing.triad import tip_axes
from prp_gym.palette import FORCE, MEASURED, REFERENCE, rgb
from prp_gym.physics.rendering import Ball, Path
from prp_gym.robot.arrays import Array
from prp_gym.viewing.session import Session
from prp_gym.viewing.signals import Signals
from prp_gym.viewing.web.geoms import add_geoms

_TRACE, _FORCE, _REFERENCE = rgb(MEASURED), rgb(FORCE), rgb(REFERENCE)
_METRES_PER_NEWTON = 0.02
_TRAIL = 400  # points
_AXIS_LENGTHS = 0.12 * np.array([[0.6], [0.8], [1.0]])  # of x, y and z of the desired frame [m]


class SceneView:
    """The scene of a page.

    Args:
        scene: viser's scene.

    Attributes:
        bodies: frames of the bodies by their names in the model.
        ghost: frames of the bodies at the reference, where it is one of the joints; none otherwise.
        axes: axes of the desired frame, where the reference is a pose; None otherwise.
    """

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self.bodies: dict[str, Any] = {}
        self.ghost: dict[str, Any] = {}
        self.axes: Any = None
        self._episode: tuple[object, ...] = ()
        self._time = -1.0
        scene.set_up_direction("+z")
        scene.configure_default_lights(cast_shadow=True)

    def show(self, session: Session) -> None:
        """Show the present state of a session; nothing is sent while it stays the same."""
        episode = session.inner, session.seed
        if episode == self._episode and session.time == self._time:
            return
        if episode != self._episode or session.time < self._time:
            self._begin(session)
        self._episode, self._time = episode, session.time
        self._pose(self.bodies, session.inner.physics.joint_position[0])
        self._show_motion(session.signals, session.inner)

    def _pose(self, frames: dict[str, Any], joint_position: Array) -> None:
        """Move the frames of bodies to where they are at joint positions (joints) [rad, m, rad]."""
        self._data.qpos[:] = joint_position
        mujoco.mj_kinematics(self._model, self._data)
        for name, frame in frames.items():
            body = self._data.body(name)
            frame.position, frame.wxyz = body.xpos, body.xquat

    def _begin(self, session: Session) -> None:
        """Draw the bodies of the model, and what an episode does not change."""
        self._scene.reset()
        self._model = session.inner.physics.model()
        self._data = mujoco.MjData(self._model)
        mujoco.mj_kinematics(self._model, self._data)
        self.bodies = add_geoms(self._scene, self._model)
        for number, item in enumerate(session.inner.task.overlay(0, session.inner.duration)):
            if isinstance(item, Path):
                segments = np.stack([item.points[:-1], item.points[1:]], axis=1)
                self._add_line(f"/reference/path_{number}", segments, _REFERENCE)
            elif isinstance(item, Ball):
                color = tuple(round(255 * value) for value in item.color[:3])
                self._scene.add_icosphere(
                    f"/reference/goal_{number}", item.radius, color, position=item.center, opacity=0.6
                )
        point = np.zeros((1, 2, 3))
        self._trail = self._add_line("/trail", point, _TRACE)
        self._begin_reference(session.signals)
        self._force = self._add_arrow("/force/measured", point, _FORCE)
        self._wanted = self._add_arrow("/force/desired", point, _REFERENCE)
        self._label = self._scene.add_label("/force/value", "", anchor="bottom-left", visible=False)

    def _begin_reference(self, signals: Signals) -> None:
        """Draw the present reference: a ball, and a ghost of the arm or the axes of the desired frame."""
        self._target = self._scene.add_icosphere("/reference/now", 0.018, _REFERENCE, opacity=0.6)
        of_joints = "desired_joint_position" in signals.fields
        self.ghost = add_geoms(self._scene, self._model, "/reference/arm", _REFERENCE) if of_joints else {}
        of_pose = "desired_pose" in signals.fields
        self.axes = self._add_arrow("/reference/axes", np.zeros((3, 2, 3)), _REFERENCE) if of_pose else None

    def _show_motion(self, signals: Signals, inner: Any) -> None:
        """Move the trail, the reference, and the forces beside the tip."""
        tip = inner.physics.tip_position[0]
        trail = _tip_positions(signals, inner, "joint_position", "end_effector_pose")
        trail = trail[:: max(1, len(trail) // _TRAIL)]
        if len(trail) > 1:
            self._trail.points = np.stack([trail[:-1], trail[1:]], axis=1).astype(np.float32)
        target = _tip_positions(signals, inner, "desired_joint_position", "desired_pose")[-1:]
        self._target.visible = len(target) > 0
        if len(target):
            self._target.position = target[0]
        if self.ghost:
            self._pose(self.ghost, signals.fields["desired_joint_position"][-1])
        if self.axes is not None and len(target):
            ends = target[0] + _AXIS_LENGTHS * tip_axes(signals.fields["desired_pose"][-1, 3:]).T
            starts = np.broadcast_to(target[0], ends.shape)
            self.axes.points = np.stack([starts, ends], axis=1).astype(np.float32)
            self.axes.visible = True
        force = inner.physics.contact_force[0]
        desired = signals.fields["desired_force"][-1] if "desired_force" in signals.fields else np.zeros(3)
        _point(self._force, tip + np.array([0.0, 0.0, 0.05]), force)
        _point(self._wanted, tip + np.array([0.0, 0.0, 0.08]), desired)
        size, wanted = float(np.linalg.norm(force)), float(np.linalg.norm(desired))
        self._label.visible = size > 0.0
        self._label.position = tip + np.array([0.0, 0.0, 0.1])
        self._label.text = f"{size:.2f} N" + (f" (desired {wanted:.2f} N)" if wanted else "")

    def _add_line(self, name: str, segments: Array, color: tuple[int, int, int]) -> Any:
        return self._scene.add_line_segments(name, segments.astype(np.float32), color, thickness=0.004)

    def _add_arrow(self, name: str, segments: Array, color: tuple[int, int, int]) -> Any:
        return self._scene.add_arrows(
            name, segments, color, shaft_radius=0.005, head_radius=0.014, head_length=0.03, visible=False
        )


def _point(arrow: Any, start: Array, force: Array) -> None:
    """Draw an arrow for a force (3) [N], or hide it."""
    arrow.visible = bool(np.any(force))
    if arrow.visible:
        arrow.points = np.stack([start, start + force * _METRES_PER_NEWTON])[None].astype(np.float32)


def _tip_positions(signals: Signals, inner: Any, joint_field: str, pose_field: str) -> Array:
    """Positions (T, 3) of the tip that a field holds, in the world frame [m]; none for a link."""
    if pose_field in signals.fields:
        return signals.fields[pose_field][:, :3]
    if joint_field in signals.fields and hasattr(inner.arm, "forward_kinematics"):
        positions: Array = inner.arm.forward_kinematics(signals.fields[joint_field])[:, :3]
        return positions
    return np.zeros((0, 3))
