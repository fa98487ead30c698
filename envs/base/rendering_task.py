"""What compliance, impedance and admittance tasks share: a target model that the force drives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.arm_task import path_from
from prp_gym.envs.base.contact_task import ContactStart, ContactTask, SurfaceOptions
from prp_gym.envs.base.pose_task import stack_errors
from prp_gym.envs.checks import as_numbers
from prp_gym.envs.config import describe
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import MODEL_POSE
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.target_model import TargetModel
from prp_gym.tasks.task import TaskNumbers
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Trajectory

Axes = float | tuple[float, ...] | None

_TARGET_BOUNDS = {
    "target_inertia": (1e-3, 1e3),
    "target_damping": (0.0, 1e5),
    "target_stiffness": (0.0, 1e6),
}


def _target(what: str, unit: str) -> dict[str, str]:
    text = f"{what} of the target model: one number, six (x, y, z, α, β, γ), or None for the task's own"
    return describe(unit, text)


@dataclass(frozen=True)
class StiffnessOptions(SurfaceOptions):
    """The surface, and the target's stiffness.

    Raises:
        InvalidValueError: a value that is not a number, negative or unreasonably large.
        ShapeError: neither one number nor six.
    """

    target_stiffness: Axes = field(default=None, metadata=_target("stiffness K_P", "N/m, N·m/rad"))

    def __post_init__(self) -> None:
        super().__post_init__()
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name.startswith("target_") and value is not None:
                object.__setattr__(self, entry.name, _six(entry.name, value, entry.metadata["unit"]))


@dataclass(frozen=True)
class TargetOptions(StiffnessOptions):
    """The surface, and the target's inertia, damping and stiffness."""

    target_inertia: Axes = field(default=None, metadata=_target("inertia M_d", "kg, kg·m²"))
    target_damping: Axes = field(default=None, metadata=_target("damping K_D", "N·s/m, N·m·s/rad"))


def _six(name: str, value: object, unit: str) -> tuple[float, ...]:
    axes = as_numbers(name, value, unit)
    if axes.shape not in ((), (6,)):
        raise ShapeError(name, axes.shape, "one number or (6,)")
    low, high = _TARGET_BOUNDS[name]
    if not ((axes >= low) & (axes <= high)).all():
        raise InvalidValueError(name, value, f"{low:g} to {high:g}", unit)
    return tuple(np.broadcast_to(axes, 6).tolist())


class RenderingTask(ContactTask):
    """Be, under the true contact force, where a target model would be.

    Attributes:
        target: the model M_d x̃¨ + K_D x̃˙ + K_P x̃ = h_e with x̃ = x_d - x.
    """

    judged_fields = (MODEL_POSE,)

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._model_pose = self.ground_truth_layout.index("model_pose")
        own = numbers.constants["target"]
        axes = [getattr(options, f"target_{name}", None) or own[name] for name in own]
        self.target = TargetModel(**dict(zip(own, map(np.array, axes), strict=True)), period=period)

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """See `Task.target_impedance`: the target model's axes."""
        return {name: getattr(self.target, name) for name in ("inertia", "damping", "stiffness")}

    def generalised_force(self, ground_truth: Array) -> Array:
        """The true contact force as one on the pose (..., 6) [N, N, N, N m, N m, N m]; no moments."""
        force = np.zeros((*ground_truth.shape[:-1], 6))
        force[..., :3] = ground_truth[..., self._force]
        return force

    def write_model_pose(self, ground_truth: Array, displacement: Array) -> None:
        """The desired pose, less a displacement (..., 6), as the model's pose."""
        ground_truth[..., self._model_pose] = ground_truth[..., self._desired] - displacement

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 3, 3): tip off the model's [m], α and β off the model's [rad], torque [N m, N, N m]."""
        return stack_errors(ground_truth[..., self._model_pose] - ground_truth[..., self._measured], torque)

    def draw_reference(self, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
        """From the start through the waypoints."""
        times, positions = path_from(start, waypoints, intervals)
        return QuinticWaypoints(times[None], positions[None])


class StaticRenderingTask(RenderingTask):
    """The target has stiffness alone: K_P x̃ = h_e, at a constant x_d."""

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """See `Task.target_impedance`: the stiffness alone."""
        return {"stiffness": self.target.stiffness}

    def draw_reference(self, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
        """The last waypoint, held."""
        return Constant(waypoints[-1:])

    def complete(self, ground_truth: Array) -> None:
        """See `Task.complete`."""
        self.write_model_pose(
            ground_truth, self.target.static_displacement(self.generalised_force(ground_truth))
        )


class DynamicRenderingTask(RenderingTask):
    """The target has inertia, damping and stiffness, and moves under the contact force."""

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._motion = np.zeros((0, 6, 4))  # displacement, its rate, force at a period's begin and end

    def begin(self, ids: NDArray[np.intp], starts: Sequence[ContactStart]) -> None:
        """See `Task.begin`: the model starts at rest, on the reference."""
        super().begin(ids, starts)
        if len(self._motion) == 0:
            self._motion = np.zeros((len(ids), 6, 4))
        self._motion[ids] = 0.0

    def advance(self, ground_truth: Array) -> None:
        """See `Task.advance`."""
        self._motion[:, :3, 3] = ground_truth[:, self._force]
        self.target.follow(self._motion)

    def complete(self, ground_truth: Array) -> None:
        """See `Task.complete`; the force now, at a start too, begins the next period."""
        self._motion[:, :3, 2] = ground_truth[:, self._force]
        self.write_model_pose(ground_truth, self._motion[..., 0])
