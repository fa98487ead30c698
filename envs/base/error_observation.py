"""`ErrorObservation`: an observation as errors and states of order 1, for learning algorithms."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from prp_gym.envs.base.error_part import ErrorPart
from prp_gym.errors import InvalidValueError
from prp_gym.files.file_reader import FileReader
from prp_gym.files.typed_reader import TypedReader
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, apply_transposed
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import ObservationLayout

Observed = Mapping[str, Array]
Quantities = dict[str, Array]

_PARTS = Path(__file__).with_suffix(".toml")
_JOINT = ("desired_joint_position", "desired_joint_velocity", "desired_joint_acceleration")
_POSE = ("desired_pose", "desired_velocity", "desired_acceleration")
_FORCE, _DESIRED_FORCE = "contact_force", "desired_force"


class ErrorObservation:
    """Turns observations into errors and states of order 1, which learning algorithms can use as they are.

    The parts are declared in `error_observation.toml`. They are functions of the observed fields and of the
    nominal kinematics alone, so that they contain the errors of the sensors, and nothing that a controller
    does not have. On the arm all errors are those of the joints, also where the reference is a pose: its
    angles determine the positions of the joints.

    Args:
        layout: Layout of the observation that is read.
        model: Nominal robot.

    Attributes:
        layout: Layout of the errors.

    Raises:
        InvalidValueError: an observation without joint position, joint velocity or reference.
    """

    def __init__(self, layout: ObservationLayout, model: PRPArm | Link) -> None:
        self._read, self._model = layout, model
        self._find: Callable[[PRPArm | Link, Observed], Quantities] = _quantities_of(layout, model)
        available = self._find(model, layout.split(np.zeros((1, layout.size))))
        kind = "link" if isinstance(model, Link) else "arm"
        parts = [part for part in read_parts()[kind] if part.quantity in available]
        self.layout = ObservationLayout([part.field() for part in parts])
        self._quantities = tuple(dict.fromkeys(part.quantity for part in parts))
        ends = np.cumsum([available[name].shape[-1] for name in self._quantities]).tolist()
        first = dict(zip(self._quantities, [0, *ends[:-1]], strict=True))
        self._columns = np.array([first[part.quantity] + i for part in parts for i in range(len(part.scale))])
        self._scale = np.array([value for part in parts for value in part.scale])
        self._bound = np.array([value for field in self.layout.fields for value in field.high])
        saturating = [part.saturates for part in parts for _ in part.scale]
        self._softness = np.array(saturating, dtype=np.float64)

    def __call__(self, observation: Array) -> Array:
        """The errors (N, layout size) of observations (N, size of the observation that is read)."""
        quantities = self._find(self._model, self._read.split(observation))
        values = np.concatenate([quantities[name] for name in self._quantities], axis=-1)
        scaled = values[..., self._columns] / self._scale
        scaled /= 1.0 + self._softness * np.abs(scaled)
        limited: Array = np.clip(scaled, -self._bound, self._bound)
        return limited


@cache
def read_parts() -> Mapping[str, tuple[ErrorPart, ...]]:
    """The declared parts of the errors by the kind of the robot, `arm` or `link`.

    Raises:
        DataFileError: a data file that cannot be read.
    """
    reader = TypedReader(_PARTS)
    content = FileReader().read_toml(_PARTS)
    return {
        kind: tuple(reader.read(ErrorPart, entry, f"{kind}[{n}]") for n, entry in enumerate(entries))
        for kind, entries in content.items()
    }


def _quantities_of(layout: ObservationLayout, model: PRPArm | Link) -> Callable[[Any, Observed], Quantities]:
    """The function that computes the quantities of a robot from an observation.

    Raises:
        InvalidValueError: an observation without joint position, joint velocity or reference.
    """
    names = set(layout.names)
    link = isinstance(model, Link)
    for reference in (_JOINT,) if link else (_JOINT, _POSE):
        if names.issuperset((*reference, "joint_position", "joint_velocity")):
            return _link_quantities if link else _arm_quantities
    allowed = (
        "'fields' in this task: errors need joint_position, joint_velocity and a desired motion,"
        f" and it observes {', '.join(layout.names)}"
    )
    raise InvalidValueError("observation", "errors", allowed)


def _link_quantities(_: Link, observed: Observed) -> Quantities:
    """Quantities (..., 1) of the single link by name."""
    return _motion_quantities(observed, tuple(observed[name] for name in _JOINT), np.s_[..., :])


def _arm_quantities(arm: PRPArm, observed: Observed) -> Quantities:
    """Quantities (..., size) of the arm by name."""
    if _JOINT[0] in observed:
        reference = tuple(observed[name] for name in _JOINT)
    else:
        reference = arm.joint_motion(*(observed[name] for name in _POSE))
    quantities = _motion_quantities(observed, reference, np.s_[..., ::2])
    position = observed["joint_position"]
    middle = (arm.parameters.joint_lower[1] + arm.parameters.joint_upper[1]) / 2
    quantities["slide_position"] = position[..., 1:2] - middle
    if _FORCE in observed:
        jacobian = arm.analytical_jacobian(position)[..., :3, :]
        load = quantities["contact_load"] = apply_transposed(jacobian, observed[_FORCE])
        if _DESIRED_FORCE in observed:
            desired = quantities["desired_contact_load"] = apply_transposed(
                jacobian, observed[_DESIRED_FORCE]
            )
            quantities["contact_load_error"] = desired - load
    return quantities


def _motion_quantities(observed: Observed, reference: tuple[Array, ...], revolute: Any) -> Quantities:
    """Quantities that every robot has.

    Args:
        observed: Fields by name, each (..., size).
        reference: Desired joint position, velocity and acceleration (..., joints).
        revolute: Index of the revolute joints.
    """
    position, velocity = observed["joint_position"], observed["joint_velocity"]
    desired, desired_velocity, desired_acceleration = reference
    angle = position[revolute]
    return {
        "revolute_sine": np.sin(angle),
        "revolute_cosine": np.cos(angle),
        "joint_velocity": velocity,
        "joint_error": desired - position,
        "joint_velocity_error": desired_velocity - velocity,
        "desired_joint_velocity": desired_velocity,
        "desired_joint_acceleration": desired_acceleration,
    }
