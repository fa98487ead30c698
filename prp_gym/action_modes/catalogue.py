"""The action modes by name, and how to make one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from prp_gym.action_modes.steering import ResidualMode, SteeredController
from prp_gym.baselines.policy import ControlInterface
from prp_gym.baselines.registry import list_baselines
from prp_gym.envs.action_mode import TORQUE, ActionField, ActionMode
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import TORQUE_UNITS
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.task import Task

RESIDUAL_SHARE = 0.2
"""How much of the actuator limits, at most the robot's own, a residual may add to a law's torques."""

SMOOTHING_TIME = 0.1
"""Time constant with which the references and gains of a steered law follow the action [s]."""

RESIDUAL = "residual:"
"""Before the name of a law: the mode in which the action adds to its torques."""

_JOINT_BOUND = (0.3, 0.05, 0.3)
_JOINT_UNITS = ("rad", "m", "rad")
_POSE_BOUND = (0.05, 0.05, 0.05, 0.3, 0.3)
_POSE_UNITS = ("m", "m", "m", "rad", "rad")
_STIFF_POSE_BOUND = (0.005, 0.005, 0.005, 0.05, 0.05)  # 5 mm are 25 N on the stiffest surface
_FORCE_BOUND = (2.0, 2.0, 2.0)
_FACTOR_UNITS = ("1",) * 5

Fields = tuple[ActionField, ...]


def _joint_offset(joints: int) -> Fields:
    """Of the arm or of the single link."""
    units, bound = _JOINT_UNITS[:joints], _JOINT_BOUND[:joints]
    return (ActionField("joint_offset", units, "joint", bound, "added to the desired joint position q_d"),)


_POSE_OFFSET = ActionField(
    "pose_offset", _POSE_UNITS, "world", _POSE_BOUND, "added to x, y, z, α, β of the desired pose x_d"
)
_STIFF_POSE_OFFSET = replace(_POSE_OFFSET, bound=_STIFF_POSE_BOUND)
_STIFFNESS_FACTOR = ActionField(
    "stiffness_factor",
    _FACTOR_UNITS,
    "world",
    (10.0,) * 5,
    "times the law's K_P along x, y, z, α, β; K_D follows, so that the damping ratio stays",
    factor=True,
)
_DAMPING_FACTOR = ActionField(
    "damping_factor",
    _FACTOR_UNITS,
    "world",
    (4.0,) * 5,
    "times the law's damping ratio along x, y, z, α, β",
    factor=True,
)
_FORCE_OFFSET = ActionField(
    "force_offset", ("N",) * 3, "world", _FORCE_BOUND, "added to the desired force f_d by the tip"
)


_APPROACH_FACTOR = ActionField(
    "approach_speed_factor",
    ("1",),
    "along f_d",
    (10.0,),
    "times the law's speed towards a surface",
    factor=True,
)
_BANDWIDTH_FACTOR = ActionField(
    "bandwidth_factor", ("1",), "along f_d", (4.0,), "times the law's bandwidth in contact", factor=True
)


def _pose_offset(_: int) -> Fields:
    return (_POSE_OFFSET,)


@dataclass(frozen=True)
class ModeEntry:
    """A mode in which the action steers an inner law.

    Attributes:
        name: of the mode.
        controller: the baseline that runs inside, with its `tuned` gains.
        fields: the parts of an action, from the number of joints.
        summary: one line for listings.
    """

    name: str
    controller: str
    fields: Callable[[int], Fields]
    summary: str


MODES = {
    entry.name: entry
    for entry in (
        ModeEntry("joint_position", "joint_pd", _joint_offset, "moves the reference of joint PD control"),
        ModeEntry(
            "joint_inverse_dynamics",
            "joint_inverse_dynamics",
            _joint_offset,
            "moves the reference of joint-space inverse dynamics",
        ),
        ModeEntry(
            "operational_position",
            "operational_pd",
            _pose_offset,
            "moves the reference of operational-space PD control",
        ),
        ModeEntry("impedance", "impedance", _pose_offset, "moves the reference of impedance control"),
        ModeEntry(
            "variable_stiffness",
            "impedance",
            lambda _: (_POSE_OFFSET, _STIFFNESS_FACTOR),
            "moves the reference of impedance control and sets its stiffness",
        ),
        ModeEntry(
            "variable_impedance",
            "impedance",
            lambda _: (_POSE_OFFSET, _STIFFNESS_FACTOR, _DAMPING_FACTOR),
            "moves the reference of impedance control and sets its stiffness and damping",
        ),
        ModeEntry("admittance", "admittance", _pose_offset, "moves the reference of admittance control"),
        ModeEntry(
            "force_position",
            "parallel_force_position",
            lambda _: (_STIFF_POSE_OFFSET, _FORCE_OFFSET),
            "moves position and force of parallel force/position control",
        ),
        ModeEntry(
            "variable_force_position",
            "parallel_force_position",
            lambda _: (_APPROACH_FACTOR, _BANDWIDTH_FACTOR),
            "sets how fast parallel force/position control approaches and corrects",
        ),
    )
}
"""The modes that move what a law takes for desired, by name."""


def list_action_modes(layout: ObservationLayout | None = None) -> list[str]:
    """Names of the modes, or of those that an environment can have.

    Args:
        layout: `env.unwrapped.observation_layout`; all modes without it.
    """
    controllers = list_baselines(layout)
    steered = [entry.name for entry in MODES.values() if entry.controller in controllers]
    return [TORQUE, *steered, *(f"{RESIDUAL}{controller}" for controller in controllers)]


def make_action_mode(name: str, task: Task, torque_limit: Array, period: float) -> ActionMode:
    """A mode beside `torque`, for a task.

    Args:
        name: see `list_action_modes`.
        task: whose observations the inner law will read.
        torque_limit: joint torques at 1 (joints) [N m, N, N m].
        period: of the inner law [s].

    Raises:
        UnknownNameError: no such mode.
        MissingFieldError: the task does not show what the inner law reads.
    """
    names = list_action_modes()[1:]
    if name not in names:
        raise UnknownNameError("action_mode", name, (TORQUE, *names))
    interface = ControlInterface(
        task.environment_id, task.layout, torque_limit, period, task.model, task.target_impedance
    )
    if name.startswith(RESIDUAL):
        field = residual_field(torque_limit, task.model.parameters.torque_limit)
        return ResidualMode(name.removeprefix(RESIDUAL), field, interface)
    entry = MODES[name]
    return SteeredController(entry.controller, entry.fields(len(torque_limit)), interface, SMOOTHING_TIME)


def residual_field(torque_limit: Sequence[float] | Array, nominal: Sequence[float]) -> ActionField:
    """The action of the residual modes.

    Args:
        torque_limit: joint torques at 1 (joints) [N m, N, N m].
        nominal: the robot's own limits (joints): where the actuators are given more than these, or no limit
            at all, the share is one of these.
    """
    bound = tuple(RESIDUAL_SHARE * min(pair) for pair in zip(torque_limit, nominal, strict=True))
    units = TORQUE_UNITS[: len(bound)]
    return ActionField("residual_torque", units, "joint", bound, "added to the torques of the law")
