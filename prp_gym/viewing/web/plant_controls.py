"""`PlantControls`: the springs of the surface, and a disturbance."""

from typing import Any

import numpy as np

from prp_gym.robot.arm import PRPArm
from prp_gym.tasks.fields import Field
from prp_gym.viewing.disturbance import LARGEST_FORCE, LONGEST, Disturbance
from prp_gym.viewing.predicted_motion import slide_direction
from prp_gym.viewing.session import SPRINGS
from prp_gym.viewing.viewer import Viewer

_STIFFNESS = (5.0, 10000.0, 5.0)  # least, largest, step [N/m]
_DAMPING = (0.0, 200.0, 0.5)  # [N s/m]
_RANGES = dict(zip(SPRINGS, (_STIFFNESS, _DAMPING), strict=True))
_LABELS = dict(zip(SPRINGS, ("stiffness [N/m]", "damping [N·s/m]"), strict=True))
_SLIDE = "force along the slide [N]"
_AXES = {f"force along {axis} [N]": index for index, axis in enumerate("xyz")}


class PlantControls:
    """Sliders for the surface, and a button that disturbs the arm.

    Args:
        gui: viser's container.
        viewer: loop that runs the session.
    """

    def __init__(self, gui: Any, viewer: Viewer) -> None:
        self._viewer = viewer
        self._springs: dict[str, Any] = {}
        self._known = dict(viewer.session.surface)
        if viewer.session.has_surface:
            self._add_surface(gui)
        self._directions = self._make_directions()
        with gui.add_folder("Disturbance"):
            self._kind = gui.add_dropdown("on", tuple(self._directions))
            self._size = gui.add_number("size [N, N·m]", 5.0, min=-LARGEST_FORCE, max=LARGEST_FORCE, step=0.5)
            self._duration = gui.add_number("duration [s]", 0.2, min=0.001, max=LONGEST, step=0.05)
            push = gui.add_button("Disturb", hint="The force or torque acts for this duration, then ends.")
        push.on_click(lambda _: viewer.wish(self._disturb))
        self.refresh()

    def refresh(self) -> None:
        """Show the springs of the present surface, where they are not those that the user has set."""
        surface = self._viewer.session.surface
        for name, slider in self._springs.items():
            if self._known[name] != surface[name]:
                self._known[name], slider.value = surface[name], _within(name, surface[name])

    def _add_surface(self, gui: Any) -> None:
        viewer = self._viewer
        with gui.add_folder("Surface"):
            for name, (low, high, step) in _RANGES.items():
                value = _within(name, viewer.session.surface[name])
                slider = gui.add_slider(_LABELS[name], min=low, max=high, step=step, initial_value=value)
                slider.on_update(lambda event, name=name: self._wish_spring(name, event))
                self._springs[name] = slider
            release = gui.add_button(
                "As the task draws it",
                hint="At the next reset the surface is drawn from the task's ranges again.",
            )
        release.on_click(lambda _: viewer.wish(viewer.session.release_surface))

    def _wish_spring(self, name: str, event: Any) -> None:
        """A slider that a user has moved; not one that `refresh` has set."""
        if event.client is not None:
            value = float(event.target.value)
            self._viewer.wish(lambda: self._set_spring(name, value))

    def _set_spring(self, name: str, value: float) -> None:
        self._known[name] = value
        self._viewer.session.set_surface(name, value)

    def _make_directions(self) -> dict[str, Any]:
        """What may be disturbed, with the direction along the tip or the index of the joint."""
        inner = self._viewer.session.inner
        fields: tuple[Field, ...] = inner.task.measured_fields
        units = ("N·m" if unit == "rad" else "N" for unit in fields[0].units)
        joints = {f"torque at joint {index + 1} [{unit}]": index for index, unit in enumerate(units)}
        return {_SLIDE: -1, **_AXES, **joints} if isinstance(inner.arm, PRPArm) else joints

    def _disturb(self) -> None:
        kind, size, duration = str(self._kind.value), float(self._size.value), float(self._duration.value)
        inner = self._viewer.session.inner
        if kind == _SLIDE:
            direction = slide_direction(inner.physics.joint_position[0])
            force = tuple((size * direction).tolist())
            self._viewer.session.disturb(Disturbance(duration, force))
        elif kind in _AXES:
            self._viewer.session.disturb(Disturbance(duration, _unit(3, _AXES[kind], size)))  # type: ignore[arg-type]
        else:
            torque = _unit(inner.arm.joint_count, self._directions[kind], size)
            self._viewer.session.disturb(Disturbance(duration, torque=torque))


def _within(name: str, value: float) -> float:
    """The nearest value that the slider of a spring shows."""
    low, high, _ = _RANGES[name]
    return min(max(value, low), high)


def _unit(count: int, index: int, size: float) -> tuple[float, ...]:
    """A vector with one component that is not zero."""
    vector = np.zeros(count)
    vector[index] = size
    return tuple(vector.tolist())
